"""A session without any page: pushed, dragged, tilted, rebuilt; and its clock."""

from threading import Event

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.contact.ground import Ground
from plantigrade.control import Posture
from plantigrade.control.choices import ControllerKind
from plantigrade.errors import ParameterError
from plantigrade.live import frame
from plantigrade.live import session as live
from plantigrade.live.clock import MAX_LAG, Clock, LoopPace
from plantigrade.live.session import Choice, Session
from plantigrade.models import Human
from plantigrade.record import Provenance
from plantigrade.workflows.live import SessionWorlds
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.workflows.simulation_start import Start
from plantigrade.world import Controller, Drawing, Rates, StablePD, Target
from plantigrade.world.model_mismatch import ModelMismatch

HUMAN = Human.create(1.7, 65.0, "female", "42", "rigid")
HOW = SimulateSettings(rate=300.0, control_rate=50.0)


@pytest.fixture(scope="module")
def stage():
    """What makes the worlds."""
    return SessionWorlds(
        Start(HUMAN, Ground(), "standing", Provenance("", {})), ModelMismatch(), HOW
    )


@pytest.fixture
def session(stage):
    """A person who stands."""
    return Session(stage, stage.choice)


class Offering(Controller):
    """A controller that holds a posture, with a target and a drawing."""

    def __init__(self):
        self.targets = (Target("bend", 0.0, 30.0, 0.0, "deg"),)

    def __call__(self, state):
        target = state.human.standing()[7:]
        target[state.human.hinge("elbow_flex_r")] = np.deg2rad(self.targets[0].value)
        return StablePD(target)

    def drawings(self, state):
        return [Drawing(name="centre of mass", points=state.body.com[None])]


def test_only_whole_control_steps_are_simulated_and_none_while_paused(session):
    assert session.advance(0.05) == pytest.approx(0.04)
    assert session.frame.time == session.world.time == pytest.approx(0.04)
    session.submit(session.step)
    session.advance(1.0)
    assert session.paused and session.world.time == pytest.approx(0.06)
    session.submit(session.restart)
    session.advance(1.0)
    assert session.world.time == 0.0 and session.frame.time == 0.0


def test_a_push_moves_the_body_where_it_is_to_and_is_recorded(session):
    session.advance(0.2)
    session.hand.max_force = 150.0
    session.submit(lambda: session.push(np.pi / 2, 0.1))
    before = session.frame.com
    session.advance(0.3)
    moved = session.frame.com - before
    assert moved[1] > 0.01 and abs(moved[0]) < 0.2 * moved[1]
    record = session.record()
    pushed = [i for i, site in enumerate(record.sites) if site.part == "push"]
    force = record.contact_force[:, pushed].sum(axis=1)
    assert len(pushed) == 1 and np.count_nonzero(force[:, 1]) == 5  # 0.1 s at 50 Hz
    np.testing.assert_allclose(force[force[:, 1] > 0], [[0.0, 150.0, 0.0]] * 5, atol=1e-9)


def test_a_dragged_body_follows_the_hand_with_no_more_than_is_allowed(session):
    hand = HUMAN.body("forearm_r")
    at = session.world.data.xpos[hand] + [0.0, 0.0, -0.2]  # near the wrist
    session.hand.max_force = 20.0
    session.submit(lambda: session.hold(hand, at, at))
    session.submit(lambda: session.pull(at + [0.4, 0.0, 0.1]))
    session.advance(0.4)
    np.testing.assert_allclose(session.frame.rope[1], at + [0.4, 0.0, 0.1])
    assert (session.frame.rope[0] - at)[0] > 0.02
    record = session.record()
    pulled = next(i for i, s in enumerate(record.sites) if s.name == "push_forearm_r")
    size = np.linalg.norm(record.contact_force[:, pulled], axis=1)
    assert size.max() == pytest.approx(20.0) and size.max() <= 20.0 + 1e-9
    held = record.contact_point[size > 0, pulled]
    np.testing.assert_allclose(held[-1], session.frame.rope[0], atol=0.02)
    turned = record.motion.qpos[-1, 7 + HUMAN.hinge("elbow_flex_r")]
    assert turned > record.motion.qpos[0, 7 + HUMAN.hinge("elbow_flex_r")] + 0.005
    assert pg.check(record).measures["root_force"].value < 0.1  # the moment is recorded, too
    session.submit(lambda: session.hand.hold(None))
    session.advance(0.02)
    assert session.frame.rope is None
    with pytest.raises(ParameterError, match="no body 0"):
        session.hold(0, at, at)


def test_the_ground_tilts_to_the_target_and_is_level_again_after_a_restart(session):
    session.submit(lambda: session.tilt(np.deg2rad(2.0), np.deg2rad(-1.0)))
    session.advance(1.6)
    place = session.record().signals["ground.place"]
    np.testing.assert_allclose(place[-1], [0.0, 0.0, *np.deg2rad([2.0, -1.0])], atol=1e-3)
    rate = np.diff(place[:, 2]) * 50.0
    assert rate.min() > -0.01 and rate[0] < 0.5 * rate.max()  # no jerk, no overshoot
    assert session.world.fall is None
    session.submit(session.restart)
    session.advance(0.1)
    assert np.abs(session.record().signals["ground.place"]).max() < 1e-3


def test_on_ice_a_pushed_person_slides(stage):
    way = []
    for friction in (0.8, 0.03):
        session = Session(stage, stage.choice)
        session.hand.max_force = 120.0
        session.submit(lambda session=session, mu=friction: session.set_friction(mu))
        session.submit(lambda session=session: session.push(0.0, 0.2))
        foot, start = HUMAN.body("foot_r"), session.frame
        session.advance(0.4)
        way.append((session.frame.positions - start.positions)[foot, 0])
        record = session.record()
        assert set(record.signals["live.friction"]) == {friction}
        assert record.ground.friction == 0.8  # the greatest there was, from the start on
    assert abs(way[0]) < 0.005 and way[1] > 0.03


def test_another_body_stands_where_the_last_one_was(session):
    session.hand.max_force = 60.0
    session.push(0.3, 0.3)
    session.advance(0.4)
    x, y, _ = session.world.data.qpos[:3]
    session.submit(lambda: session.choose(Choice("posture", "two-segment", "42")))
    session.advance(0.3)
    human = session.world.human
    assert (human.feet, human.mass, human.height) == ("two-segment", HUMAN.mass, HUMAN.height)
    assert human.dimensions == HUMAN.dimensions or np.allclose(
        human.dimensions.as_array(), HUMAN.dimensions.as_array()
    )
    assert session.world.time == pytest.approx(0.3) and session.world.fall is None
    np.testing.assert_allclose(session.world.data.qpos[:2], [x, y], atol=0.1)
    assert "recording so far is lost" in session.message


def test_what_cannot_be_is_said_and_nothing_changes(session):
    before = session.choice
    session.submit(lambda: session.choose(Choice("stable-pd", "rigid", "42")))
    session.advance(0.1)
    assert "stable-pd needs a motion" in session.message and session.choice == before
    assert session.world.time == pytest.approx(0.1)
    session.submit(lambda: session.choose(Choice("passive", "rigid", "42")))
    session.advance(1.5)
    assert session.frame.end_message.startswith("fell at") and not session.paused


def test_the_targets_and_drawings_of_a_controller_are_offered():
    begin = Start(HUMAN, Ground(), "standing", Provenance("", {}))
    stage = SessionWorlds(begin, ModelMismatch(), HOW, own=Offering())
    session = Session(stage, stage.choice)
    assert session.choice.controller == "Offering"
    (bend,) = session.targets
    session.advance(0.1)
    session.submit(lambda: bend.set(25.0))
    session.advance(0.5)
    angle = session.frame.history.angles[-1, HUMAN.hinge("elbow_flex_r")]
    assert np.rad2deg(angle) == pytest.approx(25.0, abs=3.0)
    (drawn,) = session.frame.drawings
    np.testing.assert_allclose(drawn.points[0], session.frame.com, atol=5e-3)
    assert list(np.unique(session.record().signals["live.bend"])) == [0.0, 25.0]


def test_a_controller_that_fails_pauses_and_says_so(stage):
    broken = SessionWorlds(stage.first, ModelMismatch(), HOW, own=lambda state: np.zeros(3))
    session = Session(broken, broken.choice)
    session.advance(0.1)
    assert session.paused and session.world.time == 0.0 and "torque" in session.message


def test_the_last_seconds_are_kept(stage, monkeypatch):
    monkeypatch.setattr(frame, "HISTORY_DURATION", 0.5)
    session = Session(stage, stage.choice)
    session.advance(1.3)
    past = session.frame.history
    np.testing.assert_allclose(past.time, np.arange(0.82, 1.301, 0.02), atol=1e-9)
    weight = HUMAN.mass * 9.81
    assert past.vertical[-1].sum() == pytest.approx(weight, rel=0.02)
    assert np.isfinite(past.cop).all() and past.angles.shape[1] == len(HUMAN.coordinates)


def test_a_clock_gives_up_what_a_slow_machine_owes():
    ticks = iter([0.0, 0.02, 0.04, 0.34, 0.36])
    clock = Clock(now=lambda: next(ticks))
    assert clock.time_due(1.0) == pytest.approx(0.02)
    clock.mark_simulated(0.02)
    assert clock.time_due(0.5) == pytest.approx(0.01)
    assert clock.real_time_factor == 1.0
    assert clock.time_due(1.0) == pytest.approx(MAX_LAG)  # 0.31 s, of which a little is done
    assert clock.time_lost == pytest.approx(0.26)
    assert clock.real_time_factor == pytest.approx(1.0 - 0.26 / 0.33)
    assert clock.time_due(0.0) == 0.0 and clock.real_time_factor == 1.0  # paused


def test_a_late_turn_is_made_up_for_and_a_lost_one_is_not():
    ticks = iter([0.0, 0.004, 0.03, 0.05, 0.52])
    pace = LoopPace(50.0, now=lambda: next(ticks))
    assert pace.time_to_wait() == pytest.approx(0.016)  # until 0.02
    assert pace.time_to_wait() == pytest.approx(0.01)  # 0.01 s late: until 0.04
    assert pace.time_to_wait() == pytest.approx(0.01)  # again: until 0.06
    assert pace.time_to_wait() == 0.0  # half a second was lost, and is


def test_the_loop_goes_on_until_it_is_stopped(session):
    stop, done = Event(), []

    class Ticking(Clock):
        def mark_simulated(self, simulated):
            super().mark_simulated(simulated)
            done.append(simulated)
            if len(done) == 3:
                stop.set()

    ticks = iter(np.arange(0.0, 1.0, 0.02))
    live.run(session, stop, Ticking(now=lambda: float(next(ticks))))
    assert len(done) == 3 and session.world.time == pytest.approx(sum(done)) and sum(done) > 0.0


def test_a_controller_that_wants_commands_more_often_starts_anew(stage, monkeypatch):
    class Fast(Posture):
        rates = Rates(physics=300.0, control=150.0)

    how = SimulateSettings(rate=300.0)
    stage = SessionWorlds(stage.first, ModelMismatch(), how)
    monkeypatch.setattr(
        "plantigrade.control.choices.CONTROLLERS",
        {
            "posture": ControllerKind(lambda at: Posture()),
            "fast": ControllerKind(lambda at: Fast()),
        },
    )
    session = Session(stage, stage.choice)
    session.advance(0.1)
    session.submit(lambda: session.choose(Choice("fast", "rigid", "42")))
    session.advance(0.0)
    assert session.world.control_rate == 150.0 and session.world.time == 0.0
    assert "has restarted" in session.message
    session.submit(lambda: session.choose(Choice("posture", "rigid", "42")))
    session.advance(0.1)
    assert session.world.control_rate == 150.0 and session.world.time == pytest.approx(
        0.1, abs=0.01
    )


def test_a_load_is_put_on_and_taken_off(session):
    model, human = session.world.model, session.world.human
    body = human.body(human.trunk)
    own, place = float(model.body_mass[body]), model.body_ipos[body].copy()
    inertia = np.sort(model.body_inertia[body])
    session.set_load(12.0)
    assert session.load == 12.0
    assert model.body_mass[body] == pytest.approx(own + 12.0)
    moved = model.body_ipos[body] - place
    assert moved == pytest.approx(12.0 / (own + 12.0) * np.array([-0.2, 0.0, 0.05]))
    grown = model.body_inertia[body].sum() - inertia.sum()  # twice the reduced mass, squared arm
    assert grown == pytest.approx(2 * own * 12.0 / (own + 12.0) * (0.2**2 + 0.05**2))
    session.restart()
    assert session.load == 0.0 and model.body_mass[body] == pytest.approx(own)
    assert np.sort(model.body_inertia[body]) == pytest.approx(inertia)
    with pytest.raises(ParameterError, match="load must be 0–60 kg"):
        session.set_load(200.0)

"""The test that every controller is put to: who walks, what is withstood, what a tour is."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.altered_people import scaled_legs, scaled_strength, torque_limits
from experiments.human_pushes import aside
from experiments.tour import MAX_PUNCH_FORCE, punches, tour, waypoints
from experiments.walk_outcome import WalkOutcome
from experiments.walk_trial import PushedWalk, walk
from experiments.walkers import walker, walks_as
from experiments.walking import walking
from plantigrade import synthesize
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.control import passive
from plantigrade.errors import ParameterError
from plantigrade.kinematics.sole_paths import lowest
from plantigrade.kinematics.state import BodyState
from plantigrade.kinematics.transfer import leg_length, transferred
from plantigrade.models import Human
from plantigrade.record import Record
from plantigrade.world import Command, Controller, PhasePush, Push, Rates
from tests.textbook import walk_record


@pytest.fixture(scope="module")
def record() -> Record:
    """The textbook walk, open."""
    human = Human.create(1.7, 65.0, "female", "42", "rigid")
    return walk_record(human, speed=1.2, rate=60.0, cycles=2)


@pytest.fixture(scope="module")
def falling(record):
    """Somebody whom nothing moves."""
    return walker(lambda _: passive, record, "nothing")


def walked(speed, height, *, survived=True, pushed=(2.0, 2.4)) -> WalkOutcome:
    """A walk of 1 m/s, period 1 s and height 1 m, with these speeds and heights every 10 ms."""
    speed, height = np.array(speed), np.array(height)
    com = np.stack([0.01 * np.cumsum(speed), np.zeros(len(speed)), height], axis=1)
    time = 0.01 * np.arange(1, len(speed) + 1)
    none = np.full(len(speed), np.nan)
    end = "" if survived else "fell"
    return WalkOutcome(survived, end, time, com, none, (), pushed, 1.0, 1.0, 1.0)


def test_who_is_back_to_the_gait_walks_at_its_speed_and_height_from_then_on():
    one = np.ones(800)
    assert walked(one, one).back == 0.0 and walked(one, one).withstood
    slow = one.copy()
    slow[240:440] = 0.5  # until 2 s after the push; a stride of it is too slow until 2.6 s after
    assert walked(slow, one).back == pytest.approx(2.6, abs=0.02)
    assert walked(one, one + 0.06).back is None and walked(one, one + 0.04).withstood
    assert walked(0.75 * one, one).back is None
    late = one.copy()
    late[720:] = 0.5  # was back, but not for good
    assert walked(late, one).back is None
    assert walked(one, one, survived=False).back is None
    assert walked(one[:50], one[:50]).back is None, "not even a stride"


def test_who_falls_has_not_survived_and_without_gait_no_push_comes(falling):
    push = PhasePush(force=1.0, duration=0.1, side="r", phase=0.0)
    found = walk(falling, (push,))
    assert not found.survived and found.end.startswith("fell at") and found.pushed is None
    assert found.seconds < 3.0 and found.back is None and np.isnan(found.rms)
    never = PushedWalk(falling, 0.3)
    assert never.begin is None and not never(100.0, 0.0, 0.4).withstood
    assert never(100.0, 0.0, 0.4).end == found.end


def test_a_controller_has_the_world_it_wants_and_its_own_error_is_kept(record):
    seen = []

    class Mine(Controller):
        rates, passive = Rates(400.0, 100.0), False

        def __call__(self, state):
            seen.append((state.world.rate, state.world.control_rate))
            return Command(signals={"tracking_error": 0.25})

    one = walker(lambda _: Mine(), record)
    found = walk(one, (Push(force=1.0, duration=0.02, time=0.02),), watch=0.06)
    assert set(seen) == {(400.0, 100.0)}
    assert found.rms == pytest.approx(0.25) and found.seconds == pytest.approx(0.10)
    assert found.pushed == (0.02, pytest.approx(0.04))
    again = walk(one, duration=0.05, noise=0.1, seed=1)
    assert len(again.time) == 5 and not np.allclose(again.com[-1], found.com[4])


def test_controllers_by_word(record, tmp_path):
    path = tmp_path / "mine.py"
    path.write_text("def still(record):\n    return lambda state: None\n\ndef bad(record): ...\n")
    one = walker(f"{path}:still", record)
    assert one.name.endswith(":still") and callable(one.make(one.record))
    law = walker("pendulum:energy", record)
    assert law.make(law.record).settings.law == "energy"
    policy = walker("learned:two-segment")  # has its own person and walk
    assert policy.record.human.feet == "two-segment" and 0.5 < policy.speed < 2.0
    assert callable(policy.make(policy.record))
    with pytest.raises(ParameterError, match="needs a walk"):
        walker("pendulum")
    for word, message in (
        ("learned:none", "learned walks on feet="),
        ("moon", "no controller 'moon'; there are passive"),
        ("pendulum:moon", "no landing law"),
        (f"{path}:nobody", "no function or class 'nobody'"),
        (f"{tmp_path}/none.py:a", "there is no file"),
        ("no.such.module:a", "ModuleNotFoundError"),
    ):
        with pytest.raises(ParameterError, match=message):
            walker(word, record)
    assert walks_as("pendulum", record).record.human is record.human
    own = replace(record, human=Human.create(1.6, 55.0, "female", "42", "rigid"))

    class Policy:
        record = own

        def __call__(self, walk):
            return passive

    assert walker(Policy(), record).record is own
    with pytest.raises(ParameterError, match="defines its own person"):
        walks_as(Policy(), record)
    with pytest.raises(ParameterError, match="returned no controller"):
        walker(f"{path}:bad", record).make(record)


def test_a_walk_on_another_body_is_dynamically_similar(record):
    tall = Human.create(1.9, 90.0, "male", "42", "rigid")
    other = transferred(record, tall)
    scale = leg_length(tall) / leg_length(record.human)
    assert other.motion.duration == pytest.approx(np.sqrt(scale) * record.motion.duration)
    turned = np.abs(other.motion.qpos[:, 7:] - record.motion.qpos[:, 7:]).max(axis=0)
    legs = ("hip", "knee", "ankle", "subtalar")  # they reach for the ground
    legged = np.array([name.startswith(legs) for name in tall.coordinates])
    assert 0.0 < turned[legged].max() < np.deg2rad(15.0) and turned[~legged].max() < 1e-12
    soles = [lowest(r.human, r.motion.qpos) for r in (record, other)]
    np.testing.assert_allclose(soles[1], scale * soles[0], atol=1e-3)
    way = [r.motion.qpos[-1, 0] - r.motion.qpos[0, 0] for r in (record, other)]
    assert way[1] == pytest.approx(scale * way[0])
    speeds = [
        walker("pendulum", r).speed for r in (record, other, transferred(record, tall, faster=1.2))
    ]
    assert speeds[1] == pytest.approx(np.sqrt(scale) * speeds[0], rel=0.02)
    assert speeds[2] == pytest.approx(1.2 * speeds[1], rel=0.02)


def test_feet_on_longer_legs_do_not_cross_and_large_feet_do_not_throw_the_body_up(record):
    human = record.human
    long, short = (transferred(record, scaled_legs(human, times)) for times in (1.8, 0.6))
    inward = []  # of the right foot from its hip, along the pelvis
    for own in (record, long):
        bodies = [own.human.body(f"{b}_{s}") for b in ("foot", "femur") for s in SIDES]
        places = [BodyState(own.human, qpos).origins[bodies, :2] for qpos in own.motion.qpos[::10]]
        inward.append([(x[0] - x[2]) @ (x[3] - x[2]) / np.linalg.norm(x[3] - x[2]) for x in places])
    np.testing.assert_allclose(inward[1], inward[0], atol=1e-3)
    soles = [lowest(r.human, r.motion.qpos) for r in (record, short)]
    np.testing.assert_allclose(soles[1], 0.6 * soles[0], atol=0.01)
    time = short.motion.time
    height = np.array([BodyState(short.human, qpos).com[2] for qpos in short.motion.qpos])
    fall = -np.gradient(np.gradient(height, time), time)[4:-4]
    assert fall.max() < 0.9 * GRAVITY  # else nobody could walk so
    shank = next(
        g for g in range(long.human.model.ngeom)
        if long.human.model.geom_bodyid[g] == long.human.body("tibia_r")
    )  # fmt: skip
    assert long.human.model.geom_size[shank, 0] < long.human.dimensions.ankle_height


def test_longer_legs_and_stronger_joints_change_nothing_else(record):
    human = record.human
    long = scaled_legs(human, 1.5)
    assert leg_length(long) == pytest.approx(1.5 * leg_length(human)) and long.mass == human.mass
    assert long.dimensions.foot_length == human.dimensions.foot_length
    with pytest.raises(ParameterError, match="height"):
        scaled_legs(human, 3.0)
    strong = scaled_strength(human, 2.0)
    np.testing.assert_allclose(
        strong.model.jnt_actfrcrange, 2.0 * human.model.jnt_actfrcrange, rtol=1e-6
    )
    np.testing.assert_allclose(strong.model.body_mass, human.model.body_mass)
    assert torque_limits(human)["ankle_angle"][0] < 0.0 < torque_limits(human)["ankle_angle"][1]


def test_a_tour_has_a_punch_on_every_leg_and_turns_only_for_controllers_that_follow(
    record, falling
):
    rng = np.random.default_rng(3)
    goals = waypoints(falling.speed, rng)
    far = np.linalg.norm(np.diff(goals, axis=0, prepend=[[0.0, 0.0]]), axis=1)
    np.testing.assert_allclose(far, 0.8 * 5.0 * falling.speed)
    assert goals[0, 1] == 0.0 and np.ptp(goals[:, 1]) > 1.0
    assert np.ptp(waypoints(falling.speed, rng, straight=True)[:, 1]) == 0.0
    goals_seen = []

    class Follows(Controller):
        def follow(self, points):
            goals_seen.append(points)
            return True

        def __call__(self, state):
            return None

    found = tour(walker(lambda _: Follows(), record), seed=3, n=2)
    assert not found.completed and found.reached == 0 and found.end.startswith("fell")
    assert not found.straight and goals_seen[0].shape == (2, 2) and len(found.punches) <= 2
    assert tour(falling, seed=3, n=2).straight
    every = punches(falling.record.human.body_names, np.random.default_rng(0))
    assert [int(p.time // 5.0) for p in every] == list(range(12))
    assert max(p.force for p in every) <= MAX_PUNCH_FORCE and len({p.body for p in every}) > 4


@pytest.mark.slow
def test_a_push_after_a_copied_walk_is_the_same_as_after_a_walk_of_its_own(data):
    from plantigrade.workflows.fit import fit_trial

    recorded = fit_trial(data / "cmu_asfamc" / "16_15.amc")[1].record()
    one = walker("pendulum", recorded)
    test = PushedWalk(one, 0.3)
    found = test(60.0, 0.0, 0.4, watch=0.5)
    assert test.begin is not None
    push = Push(force=60.0, duration=0.4, direction=0.0, time=test.begin)
    own = walk(one, (push,), watch=0.5)
    n = len(own.time)
    np.testing.assert_array_equal(found.com[:n], own.com)
    assert found.withstood and found.pushed == pytest.approx(own.pushed)
    assert [x.time for x in own.landings] == [x.time for x in found.landings][: len(own.landings)]
    assert replace(found, survived=False).back is None


@pytest.mark.slow
def test_a_survived_push_lands_softly(data):
    """Feet that step out on a straight leg landed with 10 to 20 body weights on rigid soles."""
    one = walking("pendulum", data)
    found = [PushedWalk(one, phase)(150.0, np.pi / 4, 0.4, watch=3.0) for phase in (0.0, 0.5, 0.75)]
    found.append(PushedWalk(one, 0.75)(300.0, 1.75 * np.pi, 0.4, watch=1.0))  # forefoot: 6.9
    assert all(outcome.survived for outcome in found)
    assert max(outcome.peak for outcome in found) < 6.0
    assert max(outcome.bend for outcome in found) < 25.0  # the trunk as a free flywheel: 29°


@pytest.mark.slow
def test_a_slow_walk_takes_a_push_aside_in_few_steps():
    """Its rear foot is lifted long before the motion's; it had wandered 1.25 m in ten steps."""
    found = synthesize("walk", speed=0.7, periodic=True, height=1.7, mass=65.0, sex="female")
    one = walker("pendulum", found.record)
    push = PhasePush(force=195.0, duration=0.2, direction=np.pi / 2, side="r", phase=0.15)
    found = walk(one, (push,), watch=4.0)
    distance, _, steps = aside(found, 1.0)
    assert found.withstood and distance < 0.6 and steps <= 4  # people: 0.42 ± 0.17 m

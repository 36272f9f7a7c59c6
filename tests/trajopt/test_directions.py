"""Walking backward and sideways: plans, first guesses, and the motions themselves."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.contact.plan import Footprint, Stance
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.trajopt import ContactBody, MotionTask, make_task
from plantigrade.trajopt.warm_start import WarmStart


@cache
def person() -> Human:
    return Human.create(1.72, 68.0, joints="42", feet="rigid")


@cache
def task(name: str) -> MotionTask:
    return make_task(name, person())


def test_backward_toes_land_first_and_the_heel_leaves_last():
    for stance in task("walk-backward").plan.stances:
        heel, toe = stance.interval("heel"), stance.interval("toe")
        assert toe[0] < heel[0]
        assert toe[1] < heel[1]


def test_time_reversed_twice_is_the_same():
    stance = Stance(Footprint("r", (0.1, -0.1, 0.0)), 0.0, 0.1, 0.4, 0.5, 0.6)
    assert stance.reversed(1.0).reversed(1.0).times == pytest.approx(stance.times)
    for part in ("heel", "sole", "ball", "toe"):
        start, stop = stance.interval(part)
        assert stance.reversed(1.0).interval(part) == pytest.approx((1.0 - stop, 1.0 - start))


@pytest.mark.parametrize(
    ("name", "way"), [("walk-backward", (-1, 0)), ("walk-sideways", (0, -1))], ids=str
)
def test_every_stance_goes_on_after_a_period(name, way):
    plan = task(name).plan
    assert np.allclose(np.sign([plan.advance, plan.aside]), way)
    stride = plan.full_stride()
    for side in "rl":
        own = [s for s in stride.unrolled() if s.footprint.side == side]
        strikes = np.diff([s.heel_strike for s in own])
        places = np.diff([s.footprint.position for s in own], axis=0)
        assert np.allclose(strikes, stride.duration)
        assert np.allclose(places, [stride.advance, stride.aside, 0.0])


def test_a_mirrored_plan_does_not_lead_aside():
    with pytest.raises(ParameterError, match="mirrored"):
        replace(task("walk-backward").plan, aside=0.1)


@pytest.mark.parametrize("name", ["walk-backward", "walk-sideways"])
def test_feet_of_the_guess_are_near_their_footprints(name):
    motion = task(name)
    plan, body = motion.plan, ContactBody.for_plan(person(), motion.plan)
    times = np.linspace(0.0, plan.duration, 23, endpoint=False)
    qpos = person().from_coordinates(body.symbolic.names, motion.guess(body, plan, times))
    seen = 0
    for stance in plan.stances:
        flat = stance.heel_off if stance.backward else stance.foot_flat
        still = stance.forefoot_off if stance.backward else stance.heel_off
        for t, q in zip(times, qpos, strict=True):
            if flat + 0.05 < t < still - 0.05:
                points = PointSet(person(), [f"foot_{stance.footprint.side}"], np.zeros((1, 3)))
                ankle = BodyState(person(), q).position(points)[0]
                away = np.hypot(*(ankle[:2] - stance.footprint.position[:2]))
                assert away < 0.05
                seen += 1
    assert seen > 10


@pytest.mark.parametrize(
    ("name", "parameters", "match"),
    [
        ("walk-backward", {"speed": 3.0}, "speed"),
        ("walk-backward", {"step_length": 0.5, "cadence": 100}, "leave out"),
        ("walk-sideways", {"cadence": 40.0}, "stride"),
        pytest.param("walk-sideways", {"side": "x"}, "side", marks=pytest.mark.wrong_types),
    ],
)
def test_what_nobody_walks_is_refused(name, parameters, match):
    with pytest.raises(ParameterError, match=match):
        make_task(name, person(), parameters)


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.parametrize(
    ("name", "parameters", "direction", "speed"),
    [
        ("walk-backward", {}, "backward", 0.95),
        ("walk-sideways", {}, "sideways", 0.57),
        ("walk-sideways", {"side": "l"}, "sideways", 0.57),
    ],
)
def test_the_walks_pass_and_are_not_compared_with_walking_forward(
    name, parameters, direction, speed
):
    run = pg.synthesize(name, height=1.65, mass=60.0, **parameters)
    assert run.status == "ok"
    assert run.figures["walking_direction"] == direction
    assert run.figures["walking_speed_m_s"] == pytest.approx(speed, abs=0.02)
    assert not any("norm" in key or "gps" in key for key in run.figures)
    start = run.record.motion.qpos[[0, -1], :2]
    ahead, left = start[1] - start[0]
    assert (ahead < -0.5) if direction == "backward" else (abs(ahead) < 0.05)
    if direction == "sideways":
        assert np.sign(left) == (1.0 if parameters else -1.0)


@pytest.mark.slow
@pytest.mark.solver
def test_a_sideways_walk_is_a_warm_start(tmp_path):
    run = pg.synthesize("walk-sideways")
    warm = WarmStart.of_record(run.record)
    assert warm.problem.closure is not None
    column = warm.problem.names.index("pelvis_tz")
    assert warm.problem.closure.shift[column] == pytest.approx(0.57 * task_time(run), abs=1e-3)


def task_time(run) -> float:
    """Return the duration of a stride of a run of three [s]."""
    return run.record.motion.duration / 3

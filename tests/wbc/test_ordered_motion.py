"""Motions from ordered tasks: the equation each error obeys, priorities over time, impacts."""

from functools import cache

import numpy as np
import pytest

from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.wbc import JointLimits, TaskOrder, move, solve_hierarchy
from plantigrade.wbc.order import stacked
from plantigrade.wbc.stepping import MotionSettings, velocity_after_impact
from plantigrade.wbc.tasks import ComTask, ContactTask, FloorTask, PointTask, TimedPosture
from tests.models.presets import person

HAND = (0.0, 0.0, -0.08)


@pytest.fixture(scope="module")
def human():
    return person("42", "two-segment")


def soles_of(human):
    return SitePoints(human, contact_sites(human))


def standing(human, **gains):
    """Both feet flat on the ground, always."""
    points = soles_of(human)
    on = np.ones(len(points), dtype=bool)
    return ContactTask(points, lambda time: on, **gains)


def bent(human):
    """A posture in which no leg or arm is straight, both feet flat on the ground."""
    return bent_person(human.joints, human.feet).copy()


@cache
def bent_person(joints, feet):
    human = person(joints, feet)
    q = human.standing()
    bends = {"hip_flexion": 0.5, "knee_angle": 0.9, "ankle_angle": 0.4, "elbow_flex": 1.0}
    for side in ("r", "l"):
        for name, angle in bends.items():
            q[7 + human.hinge(f"{name}_{side}")] = angle
    points = soles_of(human)
    q[2] -= (points.height(BodyState(human, q))).min()
    q = move(human, TaskOrder([[standing(human)]]), q, stop=0.3).qpos[-1]
    assert np.abs(points.height(BodyState(human, q))).max() < 1e-3
    return q


@pytest.mark.parametrize("stiffness", [100.0, 400.0])
@pytest.mark.parametrize("damping", [None, 5.0])
def test_an_error_obeys_its_equation(human, stiffness, damping):
    """e'' = -kp e - kd e' from e = 0 with a velocity: a decaying wave, in closed form."""
    q = bent(human)
    here = BodyState(human, q).com
    task = ComTask(Trajectory.fixed(here), stiffness=stiffness, damping=damping)
    start = np.zeros(human.model.nv)
    start[:3] = 0.3, -0.2, -0.3
    motion = move(
        human, TaskOrder([[task]]), q, start, stop=0.5, settings=MotionSettings(step=0.001)
    )
    state = BodyState(human, q)
    e = np.array([task.error(state.moved_to(x, v), 0.0) for x, v in zip(motion.qpos, motion.qvel,
                                                                     strict=True)])  # fmt: skip
    first = BodyState(human, motion.qpos[0], start)
    rate = first.com_jacobian @ start
    t, root = motion.time, np.emath.sqrt(task.damping**2 / 4 - stiffness)
    decay = np.exp(-task.damping * t / 2)
    wave = t if abs(root) < 1e-9 else np.real(np.sinh(root * t) / root)
    np.testing.assert_allclose(e, np.outer(decay * wave, rate), atol=4e-4)
    assert np.abs(e).max() > 0.005


def test_a_moving_target_is_followed_without_lag(human):
    """Velocity and acceleration of the target are fed forward."""
    q = bent(human)
    here = BodyState(human, q).com
    time = np.linspace(0, 1, 200)
    circle = np.stack([1 - np.cos(9 * time), np.sin(9 * time) - 9 * time * np.exp(-40 * time),
                       0 * time], axis=1)  # fmt: skip
    task = ComTask(Trajectory(time, here + 0.05 * circle))
    motion = move(human, TaskOrder([[task]]), q, stop=1.0, settings=MotionSettings(step=0.002))
    state = BodyState(human, q)
    late = [
        np.linalg.norm(task.error(state.moved_to(x, v), float(t)))
        for t, x, v in zip(motion.time, motion.qpos, motion.qvel, strict=True)
        if t > 0.5
    ]
    assert max(late) < 5e-4


def test_lower_tasks_change_nothing_above(human):
    """The same start with and without a task below: feet and centre of mass go as before."""
    alone, below = squat(human), squat(human, [0.3, -0.1, 0.3])
    points = soles_of(human)
    state, still = BodyState(human, alone.qpos[0]), np.zeros(human.model.nv)
    for a, b in zip(alone.qpos, below.qpos, strict=True):
        one, other = state.moved_to(a, still), state.moved_to(b, still)
        assert np.linalg.norm(other.com - one.com) < 1e-4
        assert np.abs(other.position(points) - one.position(points)).max() < 1e-4
    assert np.abs(alone.qpos[-1] - below.qpos[-1]).max() > 0.2  # and the rest goes elsewhere


def test_an_impossible_task_below_changes_no_residual_above(human):
    """At every state of a motion that strains against its limits, with and without the task."""
    motion = squat(human, [0.5, -0.3, 0.9])  # out of reach
    assert motion.residual[:, 2].max() > 1.0 and not motion.exact.all()
    contact, com, hand = squat_tasks(human, [0.5, -0.3, 0.9])
    limits = JointLimits(human, MotionSettings.step)
    state = BodyState(human, motion.qpos[0])
    for k in range(0, len(motion.time), 5):
        state = state.moved_to(motion.qpos[k], motion.qvel[k])
        contact.begin(state, float(motion.time[k]))
        low, high = limits.bounds(state)
        levels = [task.rows(state, float(motion.time[k])).level for task in (contact, com, hand)]
        two = solve_hierarchy(levels[:2], lower=low, upper=high, singular=MotionSettings.min_gain)
        three = solve_hierarchy(levels, lower=low, upper=high, singular=MotionSettings.min_gain)
        np.testing.assert_allclose(three.residuals[:2], two.residuals, atol=1e-6)


def squat_tasks(human, way):
    """Feet, centre of mass on its way down, a hand led by ``way`` [m] in 0.4 s."""
    q = bent(human)
    hand = PointSet(human, ["hand_r"], np.array([HAND]))
    state = BodyState(human, q)
    time = np.linspace(0, 0.4, 50)
    down = state.com + np.outer(0.08 * (time / 0.4) ** 3, [0.3, 0.0, -1.0])
    there = state.position(hand)[0] + np.outer((0.0, 1.0), way)
    led = PointTask(hand, Trajectory(np.array([0.0, 0.4]), there))
    return standing(human), ComTask(Trajectory(time, down)), led


def squat(human, way=None):
    """The motion of these tasks, in this order; without the hand where it is not led."""
    tasks = squat_tasks(human, (0, 0, 0) if way is None else way)
    order = TaskOrder([[task] for task in (tasks[:2] if way is None else tasks)])
    return move(human, order, bent(human), stop=0.4)


def test_contact_points_do_not_move(human):
    q = bent(human)
    here = BodyState(human, q).com
    time = np.linspace(0, 1, 100)
    sway = here + 0.06 * np.stack(
        [np.sin(6 * time) ** 3, 0 * time, -(np.sin(4 * time) ** 4)], axis=1
    )
    order = TaskOrder([[standing(human)], [ComTask(Trajectory(time, sway))]])
    motion = move(human, order, q, stop=1.0)
    points = soles_of(human)
    state = BodyState(human, q)
    place = np.array([state.moved_to(x, 0 * v).position(points).copy()
                      for x, v in zip(motion.qpos, motion.qvel, strict=True)])  # fmt: skip
    assert np.linalg.norm(place - place[0], axis=2).max() < 5e-4
    assert (place[..., 2] - points.radius).min() > -5e-4
    state = state.moved_to(motion.qpos[-1], motion.qvel[-1])
    assert np.linalg.norm(state.com - sway[-1]) < 1e-3


def test_nothing_sinks_into_the_floor(human):
    """The centre of mass is asked to sink; feet that nothing holds stay above the ground."""
    q = bent(human)
    here = BodyState(human, q).com
    time = np.linspace(0, 0.6, 30)
    sink = here + np.outer((time / 0.6) ** 3, [0.0, 0.0, -0.5])
    points = soles_of(human)
    order = TaskOrder([[FloorTask(points)], [ComTask(Trajectory(time, sink))]])
    motion = move(human, order, q, stop=0.6)
    state = BodyState(human, q)
    heights = [points.height(state.moved_to(x, 0 * v)).min()
               for x, v in zip(motion.qpos, motion.qvel, strict=True)]  # fmt: skip
    assert min(heights) > -2e-3
    assert min(heights) < 0.01  # they were pushed against it


def test_an_impact_stops_its_points_and_loses_energy(human):
    q = bent(human)
    rng = np.random.default_rng(0)
    for _ in range(10):
        before = rng.normal(size=human.model.nv)
        state = BodyState(human, q, before)
        contact = standing(human)
        order = TaskOrder([[contact], [ComTask(Trajectory.fixed(state.com))]])
        assert contact.begin(state, 0.0)
        after = velocity_after_impact(state, order, 0.0)
        M = state.mass_matrix
        on = contact.jacobian(state, 0.0)
        assert np.abs(on @ after).max() < 1e-6 * np.abs(on @ before).max()
        assert after @ M @ after < before @ M @ before
        # Carnot: what is lost is the energy of the lost velocity; no more is changed than needed.
        lost = before - after
        assert after @ M @ lost == pytest.approx(0.0, abs=1e-8 * (before @ M @ before))


def test_a_body_at_rest_that_touches_down_stays_at_rest(human):
    state = BodyState(human, bent(human))
    contact = standing(human)
    contact.begin(state, 0.0)
    np.testing.assert_allclose(
        velocity_after_impact(state, TaskOrder([[contact]]), 0.0), 0.0, atol=1e-9
    )


def test_straight_knees_are_survived(human):
    """Standing straight, asked to grow: the legs cannot, and nothing is thrown about for it."""
    q = human.standing()
    here = BodyState(human, q).com
    time = np.linspace(0, 0.5, 20)
    up = here + np.outer((time / 0.5) ** 3, [0.0, 0.0, 0.3])
    order = TaskOrder([[standing(human)], [ComTask(Trajectory(time, up))]])
    motion = move(human, order, q, stop=0.5)
    points = soles_of(human)
    state = BodyState(human, q)
    start = state.moved_to(motion.qpos[0], 0 * motion.qvel[0]).position(points).copy()
    for x, v in zip(motion.qpos, motion.qvel, strict=True):
        assert np.abs(state.moved_to(x, v).position(points) - start).max() < 2e-3
    assert np.isfinite(motion.qpos).all()
    low, high = human.limits
    assert (motion.qpos[:, 7:] > low - 2e-3).all() and (motion.qpos[:, 7:] < high + 2e-3).all()


def test_the_posture_takes_what_is_left(human):
    """Feet and centre of mass are held; an arm asked to rise does, a leg asked to does not."""
    q = bent(human)
    here = BodyState(human, q).com
    goal = q.copy()
    arm, knee = 7 + human.hinge("arm_flex_r"), 7 + human.hinge("knee_angle_r")
    goal[arm] += 0.8
    goal[knee] += 0.5
    order = TaskOrder(
        [[standing(human)], [ComTask(Trajectory.fixed(here))]],
        TimedPosture(lambda time: (goal, 1.0)),
    )
    motion = move(human, order, q, stop=1.0)
    assert motion.qpos[-1, arm] == pytest.approx(goal[arm], abs=0.1)
    state = BodyState(human, motion.qpos[-1])
    assert np.linalg.norm(state.com - here) < 1e-3
    assert motion.order.names[-1] == "posture"


def test_what_is_reported_is_what_happened(human):
    q = bent(human)
    here = BodyState(human, q).com
    calls = []
    order = TaskOrder([[standing(human)], [ComTask(Trajectory.fixed(here), name="com")]])
    motion = move(
        human,
        order,
        q,
        start=2.0,
        stop=2.3,
        settings=MotionSettings(step=0.01),
        progress=calls.append,
    )
    assert motion.order.names == ("contact", "com") == order.names
    np.testing.assert_allclose(motion.time, 2.0 + 0.01 * np.arange(31))
    assert motion.qpos.shape == (31, human.model.nq) and motion.qacc.shape == (31, human.model.nv)
    assert motion.active.all() and motion.residual.shape == (31, 2)
    assert (motion.solver_time > 0).all() and (motion.kinematics_time > 0).all()
    np.testing.assert_allclose(np.diff(motion.qvel, axis=0), 0.01 * motion.qacc[:-1], atol=1e-9)
    assert calls and 0.0 <= min(calls) <= max(calls) <= 1.0


def test_the_same_start_gives_the_same_motion(human):
    q = bent(human)
    order = TaskOrder([[standing(human)], [ComTask(Trajectory.fixed(BodyState(human, q).com))]])
    a, b = (move(human, order, q, stop=0.1) for _ in range(2))
    np.testing.assert_array_equal(a.qpos, b.qpos)


def test_tasks_of_one_level_share_it_by_their_weights(human):
    """Two contradicting wishes of one level meet where weights say; of two levels one wins."""
    state = BodyState(human, bent(human))
    tasks = [
        ComTask(state.com + [way, 0.0, 0.0], "x", name, weight=weight)
        for way, name, weight in ((0.01, "ahead", 3.0), (-0.01, "behind", 1.0))
    ]
    levels, wide = [task.rows(state).level for task in tasks], np.full(human.model.nv, 1e6)
    both = stacked(levels)
    assert both.name == "ahead and behind" and both.matrix.shape == (2, human.model.nv)
    for asked, desired in (([both], 0.5), (levels, 1.0), (levels[::-1], -1.0)):
        x = solve_hierarchy(asked, lower=-wide, upper=wide).x
        np.testing.assert_allclose(state.com_jacobian[0] @ x, 4.0 * desired, atol=1e-6)


def test_a_motion_that_cannot_go_on_ends_where_it_is_and_says_why(monkeypatch):
    from plantigrade.errors import SolverError
    from plantigrade.wbc import stepping

    human = person("42", "two-segment")
    solve, asked = stepping.solve_hierarchy, []

    def tired(levels, **words):
        asked.append(1)
        if len(asked) > 12:
            raise SolverError("no answer")
        return solve(levels, **words)

    monkeypatch.setattr(stepping, "solve_hierarchy", tired)
    here = BodyState(human, human.standing()).com
    order = TaskOrder([[ComTask(Trajectory.fixed(here))]])
    motion = move(human, order, human.standing(), stop=1.0)
    assert motion.stopped == "no answer"
    assert 2 <= len(motion.time) == len(motion.qpos) == len(motion.residual) <= 12
    with pytest.raises(SolverError, match="no answer"):
        move(human, order, human.standing(), stop=1.0)

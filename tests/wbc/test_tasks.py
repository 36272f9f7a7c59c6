"""Every task's Jacobian and bias acceleration against differences, and what its rows ask for."""

import copy

import mujoco
import numpy as np
import pytest

from plantigrade.contact.site import contact_sites
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.wbc import solve_hierarchy
from plantigrade.wbc.tasks import (
    AlignmentTask,
    ComTask,
    ContactTask,
    FloorTask,
    LinearMomentumTask,
    OrientationTask,
    PointTask,
    PostureTask,
    SoleContactTask,
    TimedPosture,
)
from tests.models.presets import person, random_state

BODIES = [("42", "two-segment"), ("66", "multi-segment"), ("43", "rigid"), ("58", "two-segment")]
STEP = 1e-5
NOW = 0.37


def soles(human):
    return SitePoints(human, contact_sites(human))


def swollen(points, by):
    """The same sites with spheres that are larger [m]."""
    other = copy.copy(points)
    other.radius = points.radius + by
    return other


def waving(rng, dimension=3):
    time = np.linspace(0, 1, 20)
    return Trajectory(time, rng.normal(size=(20, dimension)))


def every_task(human, state, rng):
    """One task of each kind, each with an error, at a state in which all of them are active."""
    points = soles(human)
    hand = PointSet(human, [human.body_names[-1]], rng.normal(scale=0.1, size=(1, 3)))
    all_on = np.ones(len(points), dtype=bool)
    lowest = points.height(state).min()
    tasks = [
        ComTask(waving(rng)),
        ComTask(waving(rng), "zx"),
        PointTask(hand, waving(rng)),
        PointTask(hand, waving(rng), rng.normal(size=(2, 3))),
        PointTask(hand, waving(rng), lambda state, time: np.eye(3)[:2]),
        OrientationTask("head", state.rotation("head")),  # its rate is exact where it is small
        FloorTask(swollen(points, lowest - 0.05)),
        ContactTask(points, lambda time: all_on),
        SoleContactTask(points, lambda time: all_on),
        PostureTask(state.qpos),
        TimedPosture(lambda time: (state.qpos, 1.0)),
        LinearMomentumTask(human.mass, waving(rng)),
    ]
    for task in tasks:
        task.begin(state, NOW)
    return tasks


def along(human, q, v, h):
    result = q.copy()
    mujoco.mj_integratePos(human.model, result, v, h)
    return BodyState(human, result, v)


@pytest.mark.parametrize("preset", BODIES, ids="-".join)
@pytest.mark.parametrize("seed", [0, 1])
def test_jacobian_and_bias_acceleration_are_rates(preset, seed):
    human, rng = person(*preset), np.random.default_rng(seed)
    q, v = random_state(human, rng)
    state = BodyState(human, q, v)
    tasks = every_task(human, state, rng)
    for task in tasks:
        J = task.jacobian(state, NOW)
        assert J.shape == (len(task.error(state, NOW)), human.model.nv)
        assert len(J) > 0, task.name
    # One step along every coordinate at once, with random sizes: as good as each alone.
    for _ in range(6):
        d = rng.normal(size=human.model.nv)
        ahead, behind = along(human, q, d, STEP), along(human, q, d, -STEP)
        for task in tasks:
            rate = (task.error(ahead, NOW) - task.error(behind, NOW)) / (2 * STEP)
            np.testing.assert_allclose(
                task.jacobian(state, NOW) @ d, rate, atol=1e-6, err_msg=task.name
            )
    ahead, behind = along(human, q, v, STEP), along(human, q, v, -STEP)
    for task in tasks:
        after, before = task.jacobian(ahead, NOW) @ v, task.jacobian(behind, NOW) @ v
        np.testing.assert_allclose(
            task.bias_acceleration(state, NOW),
            (after - before) / (2 * STEP),
            atol=1e-5,
            err_msg=task.name,
        )


@pytest.mark.parametrize("axes", ["xyz", "xy", "z"])
def test_target_rates_are_the_rates_of_the_error(axes):
    human, rng = person("42", "two-segment"), np.random.default_rng(2)
    state = BodyState(human, *random_state(human, rng))
    task = ComTask(waving(rng), axes)
    _, velocity, acceleration = task.aim(NOW)
    h = 1e-5
    before, here, after = (task.error(state, NOW + d) for d in (-h, 0, h))
    np.testing.assert_allclose(velocity, -(after - before) / (2 * h), atol=1e-5)
    h = 1e-4
    before, after = task.error(state, NOW - h), task.error(state, NOW + h)
    np.testing.assert_allclose(
        acceleration, -(after - 2 * here + before) / h**2, rtol=1e-2, atol=1.0
    )


@pytest.mark.parametrize("preset", BODIES, ids="-".join)
def test_rows_ask_for_the_second_order_equation(preset):
    """Whatever acceleration satisfies the rows: the error accelerates by -kp e - kd e'."""
    human, rng = person(*preset), np.random.default_rng(3)
    q, v = random_state(human, rng)
    state = BodyState(human, q, v)
    hand = PointSet(human, [human.body_names[-1]], np.zeros((1, 3)))
    for task in (
        ComTask(waving(rng), stiffness=50.0, damping=3.0),
        PointTask(hand, waving(rng), np.eye(3)[:2], stiffness=200.0),
    ):
        row = task.rows(state, NOW)
        wide = np.full(human.model.nv, 1e9)
        a = solve_hierarchy([row.level], lower=-wide, upper=wide).x
        h = 2e-4
        errors = []
        for d in (-h, 0.0, h):  # the true motion under that acceleration
            there = q.copy()
            mujoco.mj_integratePos(human.model, there, v + 0.5 * d * a, d)
            errors.append(task.error(BodyState(human, there), NOW + d))
        rate = (errors[2] - errors[0]) / (2 * h)
        acceleration = (errors[2] - 2 * errors[1] + errors[0]) / h**2
        desired = -task.stiffness * errors[1] - task.damping * rate
        scale = max(1.0, np.abs(desired).max())
        np.testing.assert_allclose(acceleration, desired, atol=2e-3 * scale, err_msg=task.name)


def test_damping_is_critical_where_none_is_given():
    task = ComTask(Trajectory.fixed(np.zeros(3)), stiffness=9.0)
    assert task.damping == pytest.approx(2 * 3.0)  # (s + 3)² = s² + 6 s + 9


def test_an_alignment_turns_by_what_is_left():
    human, rng = person("42", "two-segment"), np.random.default_rng(5)
    state, turn = BodyState(human, *random_state(human, rng)), rng.normal(size=3)
    rows = AlignmentTask("head", turn, stiffness=9.0).rows(state)
    np.testing.assert_allclose(rows.right, 9.0 * turn - 6.0 * rows.matrix @ state.qvel)


def test_a_task_without_directions_rests():
    human = person("42", "two-segment")
    state = BodyState(human, human.standing())
    heel = PointSet(human, ["foot_r"], np.zeros((1, 3)))
    task = PointTask(heel, Trajectory.fixed(np.zeros(3)), lambda state, time: np.zeros((0, 3)))
    row = task.rows(state, 0.0)
    assert row.matrix.shape == (0, human.model.nv) and len(row.right) == 0


@pytest.mark.parametrize("preset", BODIES, ids="-".join)
def test_contact_rows_are_as_many_as_a_segment_can_move_and_lose_nothing(preset):
    """Reduced or not, the accelerations that leave all points at rest are the same."""
    human = person(*preset)
    points = soles(human)
    state = BodyState(human, human.standing(), np.random.default_rng(4).normal(size=human.model.nv))
    on = points.body == points.body[0]
    task = ContactTask(swollen(points, 1.0), lambda time: on)  # they all reach the floor
    task.begin(state, 0.0)
    row = task.rows(state, 0.0)
    full = task.jacobian(state, 0.0)
    assert len(row.right) <= 6
    assert len(row.right) >= np.linalg.matrix_rank(full, tol=1e-6)
    wide = np.full(human.model.nv, 1e9)
    a = solve_hierarchy([row.level], lower=-wide, upper=wide).x
    desired = -task.stiffness * task.error(state, 0.0) - task.damping * full @ state.qvel
    missed = full @ a + task.bias_acceleration(state, 0.0) - desired
    best = np.linalg.lstsq(full, desired - task.bias_acceleration(state, 0.0), rcond=1e-10)[0]
    expected = full @ best + task.bias_acceleration(state, 0.0) - desired
    np.testing.assert_allclose(np.linalg.norm(missed), np.linalg.norm(expected), rtol=1e-6)


def test_a_contact_is_held_where_it_landed():
    human = person("42", "two-segment")
    points = soles(human)
    state = BodyState(human, human.standing())
    landed = state.position(points).copy()
    on = np.ones(len(points), dtype=bool)
    task = ContactTask(points, lambda time: on if time < 1.0 else ~on)
    assert task.begin(state, 0.0)
    moved = human.standing()
    moved[:2] += 0.01, 0.02
    state = state.moved_to(moved, np.zeros(human.model.nv))
    assert not task.begin(state, 0.5)  # nothing new touches
    error = task.error(state, 0.5).reshape(-1, 3)
    np.testing.assert_allclose(error, np.tile([0.01, 0.02, 0.0], (len(points), 1)), atol=2e-3)
    assert not task.begin(state, 1.0)
    assert not len(task.error(state, 1.0))
    state = state.moved_to(moved, np.zeros(human.model.nv))
    task.reset()
    assert task.begin(state, 0.0)
    np.testing.assert_allclose(task.error(state, 0.0), 0.0, atol=2e-3)
    assert np.abs(landed[:, 2] - points.radius).max() < 0.02


def test_the_floor_pushes_up_and_never_down():
    human = person("42", "two-segment")
    points = soles(human)
    task = FloorTask(points)
    high = human.standing()
    high[2] += 1.0
    assert not len(task.rows(BodyState(human, high), 0.0).right)  # far away: nothing to guard
    for depth in (0.0, 0.005):
        low = human.standing()
        low[2] -= depth
        state = BodyState(human, low)
        row = task.rows(state, 0.0)
        assert len(row.right) and np.isinf(row.level.upper).all()
        up = np.zeros(human.model.nv)
        up[2] = 1e4
        assert not row.missed(up).any()
        assert row.missed(-up).all()


def test_the_posture_arrives_in_time_with_nothing_left_over():
    """e'' = -6 e / T² - 4 e' / T with T the time to go: e falls as 3 T² - 2 T³."""
    human = person("42", "two-segment")
    goal = human.standing()
    task = TimedPosture(lambda time: (goal, 1.0), min_time_left=1e-3)
    start = goal.copy()
    start[7 + human.hinge("knee_angle_r")] += 0.5
    state = BodyState(human, start)
    k, step = 6 + human.hinge("knee_angle_r"), 1e-3
    for i in range(999):
        state = state.integrated(task.acceleration(state, i * step), step)
        left = 1.0 - (i + 1) * step
        if i % 100 == 0:
            expected = 0.5 * (3.0 * left**2 - 2.0 * left**3)
            assert state.difference(goal)[k] == pytest.approx(expected, abs=2e-3)
    assert abs(state.difference(goal)[k]) < 1e-3
    assert abs(state.qvel[k]) < 0.05


def test_every_public_task_is_tested_here():
    import plantigrade.wbc.tasks as tasks
    from tests.wbc import test_force_tasks

    tested = globals() | vars(test_force_tasks)
    here = {name for name in tasks.__all__ if name in tested}
    assert set(tasks.__all__) - here == {"Task"}

"""The tasks of a body moved by forces: momentum, landing, placing a foot, passing a posture."""

import mujoco
import numpy as np

from plantigrade.contact.site import contact_sites
from plantigrade.dynamics.centroid import centroid
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.wbc.tasks import (
    AngularMomentumTask,
    LandingTask,
    PlacingHeelTask,
    PointTask,
    PostureTask,
    TimedPosture,
)
from tests.models.presets import person


def random_state(seed: int) -> BodyState:
    human = person("42", "two-segment")
    rng = np.random.default_rng(seed)
    qpos = human.standing()
    qpos[3:7] = rng.normal(size=4)
    qpos[3:7] /= np.linalg.norm(qpos[3:7])
    qpos[7:] += 0.3 * rng.normal(size=len(qpos) - 7)
    return BodyState(human, qpos, rng.normal(size=human.model.nv))


def test_rows_of_the_angular_momentum_give_momentum_and_its_rate():
    state = random_state(1)
    nothing = Trajectory.fixed(np.zeros(3))
    task = AngularMomentumTask(nothing, Trajectory.fixed(state.qpos))
    qacc = np.random.default_rng(2).normal(size=state.model.nv)
    arrays = state.qpos[None], state.qvel[None], qacc[None]
    whole = centroid(state.human, *arrays)
    assert whole.moment is not None
    scale = task.jacobian(state, 0.0) @ state.qvel / whole.angular_momentum[0]
    np.testing.assert_allclose(scale, scale[0])
    rate = task.jacobian(state, 0.0) @ qacc + task.bias_acceleration(state, 0.0)
    np.testing.assert_allclose(rate / scale[0], whole.moment[0], rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(task.error(state, 0.0), 0.0, atol=1e-12)


def test_jacobian_and_bias_of_a_landing_are_derivatives():
    state = random_state(3)
    points = SitePoints(state.human, contact_sites(state.human))
    task = LandingTask(points, [(np.array([0, 1]), 0.1), (np.array([7]), 0.12)])
    still, h, h2 = np.zeros(state.model.nv), 1e-6, 1e-4
    start = state.qpos.copy(), state.qvel.copy()
    jacobian, bias = task.jacobian(state, 0.0), task.bias_acceleration(state, 0.0)
    values = []
    for step in (-h, 0.0, h, -h2, h2):
        qpos = start[0].copy()
        mujoco.mj_integratePos(state.model, qpos, start[1], step)
        values.append(task.error(state.moved_to(qpos, still), 0.0))
    np.testing.assert_allclose((values[2] - values[0]) / (2 * h), jacobian @ start[1], atol=1e-6)
    second = (values[4] - 2 * values[1] + values[3]) / h2**2
    np.testing.assert_allclose(second, bias, atol=1e-3)
    assert not len(task.error(state, 0.2))


def test_a_foot_comes_down_along_its_path():
    """On its path with the path's speed it is asked for the path's own acceleration."""
    state = random_state(4)
    points = SitePoints(state.human, contact_sites(state.human))
    mine = np.array([0, 1])
    task = LandingTask(points, [(mine, 0.1)])
    height, rate = task.error(state, 0.0), task.jacobian(state, 0.0) @ state.qvel
    t = np.linspace(-0.1, 0.2, 31)
    path = Trajectory(t, (height + rate * t[:, None] - 1.5 * t[:, None] ** 2))
    led = LandingTask(points, [(mine, 0.1)], [path])
    rows = led.rows(state)
    np.testing.assert_allclose(rows.right, -3.0 - led.bias_acceleration(state, 0.0), atol=1e-6)


def test_a_posture_is_passed_at_its_speed():
    """The acceleration is that of the cubic from here and now to there and then."""
    state = random_state(5)
    velocity = np.linspace(-1, 1, state.model.nv)
    target = state.qpos.copy()
    mujoco.mj_integratePos(state.model, target, velocity, 0.2)
    steady = TimedPosture(lambda t: (target, 0.2), lambda t: velocity)
    state = state.moved_to(state.qpos, velocity)
    np.testing.assert_allclose(steady.acceleration(state, 0.0), 0.0, atol=1e-8)
    np.testing.assert_allclose(
        steady.acceleration(state.moved_to(target, velocity), 0.2), 0.0, atol=1e-8
    )


def test_a_posture_on_its_curve_is_asked_for_the_bend_of_the_curve():
    """Off it, it comes back by the gains; the curve's quaternion need not be of unit length."""
    state = random_state(7)
    nv = state.model.nv
    away, slow, bend = (np.random.default_rng(8).normal(0, 0.1, (3, nv))).tolist()
    curve = state.qpos.copy()
    mujoco.mj_integratePos(state.model, curve, -np.array(away), 1.0)
    curve[3:7] *= 1.01
    target = curve, state.qvel - slow, np.array(bend)
    task = PostureTask(target, stiffness=200.0, damping=30.0)
    desired = np.array(bend) - 200.0 * np.array(away) - 30.0 * np.array(slow)
    np.testing.assert_allclose(task.acceleration(state, 0.0), desired, atol=1e-8)


def test_a_heel_is_placed_further_where_the_body_is_off_its_path():
    """The shift equals the error of the extrapolated centre of mass, at most 15 cm."""
    state = random_state(6).moved_to(person("42", "two-segment").standing())
    heel, path = PointSet(state.human, ["foot_r"], np.zeros((1, 3))), Trajectory.fixed(np.ones(3))
    plain = PointTask(heel, path, np.eye(3)[:2]).error(state, 0.0)
    for off, moved in ((np.array([0.03, -0.04, 0.0]), 1.0), (np.array([0.3, -0.4, 0.0]), 0.3)):
        com = Trajectory.fixed(state.com - off)
        task = PlacingHeelTask(heel, path, np.eye(3)[:2], com, "heel")
        np.testing.assert_allclose(plain - task.error(state, 0.0), moved * off[:2], atol=1e-12)

"""Positions, Jacobians and drifts of a state, against the engine's own and against differences."""

import mujoco
import numpy as np
import pytest

from plantigrade.errors import CoordinateNotFound, ParameterError
from plantigrade.kinematics.state import PointSet, State
from tests.models.presets import PRESETS, person, random_state

STEP = 1e-5


def points_of(human, rng):
    """One point anywhere on every segment."""
    names = list(human.body_names)
    return PointSet(human, names, rng.normal(scale=0.1, size=(len(names), 3)))


def moved(human, q, v, h):
    """The configuration a time ``h`` on, the velocity staying what it is."""
    result = q.copy()
    mujoco.mj_integratePos(human.model, result, v, h)
    return result


def difference(human, q, v, value):
    """The rate of something along a velocity, by central differences."""
    ahead = value(State(human, moved(human, q, v, STEP), v))
    return (ahead - value(State(human, moved(human, q, v, -STEP), v))) / (2 * STEP)


@pytest.mark.parametrize("preset", PRESETS, ids="-".join)
def test_jacobians_and_drifts_are_rates(preset):
    human, rng = person(*preset), np.random.default_rng(0)
    q, v = random_state(human, rng)
    points, state = points_of(human, rng), State(human, q, v)
    for k in range(human.model.nv):
        unit = np.eye(human.model.nv)[k]
        rate = difference(human, q, unit, lambda s: s.position(points))
        np.testing.assert_allclose(state.jacobian(points)[:, :, k], rate, atol=1e-8)
        rate = difference(human, q, unit, lambda s: s.com)
        np.testing.assert_allclose(state.com_jacobian[:, k], rate, atol=1e-8)
    np.testing.assert_allclose(state.velocity(points), state.jacobian(points) @ v, atol=1e-12)
    # Velocities stay what they are: what accelerates does so by the drift alone.
    rate = difference(human, q, v, lambda s: s.velocity(points))
    np.testing.assert_allclose(state.drift(points), rate, atol=1e-6)
    rate = difference(human, q, v, lambda s: s.com_jacobian @ v)
    np.testing.assert_allclose(state.com_drift, rate, atol=1e-6)
    for body in ("pelvis", "foot_r", human.body_names[-1]):
        rate = difference(human, q, v, lambda s, body=body: s.angular_jacobian(body) @ v)
        np.testing.assert_allclose(state.angular_drift(body), rate, atol=1e-6)
        turning = difference(human, q, v, lambda s, body=body: s.rotation(body))
        spin = turning @ state.rotation(body).T
        omega = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        np.testing.assert_allclose(state.angular_jacobian(body) @ v, omega, atol=1e-7)


def test_points_and_jacobians_are_the_engines():
    human, rng = person("66", "multi-segment"), np.random.default_rng(1)
    q, v = random_state(human, rng)
    points, state = points_of(human, rng), State(human, q, v)
    data = mujoco.MjData(human.model)
    data.qpos[:], data.qvel[:] = q, v
    mujoco.mj_forward(human.model, data)
    for i, body in enumerate(points.body):
        place = data.xpos[body] + data.xmat[body].reshape(3, 3) @ points.local[i]
        J = np.empty((3, human.model.nv))
        mujoco.mj_jac(human.model, data, J, None, place, body)
        np.testing.assert_allclose(state.position(points)[i], place, atol=1e-12)
        np.testing.assert_allclose(state.jacobian(points)[i], J, atol=1e-12)


def test_equation_of_motion_is_the_engines():
    human, rng = person("42", "two-segment"), np.random.default_rng(2)
    q, v = random_state(human, rng)
    a = rng.normal(size=human.model.nv)
    state = State(human, q, v)
    data = mujoco.MjData(human.model)
    data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
    mujoco.mj_fwdPosition(human.model, data)
    mujoco.mj_fwdVelocity(human.model, data)
    force = np.empty(human.model.nv)
    mujoco.mj_rne(human.model, data, 1, force)
    ours = state.mass_matrix @ a + state.bias
    np.testing.assert_allclose(ours - human.model.dof_armature * a, force, atol=1e-8)
    np.testing.assert_allclose(state.mass_matrix, state.mass_matrix.T, atol=1e-12)
    assert np.linalg.eigvalsh(state.mass_matrix).min() > 0


def test_the_centre_of_mass_carries_all_momentum():
    human, rng = person("43", "rigid"), np.random.default_rng(3)
    q, v = random_state(human, rng)
    state = State(human, q, v)
    np.testing.assert_allclose(
        state.mass * (state.com_jacobian @ v), state.mass_matrix[:3] @ v, atol=1e-9
    )
    assert state.mass == pytest.approx(human.mass)


def test_a_body_thrown_falls_as_its_centre_of_mass_does():
    """Nothing but its own weight acts: however it turns and folds, the centre falls freely."""
    human, rng = person("42", "two-segment"), np.random.default_rng(4)
    q, v = random_state(human, rng)
    state = State(human, q, v)
    a = -np.linalg.solve(state.mass_matrix, state.bias)
    fall = state.com_jacobian @ a + state.com_drift
    armature = human.model.dof_armature.max()  # a rotor's inertia belongs to no body
    np.testing.assert_allclose(fall, human.model.opt.gravity, atol=1e-8 + 1e2 * armature)


def test_integration_is_exact_where_acceleration_is_constant():
    human = person("42", "two-segment")
    state = State(human, human.standing())
    a = np.zeros(human.model.nv)
    a[0], a[6 + human.hinge("knee_angle_r")] = 2.0, 3.0
    start = state.qpos
    for _ in range(100):
        state.integrate(a, 0.01)
    np.testing.assert_allclose(state.qvel, a, atol=1e-12)
    np.testing.assert_allclose(state.difference(start), 0.5 * a, atol=1e-12)


def test_a_state_is_asked_twice_and_answers_alike():
    """What is computed once must not outlive the configuration it was computed for."""
    human, rng = person("42", "two-segment"), np.random.default_rng(5)
    points = points_of(human, rng)
    (q0, v0), (q1, v1) = random_state(human, rng), random_state(human, rng)
    state = State(human, q0, v0)
    first = [state.position(points).copy(), state.jacobian(points).copy(), state.mass_matrix]
    state.move_to(q1, v1)
    fresh = State(human, q1, v1)
    np.testing.assert_array_equal(state.jacobian(points), fresh.jacobian(points))
    np.testing.assert_array_equal(state.drift(points), fresh.drift(points))
    np.testing.assert_array_equal(state.mass_matrix, fresh.mass_matrix)
    state.move_to(q0, v0)
    np.testing.assert_array_equal(state.position(points), first[0])
    np.testing.assert_array_equal(state.jacobian(points), first[1])
    np.testing.assert_array_equal(state.mass_matrix, first[2])


def test_bad_points_are_refused():
    human = person("42", "two-segment")
    with pytest.raises(CoordinateNotFound, match="no body 'tail'"):
        PointSet(human, ["tail"], np.zeros((1, 3)))
    with pytest.raises(ParameterError, match="2 bodies for 1 points"):
        PointSet(human, ["pelvis", "pelvis"], np.zeros((1, 3)))

"""Positions, Jacobians and bias accelerations of a state, against the engine and differences."""

import copy

import mujoco
import numpy as np
import pytest

from plantigrade.errors import CoordinateNotFound, ParameterError
from plantigrade.kinematics.state import MAX_ENGINE_POINTS, BodyState, PointSet, sweep
from plantigrade.models import Human
from plantigrade.motion import Motion
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
    ahead = value(BodyState(human, moved(human, q, v, STEP), v))
    return (ahead - value(BodyState(human, moved(human, q, v, -STEP), v))) / (2 * STEP)


def test_a_jacobian_is_the_same_for_few_and_many_points():
    human, rng = person(*PRESETS[0]), np.random.default_rng(3)
    state = BodyState(human, *random_state(human, rng))
    many = points_of(human, rng)
    one_by_one = [
        PointSet(human, [human.body_names[k]], many.local[k : k + 1]) for k in range(len(many))
    ]
    assert len(many) > MAX_ENGINE_POINTS
    for ask in (BodyState.jacobian, BodyState.bias_acceleration):
        alone = np.concatenate([ask(state, one) for one in one_by_one])
        np.testing.assert_allclose(ask(state, many), alone, atol=1e-11)


@pytest.mark.parametrize("preset", PRESETS, ids="-".join)
def test_jacobians_and_bias_accelerations_are_rates(preset):
    human, rng = person(*preset), np.random.default_rng(0)
    q, v = random_state(human, rng)
    points, state = points_of(human, rng), BodyState(human, q, v)
    for k in range(human.model.nv):
        unit = np.eye(human.model.nv)[k]
        rate = difference(human, q, unit, lambda s: s.position(points))
        np.testing.assert_allclose(state.jacobian(points)[:, :, k], rate, atol=1e-8)
        rate = difference(human, q, unit, lambda s: s.com)
        np.testing.assert_allclose(state.com_jacobian[:, k], rate, atol=1e-8)
    np.testing.assert_allclose(state.velocity(points), state.jacobian(points) @ v, atol=1e-12)
    # Velocities stay what they are: what accelerates does so by the bias alone.
    rate = difference(human, q, v, lambda s: s.velocity(points))
    np.testing.assert_allclose(state.bias_acceleration(points), rate, atol=1e-6)
    rate = difference(human, q, v, lambda s: s.com_jacobian @ v)
    np.testing.assert_allclose(state.com_bias_acceleration, rate, atol=1e-6)
    for body in ("pelvis", "foot_r", human.body_names[-1]):
        rate = difference(human, q, v, lambda s, body=body: s.angular_jacobian(body) @ v)
        np.testing.assert_allclose(state.angular_bias_acceleration(body), rate, atol=1e-6)
        turning = difference(human, q, v, lambda s, body=body: s.rotation(body))
        spin = turning @ state.rotation(body).T
        omega = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
        np.testing.assert_allclose(state.angular_jacobian(body) @ v, omega, atol=1e-7)


def test_points_and_jacobians_are_the_engines():
    human, rng = person("66", "multi-segment"), np.random.default_rng(1)
    q, v = random_state(human, rng)
    points, state = points_of(human, rng), BodyState(human, q, v)
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
    state = BodyState(human, q, v)
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
    state = BodyState(human, q, v)
    np.testing.assert_allclose(
        state.mass * (state.com_jacobian @ v), state.mass_matrix[:3] @ v, atol=1e-9
    )
    assert state.mass == pytest.approx(human.mass)


def test_a_body_thrown_falls_as_its_centre_of_mass_does():
    """Nothing but its own weight acts: however it turns and folds, the centre falls freely."""
    human, rng = person("42", "two-segment"), np.random.default_rng(4)
    q, v = random_state(human, rng)
    state = BodyState(human, q, v)
    a = -np.linalg.solve(state.mass_matrix, state.bias)
    fall = state.com_jacobian @ a + state.com_bias_acceleration
    armature = human.model.dof_armature.max()  # a rotor's inertia belongs to no body
    np.testing.assert_allclose(fall, human.model.opt.gravity, atol=1e-8 + 1e2 * armature)


def test_integration_is_exact_where_acceleration_is_constant():
    human = person("42", "two-segment")
    state = BodyState(human, human.standing())
    a = np.zeros(human.model.nv)
    a[0], a[6 + human.hinge("knee_angle_r")] = 2.0, 3.0
    start = state.qpos
    for _ in range(100):
        state = state.integrated(a, 0.01)
    np.testing.assert_allclose(state.qvel, a, atol=1e-12)
    np.testing.assert_allclose(state.difference(start), 0.5 * a, atol=1e-12)


def test_a_state_answers_alike_after_later_ones_were_evaluated():
    """States share MuJoCo's memory: none of it may be seen stale."""
    human, rng = person("42", "two-segment"), np.random.default_rng(5)
    points = points_of(human, rng)
    (q0, v0), (q1, v1) = random_state(human, rng), random_state(human, rng)
    state = BodyState(human, q0, v0)
    first = [state.com, state.rotation("head"), state.origins]
    later = state.moved_to(q1, v1)
    fresh, alone = BodyState(human, q1, v1), BodyState(human, q0, v0)
    for ours, theirs in ((later, fresh), (state, alone), (later, fresh)):
        np.testing.assert_array_equal(ours.jacobian(points), theirs.jacobian(points))
        np.testing.assert_array_equal(
            ours.bias_acceleration(points), theirs.bias_acceleration(points)
        )
        np.testing.assert_array_equal(ours.com_bias_acceleration, theirs.com_bias_acceleration)
        np.testing.assert_array_equal(ours.mass_matrix, theirs.mass_matrix)
        np.testing.assert_array_equal(ours.angular_momentum, theirs.angular_momentum)
        np.testing.assert_array_equal(ours.com, theirs.com)
    for ours, theirs in zip(first, [state.com, state.rotation("head"), state.origins], strict=True):
        np.testing.assert_array_equal(ours, theirs)


def test_a_state_cannot_be_changed():
    human = person("42", "two-segment")
    given = human.standing()
    state = BodyState(human, given)
    given[2] = 5.0
    assert state.qpos[2] != 5.0
    with pytest.raises(ValueError, match="read-only"):
        state.qpos[2] = 5.0
    with pytest.raises(ValueError, match="read-only"):
        state.qvel[2] = 5.0


@pytest.mark.parametrize("n", [1, MAX_ENGINE_POINTS + 1])
def test_what_a_state_keeps_cannot_be_changed(n):
    human = person(*PRESETS[0])
    state = BodyState(human, *random_state(human, np.random.default_rng(2)))
    points = PointSet(human, list(human.body_names[:n]), np.zeros((n, 3)))
    ask = (
        BodyState.position,
        BodyState.jacobian,
        BodyState.velocity,
        BodyState.bias_acceleration,
    )
    kept = [asked(state, points) for asked in ask]
    kept += [state.mass_matrix, state.bias, state.com_velocity, state.angular_momentum]
    for array in kept:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0.0


def test_a_sweep_yields_the_states_of_a_motion():
    human, rng = person("42", "two-segment"), np.random.default_rng(6)
    qpos, qvel = (
        np.array(x) for x in zip(*(random_state(human, rng) for _ in range(4)), strict=True)
    )
    points = points_of(human, rng)
    motion = Motion(0.1 * np.arange(4), qpos, qvel, human.joint_names)
    kept = list(sweep(human, motion))
    for state, bare, q, v in zip(kept, sweep(human, qpos), qpos, qvel, strict=True):
        alone = BodyState(human, q, v)
        np.testing.assert_array_equal(state.velocity(points), alone.velocity(points))
        np.testing.assert_array_equal(bare.position(points), alone.position(points))
        assert not bare.qvel.any()
    np.testing.assert_array_equal(points.path(qpos)[2], kept[2].position(points))
    assert not list(sweep(human, qpos[:0])) and points.path(qpos[:0]).shape[0] == 0


def test_inverse_dynamics_is_the_engines():
    human, rng = person("42", "two-segment"), np.random.default_rng(7)
    model = copy.deepcopy(human.model)
    data = mujoco.MjData(model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    q, v = random_state(human, rng)
    a = rng.normal(size=model.nv)
    data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
    mujoco.mj_inverse(model, data)
    state = BodyState(human, q, v)
    np.testing.assert_allclose(state.inverse_dynamics(a), data.qfrc_inverse, atol=1e-9)
    force, torque, point = rng.normal(size=(3, 3))
    local = state.rotation("foot_r").T @ (point - state.origin("foot_r"))
    foot = PointSet(human, ["foot_r"], local[None])
    expected = state.jacobian(foot)[0].T @ force + state.angular_jacobian("foot_r").T @ torque
    ours = state.generalised_force(human.body("foot_r"), point, force, torque)
    np.testing.assert_allclose(ours, expected, atol=1e-10)


def test_other_lengths_move_the_points_and_leave_the_person_alone():
    human = person("42", "two-segment")
    longer = Human.create(1.74, 71.0, lengths={"thigh": 0.47, "upper_arm": 0.33})
    body, local = ["toes_r", "hand_l"], np.array([[0.02, 0.01, 0.0], [0.0, 0.02, -0.05]])
    resized = copy.deepcopy(human.model)
    resized.body_pos[2:] = human.body_positions(longer.dimensions)[1:]
    q, _ = random_state(human, np.random.default_rng(2))
    ours, direct = PointSet(human, body, local, resized), PointSet(longer, body, local)
    np.testing.assert_allclose(ours.path(q[None]), direct.path(q[None]), atol=1e-13)
    np.testing.assert_allclose(
        BodyState(human, q, model=resized).jacobian(ours),
        BodyState(longer, q).jacobian(direct),
        atol=1e-13,
    )


def test_bad_points_are_refused():
    human = person("42", "two-segment")
    with pytest.raises(CoordinateNotFound, match="no body 'tail'"):
        PointSet(human, ["tail"], np.zeros((1, 3)))
    with pytest.raises(ParameterError, match="2 bodies for 1 points"):
        PointSet(human, ["pelvis", "pelvis"], np.zeros((1, 3)))

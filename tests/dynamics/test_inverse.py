"""Inverse dynamics: statics, free fall, both engines, energy, symmetry."""

import mujoco
import numpy as np
import pytest

from plantigrade.dynamics.centroid import centroid, without_constraints
from plantigrade.dynamics.inverse import (
    com_metrics,
    inverse_dynamics,
    residual_metrics,
)
from plantigrade.dynamics.plates import sole_points
from plantigrade.dynamics.segment_loads import SegmentLoads, load_shares
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import sweep
from plantigrade.models import Human
from plantigrade.spatial.conventions import rotation_matrix
from tests.dynamics.movement import feet_forces, movement
from tests.dynamics.opensim_moments import opensim_moments
from tests.spatial.pinocchio_state import (
    configuration_to_pinocchio,
    free_joint_velocity_to_pinocchio,
)

G = 9.81
BODIES = [("42", "rigid"), ("42", "two-segment"), ("66", "multi-segment")]


def person(joints="42", feet="two-segment"):
    return Human.create(1.74, 71.0, joints=joints, feet=feet)


def random_forces(human, qpos, seed=0):
    """Return wrenches of a walker's size somewhere on each sole."""
    rng = np.random.default_rng(seed)
    n = len(qpos)
    soles = sole_points(human, qpos)
    part = rng.uniform(size=(n, 2, 1))
    force = rng.normal(size=(n, 2, 3)) * [80, 80, 100] + [0, 0, 500]
    point = np.stack([soles[s][:, 0] for s in ("r", "l")], axis=1) * part
    point += np.stack([soles[s][:, -1] for s in ("r", "l")], axis=1) * (1 - part)
    torque = np.zeros((n, 2, 3))
    torque[..., 2] = rng.normal(size=(n, 2)) * 10
    return feet_forces(force, point, torque)


@pytest.mark.parametrize(("joints", "feet"), BODIES)
def test_free_fall_needs_no_moment(joints, feet):
    human = person(joints, feet)
    n = 3
    qpos = np.tile(human.standing(), (n, 1))
    qvel, qacc = np.zeros((n, human.model.nv)), np.zeros((n, human.model.nv))
    qvel[:, 2], qacc[:, 2] = [1.0, 0.0, -1.0], -G
    m = inverse_dynamics(human, qpos, qvel, qacc)
    np.testing.assert_allclose(m.tau, 0.0, atol=1e-9)


@pytest.mark.parametrize("heading", [0.0, 2.0])
@pytest.mark.parametrize("bias", [0.0, 20.0])  # of a plate's horizontal force [N]
def test_how_far_the_centre_of_mass_lies_from_where_the_forces_place_it(heading, bias):
    human, n = person(feet="rigid"), 12
    still = np.zeros((n, human.model.nv))
    qpos = np.tile(human.standing(), (n, 1))
    qpos[:, 3:7] = [np.cos(heading / 2), 0, 0, np.sin(heading / 2)]
    com = inverse_dynamics(human, qpos, still, still).com
    forward = np.array([np.cos(heading), np.sin(heading), 0.0])
    left = np.array([-np.sin(heading), np.cos(heading), 0.0])
    point = np.repeat((com - 0.02 * forward + 0.005 * left)[:, None], 2, axis=1) * [1, 1, 0]
    force = np.zeros((n, 2, 3))
    force[:, 0] = bias * forward + bias * left
    force[..., 2] = human.mass * G / 2
    forces = feet_forces(force, point, 0 * force)
    found = com_metrics(inverse_dynamics(human, qpos, still, still, forces), forces, qpos)
    assert found["com_ahead_mm"] == pytest.approx(20.0, abs=0.01)
    assert found["com_left_mm"] == pytest.approx(-5.0, abs=0.01)
    seated = feet_forces(0.5 * force, point, 0 * force)  # a chair without a plate carries the rest
    assert not com_metrics(inverse_dynamics(human, qpos, still, still, seated), seated, qpos)


def test_standing_still_is_statics():
    human = person(feet="rigid")
    qpos = human.standing()[None].copy()
    qpos[0, 7 + human.hinge("hip_flexion_r")] = qpos[0, 7 + human.hinge("hip_flexion_l")] = 0.5
    still = np.zeros((1, human.model.nv))
    data = mujoco.MjData(human.model)
    data.qpos[:] = qpos[0]
    mujoco.mj_forward(human.model, data)
    com, weight = data.subtree_com[1].copy(), human.mass * G
    ankles = [data.xpos[human.body(f"foot_{s}")].copy() for s in ("r", "l")]
    point = np.array([[[com[0], a[1], 0.0] for a in ankles]])
    force = np.zeros((1, 2, 3))
    force[..., 2] = weight / 2
    m = inverse_dynamics(human, qpos, still, still, feet_forces(force, point, 0 * force))
    np.testing.assert_allclose(m.residual_force, 0.0, atol=1e-9)
    np.testing.assert_allclose(m.residual_moment, 0.0, atol=1e-9)
    # The trunk's weight forward of the hips needs hip extensors; a ground reaction ahead of the
    # ankle needs plantarflexors: both negative in Rajagopal's signs.
    for k, side in enumerate(("r", "l")):
        foot = human.model.body(f"foot_{side}").id
        own = human.model.body_mass[foot] * G * (data.xipos[foot] - ankles[k])[0]
        external = weight / 2 * (point[0, k] - ankles[k])[0] - own
        axis = data.xaxis[1 + human.hinge(f"ankle_angle_{side}")]
        # Moment of vertical forces about the ankle: (x, y) x F = (y F, -x F, 0), y is zero.
        moment_y = -external
        y_part = human.model.body_mass[foot] * G * -(data.xipos[foot] - ankles[k])[1]
        expected = -(axis[0] * y_part + axis[1] * moment_y)
        np.testing.assert_allclose(m[f"ankle_angle_{side}"], expected, rtol=1e-9)
        assert np.sign(m[f"ankle_angle_{side}"][0]) == -np.sign(external)
        # The same from above: a leg's hip moment from everything below it.
        leg = [human.model.body(f"{b}_{side}").id for b in ("femur", "tibia", "foot")]
        hip = data.xpos[leg[0]]
        lever = sum(human.model.body_mass[b] * G * (data.xipos[b] - hip)[0] for b in leg)
        np.testing.assert_allclose(
            m[f"hip_flexion_{side}"],
            -(weight / 2 * (point[0, k] - hip)[0] - lever),
            rtol=1e-9,
        )


@pytest.mark.parametrize(("joints", "feet"), BODIES)
def test_round_trip_with_forward_dynamics(joints, feet):
    human = person(joints, feet)
    _, qpos, qvel, _ = movement(human, n=6, dt=0.1)
    forces = random_forces(human, qpos)
    model = without_constraints(human)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(3)
    torque = rng.normal(size=(len(qpos), model.nv)) * 20
    torque[:, :6] = 0
    qacc = np.empty_like(qvel)
    carriers = SegmentLoads(human)
    for f, state in enumerate(sweep(human, qpos)):
        data.qpos[:], data.qvel[:] = qpos[f], qvel[f]
        mujoco.mj_forward(model, data)
        data.xfrc_applied[:] = 0
        for k, side in enumerate(("r", "l")):
            for load in carriers.divide(
                state, side, forces.force[f, k], forces.point[f, k], forces.torque[f, k]
            ):
                arm = load.point - data.xipos[load.body]
                data.xfrc_applied[load.body, :3] += load.force
                data.xfrc_applied[load.body, 3:] += load.torque + np.cross(arm, load.force)
        data.qfrc_applied[:] = torque[f]
        mujoco.mj_forward(model, data)
        qacc[f] = data.qacc
    m = inverse_dynamics(human, qpos, qvel, qacc, forces)
    np.testing.assert_allclose(m.tau, torque, atol=1e-7)
    np.testing.assert_allclose(m.power, torque * qvel, atol=1e-6)


@pytest.mark.parametrize(("joints", "feet"), BODIES)
def test_division_over_segments_keeps_the_wrench(joints, feet):
    human = person(joints, feet)
    _, qpos, *_ = movement(human, n=4, dt=0.1)
    forces = random_forces(human, qpos)
    carriers = SegmentLoads(human)
    for f, state in enumerate(sweep(human, qpos)):
        for k, side in enumerate(("r", "l")):
            loads = carriers.divide(
                state, side, forces.force[f, k], forces.point[f, k], forces.torque[f, k]
            )
            assert {human.body_names[load.body - 1][-1] for load in loads} == {side}
            total = sum(load.force for load in loads)
            moment = sum(np.cross(load.point, load.force) + load.torque for load in loads)
            expected = np.cross(forces.point[f, k], forces.force[f, k]) + forces.torque[f, k]
            np.testing.assert_allclose(total, forces.force[f, k], atol=1e-9)
            np.testing.assert_allclose(moment, expected, atol=1e-9)


def test_shares_balance_on_the_centre_of_pressure():
    places = np.array([[0, 0, 0], [0.2, 0.05, 0], [0.2, -0.05, 0], [0.1, 0.0, 0.08]], float)
    point = np.array([0.15, 0.01, 0.0])
    share = load_shares(places, point)
    assert (share >= 0).all()
    np.testing.assert_allclose(share.sum(), 1.0)
    np.testing.assert_allclose(share @ places[:, :2], point[:2], atol=1e-5)
    assert share[3] < 0.01  # a point in the air carries nothing


def test_toes_carry_what_lies_ahead_of_their_joint():
    human = person(feet="two-segment")
    qpos, still = human.standing()[None], np.zeros((1, human.model.nv))
    data = mujoco.MjData(human.model)
    data.qpos[:] = qpos[0]
    mujoco.mj_kinematics(human.model, data)
    hinge = data.xpos[human.body("toes_r")]
    moments = []
    for ahead in (-0.02, 0.001, 0.03):
        force, point = np.zeros((1, 2, 3)), np.full((1, 2, 3), np.nan)
        force[0, 0, 2] = 400.0
        point[0, 0] = [hinge[0] + ahead, hinge[1], 0.0]
        loaded = inverse_dynamics(human, qpos, still, still, feet_forces(force, point, 0 * force))
        unloaded = inverse_dynamics(human, qpos, still, still)
        moments.append((loaded.tau - unloaded.tau)[0, 6 + human.hinge("mtp_angle_r")])
    np.testing.assert_allclose(moments, [0.0, -0.4, -12.0], atol=1e-9)


@pytest.mark.parametrize(("joints", "feet"), BODIES)
def test_pinocchio_agrees(joints, feet, tmp_path):
    pin = pytest.importorskip("pinocchio")
    human = person(joints, feet)
    path = tmp_path / "model.xml"
    path.write_text(human.xml)
    model = pin.buildModelFromMJCF(str(path))
    data = model.createData()
    assert tuple(model.names)[2:] == human.coordinates or len(model.names) < model.nv
    _, qpos, qvel, qacc = movement(human, n=5, dt=0.15)
    forces = random_forces(human, qpos)
    rigid_carrier = feet == "rigid"
    m = inverse_dynamics(human, qpos, qvel, qacc, forces if rigid_carrier else None)
    engine = mujoco.MjData(human.model)
    for f in range(len(qpos)):
        rotation = rotation_matrix(qpos[f, 3:7])
        v = free_joint_velocity_to_pinocchio(qpos[f], qvel[f])
        a = qacc[f].copy()
        a[:3] = rotation.T @ qacc[f, :3] - np.cross(qvel[f, 3:6], v[:3])
        q = configuration_to_pinocchio(qpos[f])
        external = pin.StdVec_Force()
        pin.forwardKinematics(model, data, q)
        for _ in range(model.njoints):
            external.append(pin.Force.Zero())
        if rigid_carrier:
            engine.qpos[:] = qpos[f]
            mujoco.mj_kinematics(human.model, engine)
            for k, side in enumerate(("r", "l")):
                joint = model.frames[model.getFrameId(f"foot_{side}")].parentJoint
                world = pin.Force(
                    forces.force[f, k],
                    np.cross(forces.point[f, k], forces.force[f, k]) + forces.torque[f, k],
                )
                external[joint] = data.oMi[joint].actInv(world)
        tau = np.array(pin.rnea(model, data, q, v, a, external))
        tau[:3] = rotation @ tau[:3]
        np.testing.assert_allclose(m.tau[f], tau, atol=1e-7)


def test_power_is_the_change_of_energy():
    human = person(feet="multi-segment", joints="66")
    t, qpos, qvel, qacc = movement(human, n=401, dt=0.0025)
    forces = random_forces(human, qpos)
    m = inverse_dynamics(human, qpos, qvel, qacc, forces)
    model = without_constraints(human)
    model.opt.enableflags |= mujoco.mjtEnableBit.mjENBL_ENERGY
    data = mujoco.MjData(model)
    carriers = SegmentLoads(human)
    energy, external = np.empty(len(t)), np.zeros(len(t))
    for f, state in enumerate(sweep(human, qpos)):
        data.qpos[:], data.qvel[:] = qpos[f], qvel[f]
        mujoco.mj_forward(model, data)
        energy[f] = data.energy.sum()
        for k, side in enumerate(("r", "l")):
            loads = carriers.divide(
                state, side, forces.force[f, k], forces.point[f, k], forces.torque[f, k]
            )
            for load in loads:
                jp, jr = np.zeros((3, model.nv)), np.zeros((3, model.nv))
                mujoco.mj_jac(model, data, jp, jr, load.point, load.body)
                external[f] += load.force @ jp @ qvel[f] + load.torque @ jr @ qvel[f]
    change = np.gradient(energy, t)[1:-1]
    power = (m.power.sum(axis=1) + external)[1:-1]
    assert np.abs(power - change).max() < 2e-3 * np.abs(change).max()


def test_mirrored_motion_has_mirrored_moments():
    human = person(feet="two-segment")
    _, qpos, qvel, qacc = movement(human, n=4, dt=0.1)
    forces = random_forces(human, qpos)
    swap = [
        human.coordinates.index(c[:-1] + {"r": "l", "l": "r"}[c[-1]])
        if c[-2:] in ("_r", "_l")
        else i
        for i, c in enumerate(human.coordinates)
    ]
    sign = np.array(
        [
            -1.0 if c[-2:] not in ("_r", "_l") and ("bending" in c or "rotation" in c) else 1.0
            for c in human.coordinates
        ]
    )
    vector, axial = np.array([1.0, -1, 1]), np.array([-1.0, 1, -1])

    def tangent(x):
        return np.hstack([x[:, :3] * vector, x[:, 3:6] * axial, x[:, 6:][:, swap] * sign])

    mirrored = qpos.copy()
    mirrored[:, :3] *= vector
    mirrored[:, 4:7] *= axial
    mirrored[:, 7:] = qpos[:, 7:][:, swap] * sign
    other = feet_forces(
        forces.force[:, ::-1] * vector,
        forces.point[:, ::-1] * vector,
        forces.torque[:, ::-1] * axial,
    )
    a = inverse_dynamics(human, qpos, qvel, qacc, forces)
    b = inverse_dynamics(human, mirrored, tangent(qvel), tangent(qacc), other)
    np.testing.assert_allclose(b.tau, tangent(a.tau), atol=1e-8)


def test_opensim_pelvis_coordinates_have_the_same_power():
    human = person()
    t, qpos, qvel, qacc = movement(human, n=801, dt=0.001)
    m = inverse_dynamics(human, qpos, qvel, qacc)
    names, values = opensim_moments(qpos, m)
    coordinates, q = human.to_coordinates(qpos)
    assert [n.rsplit("_", 1)[0] for n in names] == list(coordinates)
    assert names[:6] == (
        "pelvis_tilt_moment",
        "pelvis_list_moment",
        "pelvis_rotation_moment",
        "pelvis_tx_force",
        "pelvis_ty_force",
        "pelvis_tz_force",
    )
    speed = np.gradient(q, t, axis=0)
    inside = slice(2, -2)
    power = (values * speed)[inside, :6].sum(axis=1)
    expected = m.power[inside, :6].sum(axis=1)
    np.testing.assert_allclose(power, expected, atol=1e-4 * np.abs(expected).max())


def test_residual_is_what_the_ground_should_have_supplied():
    human = person()
    _, qpos, qvel, qacc = movement(human, n=5, dt=0.1)
    m = inverse_dynamics(human, qpos, qvel, qacc)
    c = centroid(human, qpos, qvel, qacc)
    np.testing.assert_allclose(m.residual_force, c.force, atol=1e-9)
    np.testing.assert_allclose(m.residual_moment, c.moment, atol=1e-9)
    forces = feet_forces(np.zeros((5, 2, 3)), np.full((5, 2, 3), np.nan), np.zeros((5, 2, 3)))
    figures = residual_metrics(m, forces)
    size = np.linalg.norm(c.force, axis=1)
    assert figures["residual_force_max_n"] == pytest.approx(size.max())


def test_frames_that_do_not_belong_together_are_refused():
    human = person()
    _, qpos, qvel, qacc = movement(human, n=4)
    with pytest.raises(ParameterError, match="qpos has shape"):
        inverse_dynamics(person("66", "multi-segment"), qpos, qvel, qacc)
    forces = random_forces(human, qpos[:2])
    with pytest.raises(ParameterError, match="one clock"):
        inverse_dynamics(human, qpos, qvel, qacc, forces)
    bad = qvel.copy()
    bad[2, 0] = np.nan
    with pytest.raises(ParameterError, match="frame 2"):
        inverse_dynamics(human, qpos, bad, qacc)

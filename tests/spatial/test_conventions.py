"""The table of conventions: quaternion orders, root velocities, OpenSim's axes and angles."""

import mujoco
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from plantigrade.spatial import conventions as c
from tests.spatial.pinocchio_state import (
    configuration_to_pinocchio,
    free_joint_velocity_to_pinocchio,
)

angle = st.floats(-3.0, 3.0)
tilt = st.floats(-1.5, 1.5)


def quaternions(n=20, seed=0):
    q = np.random.default_rng(seed).normal(size=(n, 4))
    return q / np.linalg.norm(q, axis=1, keepdims=True)


def test_quaternion_orders_are_inverse_and_agree_with_scipy_and_mujoco():
    q = quaternions()
    np.testing.assert_array_equal(c.xyzw_to_wxyz(c.wxyz_to_xyzw(q)), q)
    ours = c.rotation_matrix(q)
    np.testing.assert_allclose(ours, Rotation.from_quat(c.wxyz_to_xyzw(q)).as_matrix(), atol=1e-14)
    back = c.rotation_quaternion(ours)
    np.testing.assert_allclose(back * np.sign((back * q).sum(1, keepdims=True)), q, atol=1e-14)
    for quat, matrix in zip(q, ours, strict=True):
        theirs = np.zeros(9)
        mujoco.mju_quat2Mat(theirs, quat)
        np.testing.assert_allclose(matrix.ravel(), theirs, atol=1e-14)


def test_opensim_axes_are_a_right_handed_turn():
    turn = c.OPENSIM_TO_WORLD
    np.testing.assert_array_equal(turn @ turn.T, np.eye(3))
    assert np.linalg.det(turn) == 1.0
    np.testing.assert_array_equal(turn @ [1, 0, 0], [1, 0, 0])  # forward
    np.testing.assert_array_equal(turn @ [0, 1, 0], [0, 0, 1])  # up
    np.testing.assert_array_equal(turn @ [0, 0, 1], [0, -1, 0])  # right


@given(tilt=angle, roll=tilt, turn=angle)
@settings(max_examples=100, deadline=None)
def test_pelvis_angles_are_opensims(tilt, roll, turn):
    """OpenSim's ground_pelvis: z by tilt, then x by list, then y by rotation, all in its axes."""
    theirs = Rotation.from_euler("ZXY", [tilt, roll, turn]).as_matrix()
    ours = c.rotation_matrix(c.pelvis_angles_to_quaternion(np.array([tilt, roll, turn])))
    np.testing.assert_allclose(ours, c.OPENSIM_TO_WORLD @ theirs @ c.OPENSIM_TO_WORLD.T, atol=1e-12)


@given(tilt=tilt, roll=tilt, turn=angle)
@settings(max_examples=100, deadline=None)
def test_pelvis_angles_come_back(tilt, roll, turn):
    angles = np.array([[tilt, roll, turn]])
    back = c.quaternion_to_pelvis_angles(c.pelvis_angles_to_quaternion(angles))
    np.testing.assert_allclose(back, angles, atol=1e-8)


def test_a_walk_in_circles_has_a_heading_without_jumps():
    heading = np.linspace(0, 6 * np.pi, 400)
    angles = np.stack([0.1 * np.sin(heading), 0.05 * np.cos(heading), heading], axis=1)
    back = c.quaternion_to_pelvis_angles(c.pelvis_angles_to_quaternion(angles))
    np.testing.assert_allclose(back, angles, atol=1e-9)


def test_root_velocity_moves_both_engines_alike():
    pin = pytest.importorskip("pinocchio")
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>"
    )
    rng = np.random.default_rng(1)
    for quat in quaternions(seed=2):
        q = np.concatenate([rng.normal(size=3), quat])
        v = rng.normal(size=6)
        moved = q.copy()
        mujoco.mj_integratePos(model, moved, v, 1e-6)
        vp = free_joint_velocity_to_pinocchio(q, v)
        theirs = pin.integrate(
            _free_flyer(pin),
            configuration_to_pinocchio(q),
            1e-6 * vp,
        )
        np.testing.assert_allclose(configuration_to_pinocchio(moved), theirs, atol=1e-11)


def _free_flyer(pin):
    model = pin.Model()
    model.addJoint(0, pin.JointModelFreeFlyer(), pin.SE3.Identity(), "root")
    return model


def test_a_foot_that_is_less_tilted_keeps_its_heading():
    slope, heading = np.radians([20.0, 35.0])
    foot = (
        c.about_vertical(heading) @ c.about_axis(np.array([0.0, 1.0, 0.0]), np.array([-slope]))[0]
    )
    for part in (0.0, 0.5, 1.0):
        found = c.less_tilted(foot, part)
        assert np.arccos(found[2, 2]) == pytest.approx((1.0 - part) * slope, abs=1e-6)
        assert np.arctan2(found[1, 0], found[0, 0]) == pytest.approx(heading)
        np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-12)

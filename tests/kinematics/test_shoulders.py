"""Shoulders keep the anatomical triple of angles: overhead, through the horizontal, across gaps."""

import numpy as np
import pytest

from plantigrade.constants import GRAVITY
from plantigrade.dynamics.ball_joints import BallJoint
from plantigrade.dynamics.derivatives import differentiate
from plantigrade.dynamics.inverse import inverse_dynamics
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.shoulders import (
    ARM,
    arms_of,
    counted_on,
    equivalent_angles,
    range_excess,
)
from plantigrade.models import Human
from plantigrade.motion import Markers, Motion
from tests.kinematics.test_fit import NAMES, markers_of, recording, walker

N = 160
ARM_MARKERS = "LELB RELB LWRA LWRB RWRA RWRB LFIN RFIN".split()
POSE_STEP = 20.0  # largest turn of an arm from frame to frame [deg]: 2 mm of noise give up to 17
GAP = slice(60, 85)  # a quarter of a second without markers on the arms


def ramp(first: float, last: float, start: int, stop: int) -> np.ndarray:
    """Return a smooth passage [deg] from one angle to another between two frames."""
    part = np.clip((np.arange(N) - start) / (stop - start), 0, 1)
    return first + (last - first) * part * part * (3 - 2 * part)


# Flexion, adduction, rotation of both shoulders [deg].
ARMS = {
    "lowered sideways": (0 * ramp(0, 1, 0, 1), ramp(-165, -10, 40, 130), ramp(-80, 0, 40, 130)),
    "lowered forward": (ramp(172, 5, 40, 130), ramp(-8, -8, 0, 1), 0 * ramp(0, 1, 0, 1)),
    "up and down": (0 * ramp(0, 1, 0, 1), ramp(-8, -150, 10, 70) + ramp(0, 142, 90, 150), 0),
    "held out": (0 * ramp(0, 1, 0, 1), ramp(-90, -90, 0, 1), 0),
    "behind the back": (ramp(-35, -35, 0, 1), ramp(5, 5, 0, 1), ramp(80, 80, 0, 1)),
    "behind the head": (ramp(20, 20, 0, 1), ramp(-120, -120, 0, 1), ramp(-60, -60, 0, 1)),
}


def moved(arms: str):
    """Return a walker with its arms moved so: human, time, qpos."""
    human, time, qpos = walker(N)
    for side in "rl":
        for name, angle in zip(ARM, ARMS[arms], strict=True):
            qpos[:, 7 + human.hinge(f"{name}_{side}")] = np.deg2rad(angle)
    return human, time, qpos


@pytest.mark.parametrize(
    ("arms", "gap"),
    [
        pytest.param(arms, gap, marks=() if arms == "lowered forward" and gap else pytest.mark.slow)
        for arms in ARMS
        for gap in (False, True)
    ],
)
def test_arms_keep_their_branch(arms, gap):
    human, time, qpos = moved(arms)
    markers = markers_of(human, time, qpos, noise=0.002)
    if gap:
        markers.positions[GAP, [[NAMES.index(name)] for name in ARM_MARKERS]] = np.nan
    fit = fit_markers(recording(Markers(markers.names, time, markers.positions)))
    assert fit.metrics["marker_rms_worst_frame_mm"] < 10
    for side, hinges in zip("rl", arms_of(fit.human), strict=True):
        found, truth = (q[:, 7:][:, hinges] for q in (fit.qpos, qpos))
        assert range_excess(found).max() < 0.5
        assert np.rad2deg(np.abs(found[:, 1] - truth[:, 1])).max() < 15
        # The arm itself turns by 3° a frame. Where it passes the horizontal, flexion and rotation
        # turn by more, against each other; the other triple of angles is 180° away.
        quat = BallJoint(side, hinges).quaternions(found)
        turned = 2 * np.arccos(np.clip(np.abs((quat[1:] * quat[:-1]).sum(axis=1)), 0, 1))
        assert np.rad2deg(turned).max() < POSE_STEP
        assert np.rad2deg(np.abs(np.diff(found, axis=0))).max() < 45


def test_the_other_triple_is_the_same_pose():
    human, _, qpos = moved("up and down")
    markers = markers_of(human, None, qpos[:1], noise=0)
    for hinges in arms_of(human):
        qpos[:1, 7:][:, hinges] = equivalent_angles(qpos[:1, 7:][:, hinges])
    again = markers_of(human, None, qpos[:1], noise=0)
    np.testing.assert_allclose(again.positions, markers.positions, atol=1e-9)


@pytest.mark.parametrize("cutoff", [None, 6.0])
def test_an_arm_that_changes_branch_pushes_nothing(cutoff):
    """The same pose by the other triple from one frame to the next: no force comes of it."""
    human, time, qpos = moved("up and down")
    other = qpos.copy()
    half = slice(75, None)
    for hinges in arms_of(human):
        other[half, 7:][:, hinges] = equivalent_angles(other[half, 7:][:, hinges])
        columns = 7 + np.array(hinges)
        other[half, columns] = equivalent_angles(qpos[half, columns])
    left = []
    for q in (qpos, other):
        d = differentiate(human, time, q, cutoff)
        left.append(inverse_dynamics(human, d.qpos, d.qvel, d.qacc).residual_force)
    weight = human.mass * GRAVITY
    assert np.abs(left[0] - left[1]).max() < 0.01 * weight


def test_angles_go_on_where_the_limits_would_turn_them_over():
    """The pushed angles are those of one branch again, with their rates."""
    human, time, qpos = moved("up and down")
    smooth = differentiate(human, time, qpos, 6.0)
    one = Motion(time, smooth.qpos, smooth.qvel, human.joint_names, smooth.qacc)
    q, v, a = smooth.qpos.copy(), smooth.qvel.copy(), smooth.qacc.copy()
    for hinges in arms_of(human):
        k = 7 + np.array(hinges)
        q[75:, k] = equivalent_angles(q[75:, k])
        v[75:, k[1] - 1] *= -1.0
        a[75:, k[1] - 1] *= -1.0
    other = Motion(time, q, v, human.joint_names, a)
    assert np.abs(np.diff(other.qpos[:, 7:], axis=0)).max() > 3.0  # half a turn
    again = counted_on(human, other)
    np.testing.assert_allclose(again.qpos, one.qpos, atol=1e-9)
    np.testing.assert_allclose(again.qvel, one.qvel, atol=1e-9)
    assert again.qacc is not None
    np.testing.assert_allclose(again.qacc, one.qacc, atol=1e-9)
    assert counted_on(human, one) is one


def test_rates_of_a_shoulder_are_those_of_its_angles():
    """Near the horizontal, where it is treated as one rotation, without a filter."""
    human = Human.create(1.74)
    time = np.arange(200) / 100
    qpos = np.tile(human.standing(), (200, 1))
    k = 7 + human.hinge("arm_add_r")
    qpos[:, k] = -1.0 - 0.4 * np.sin(2 * np.pi * time)
    d = differentiate(human, time, qpos, None)
    np.testing.assert_allclose(d.qpos, qpos, atol=1e-9)
    speed = -0.4 * 2 * np.pi * np.cos(2 * np.pi * time)
    np.testing.assert_allclose(d.qvel[:, k - 1], speed, atol=0.01)
    bend = 0.4 * (2 * np.pi) ** 2 * np.sin(2 * np.pi * time)
    np.testing.assert_allclose(d.qacc[5:-5, k - 1], bend[5:-5], atol=0.05)

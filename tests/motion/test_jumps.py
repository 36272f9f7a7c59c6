"""Sudden turns of joints are found where they are; fast motion and whole turns are none."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.io import read
from plantigrade.io.bvh import read_bvh
from plantigrade.models.joint_names import identify
from plantigrade.motion import SkeletonMotion
from plantigrade.motion.jumps import jumps, unwrapped


def limb(angles, rate: float = 120.0) -> SkeletonMotion:
    """Return three bones in a row that turn by the same angles [rad] against each other."""
    n = len(angles)
    one = Rotation.from_rotvec(np.outer(angles, [0.0, 1.0, 0.0])).as_matrix()
    rotations = np.stack([one, one @ one, one @ one @ one], axis=1)
    zero = np.zeros((n, 3, 3))
    time = np.arange(n) / rate
    names, parents = ("hip", "knee", "ankle"), (-1, 0, 1)
    return SkeletonMotion(names, parents, time, zero, rotations, np.zeros((3, 3)), zero)


def knee_off(angle: float, frames: slice) -> SkeletonMotion:
    """Return a limb that swings, its second bone and what is below turned further for a while."""
    limbs = limb(0.3 * np.sin(np.arange(120) / 12))
    more = Rotation.from_rotvec([0, angle, 0]).as_matrix()
    rotations = limbs.rotations.copy()
    rotations[frames, 1:] = rotations[frames, 1:] @ more
    return replace(limbs, rotations=rotations)


def test_a_jump_is_at_its_joint():
    (found,) = jumps(knee_off(np.deg2rad(38), slice(50, None)), [0, 1, 2])
    assert found.joint == "knee" and found.time == pytest.approx(50 / 120)
    assert np.rad2deg(found.angle) == pytest.approx(38, abs=3)
    assert str(found) == f"knee by {np.rad2deg(found.angle):.0f}° at 0.42 s"


def test_a_spike_is_two():
    assert [j.joint for j in jumps(knee_off(np.deg2rad(38), slice(50, 51)), [0, 1, 2])] == [
        "knee",
        "knee",
    ]


def test_fast_motion_is_none():
    """A kick: the knee is brought to 1500 degrees a second within 50 ms."""
    time = np.arange(120) / 120
    speed = np.deg2rad(1500) * np.exp(-(((time - 0.5) / 0.05) ** 2))
    assert not jumps(limb(np.cumsum(speed) / 120), [0, 1, 2])


def test_a_whole_turn_is_none(data, tmp_path):
    """A BVH file whose angles are wrapped holds the same motion."""
    whole = data / "cmu_bvh" / "13_11.bvh"
    head, _, rows = whole.read_text().partition("Frame Time:")
    lines = rows.splitlines()
    for k in range(100, 200):
        values = lines[k].split()
        values[5] = f"{float(values[5]) + 360:.6f}"
        values[-7] = f"{float(values[-7]) - 360:.6f}"
        lines[k] = " ".join(values)
    wrapped = tmp_path / "wrapped.bvh"
    wrapped.write_text(head + "Frame Time:" + "\n".join(lines))
    one, other = read_bvh(whole).skeleton, read_bvh(wrapped).skeleton
    np.testing.assert_allclose(other.rotations, one.rotations, atol=1e-9)
    assert not jumps(other, list(range(len(other.names))))


@pytest.mark.parametrize(
    ("name", "joint"),
    [
        ("deepmimic/humanoid3d_run.txt", None),
        ("deepmimic/humanoid3d_jump.txt", None),
        ("cmu_bvh/09_12.bvh", None),
        ("deepmimic/humanoid3d_walk.txt", "left_shoulder"),
    ],
)
def test_recordings(data, name, joint):
    skeleton = read(data / name).skeleton
    found = identify(skeleton.names, skeleton.parents, skeleton.rest_positions)
    names = {jump.joint for jump in jumps(skeleton, sorted(set(found.joints.values())))}
    assert names == ({joint} if joint else set())


def test_angles_are_led_on_over_a_whole_turn():
    smooth = np.stack([np.linspace(-0.4, 0.8, 50), np.linspace(3.0, 3.4, 50)], axis=1)
    wrapped = smooth.copy()
    wrapped[20:, 0] -= 2 * np.pi
    wrapped[:, 1] = (wrapped[:, 1] + np.pi) % (2 * np.pi) - np.pi
    led = unwrapped(wrapped)
    np.testing.assert_allclose(np.diff(led, axis=0), np.diff(smooth, axis=0), atol=1e-12)
    np.testing.assert_allclose(led[:, 0], smooth[:, 0], atol=1e-12)

"""BVH of today's programs: names, axes, units, rests that are no standing person."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.io import read
from plantigrade.io.bvh import read_bvh
from plantigrade.io.bvh_writer import write_bvh
from plantigrade.kinematics.coordinate_fit import fit_coordinates
from plantigrade.kinematics.retarget import fit_skeleton
from plantigrade.models.joint_names import identify
from plantigrade.motion import Recording, SkeletonMotion, Table
from tests.kinematics.test_retarget import exported

OURS = "hip knee ankle ball shoulder elbow wrist".split()
# Names of the left joints in the order of OURS, then pelvis, thorax and head.
DIALECTS = {
    "SOMA": "LeftLeg LeftShin LeftFoot LeftToeBase LeftArm LeftForeArm LeftHand Hips Chest Head",
    "LAFAN1": "LeftUpLeg LeftLeg LeftFoot LeftToe LeftArm LeftForeArm LeftHand Hips Spine2 Head",
    "Mixamo": "mixamorig:LeftUpLeg mixamorig:LeftLeg mixamorig:LeftFoot mixamorig:LeftToeBase "
    "mixamorig:LeftArm mixamorig:LeftForeArm mixamorig:LeftHand mixamorig:Hips mixamorig:Spine2 "
    "mixamorig:Head",
    "Rokoko": "LeftThigh LeftShin LeftFoot LeftToe LeftArm LeftForeArm LeftHand Hips Spine4 Head",
    "Xsens": "LeftHip LeftKnee LeftAnkle LeftToe LeftShoulder LeftElbow LeftWrist Hips Chest4 Head",
    "CMU": "LeftUpLeg LeftLeg LeftFoot LeftToeBase LeftArm LeftForeArm LeftHand Hips Spine1 Head",
    "Neuron": "Robot_LeftUpLeg Robot_LeftLeg Robot_LeftFoot Robot_LeftToe Robot_LeftArm "
    "Robot_LeftForeArm Robot_LeftHand Robot_Hips Robot_Spine3 Robot_Head",
    "SMPL": "left_hip left_knee left_ankle left_foot left_shoulder left_elbow left_wrist pelvis "
    "spine3 head",
    "PHC": "L_Hip L_Knee L_Ankle L_Toe L_Shoulder L_Elbow L_Wrist Pelvis Chest Head",
    "Bip01": "Bip01_L_Thigh Bip01_L_Calf Bip01_L_Foot Bip01_L_Toe0 Bip01_L_UpperArm "
    "Bip01_L_Forearm Bip01_L_Hand Bip01_Pelvis Bip01_Spine1 Bip01_Head",
    "Unreal": "thigh_l calf_l foot_l ball_l upperarm_l lowerarm_l hand_l pelvis spine_03 head",
}
RIGHT = {"Left": "Right", "left_": "right_", "L_": "R_", "_L_": "_R_"}


def names_of(dialect: str) -> dict[str, str]:
    """Return our names of the joints → those of a dialect."""
    words = DIALECTS[dialect].split()
    named = dict(zip((*(f"{j}_l" for j in OURS), "pelvis", "thorax", "head"), words, strict=True))
    for joint in OURS:
        left = named[f"{joint}_l"]
        mirrored = (left.replace(a, b, 1) for a, b in RIGHT.items() if a in left)
        named[f"{joint}_r"] = next(mirrored, f"{left.removesuffix('_l')}_r")
    return named


@pytest.fixture(scope="module")
def walk(data) -> Recording:
    """A recorded walk as a foreign skeleton, its rest pose quiet standing."""
    recording = read(data / "opensim" / "rajagopal_walk" / "coordinates.sto")
    whole = recording.coordinates
    part = Table(whole.names, whole.time[::10], whole.values[::10])
    fit = fit_coordinates(replace(recording, coordinates=part))
    return exported(fit.human, fit.qpos, rate=100.0)


def named(skeleton: SkeletonMotion, dialect: str) -> SkeletonMotion:
    own = names_of(dialect)
    return replace(skeleton, names=tuple(own[n.replace("thigh", "hip")] for n in skeleton.names))


@pytest.mark.parametrize("dialect", DIALECTS)
def test_joints_are_found_by_the_names_of(dialect, walk):
    skeleton = named(walk.skeleton, dialect)
    found = identify(skeleton.names, skeleton.parents, skeleton.rest_positions)
    assert found.by == "names"
    own = names_of(dialect)
    assert {name: skeleton.names[found[name]] for name in own} == own


def baked(skeleton: SkeletonMotion, pelvis: np.ndarray) -> SkeletonMotion:
    """Return a skeleton whose joints have x along their bones and no rotation of its own at rest.

    Args:
        skeleton: The skeleton.
        pelvis: Axes of the pelvis at rest.
    """
    rest, k = skeleton.rest_positions, len(skeleton.names)
    children = {parent: i for i, parent in reversed(list(enumerate(skeleton.parents)))}
    B = np.empty((k, 3, 3))
    for i in range(k):
        along = rest[children[i]] - rest[i] if i in children else np.array([0.0, 0, 1])
        B[i] = Rotation.align_vectors(along[None], [[1.0, 0, 0]])[0].as_matrix()
    B[0] = pelvis
    offsets = np.zeros((k, 3))
    for i, parent in enumerate(skeleton.parents):
        if parent >= 0:
            local = B[parent].T @ (rest[i] - rest[parent])
            offsets[i] = offsets[parent] + local
    return replace(skeleton, rotations=skeleton.rotations @ B, rest_positions=offsets)


UP_FORWARD_LEFT = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])  # columns: x up, y forward, z left


def means(fit) -> dict[str, float]:
    """Return the mean hip flexion and forward tilt of the pelvis [deg]."""
    w, x, y, z = fit.qpos[:, 3:7].T
    tilt = np.rad2deg(np.arcsin(2 * (w * y - x * z))).mean()
    joint = fit.human.model.joint("hip_flexion_r").qposadr[0]
    return {"tilt": tilt, "hip": np.rad2deg(fit.qpos[:, joint]).mean()}


def test_bones_along_x_keep_the_tilt_of_the_pelvis(walk, tmp_path):
    """The zero pose of such a file is no person: the rest is a frame, in which a pelvis tilts."""
    body, forward = walk.skeleton, Rotation.from_rotvec([0.0, np.deg2rad(8.0), 0.0]).as_matrix()
    R = body.rotations.copy()
    R[:, 0] = R[:, 0] @ forward
    tilted = replace(walk, skeleton=replace(body, rotations=R))
    skeleton = baked(named(tilted.skeleton, "LAFAN1"), UP_FORWARD_LEFT)
    recording = read_bvh(write_bvh(skeleton, tmp_path / "a.bvh"))
    assert any("an upright frame" in note for note in recording.warnings)
    got, plain = means(fit_skeleton(recording)), means(fit_skeleton(tilted))
    assert plain["tilt"] > 6.0
    assert got["tilt"] == pytest.approx(plain["tilt"], abs=1.0)
    assert got["hip"] == pytest.approx(plain["hip"], abs=1.5)


Y_UP = np.array([[0.0, 1, 0], [0, 0, 1], [1, 0, 0]])  # rows: axes of the file in ours
FILE_AXES = {
    "y up": Y_UP,
    "z up": np.eye(3),
    "z up, facing -y": np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
    "x up": np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]]),
    "-y up": np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]]),
}


def in_axes(skeleton: SkeletonMotion, axes: np.ndarray) -> SkeletonMotion:
    """Return a skeleton that our writer, which writes y up, puts into a file with other axes."""
    Q = Y_UP.T @ axes
    return replace(
        skeleton,
        positions=skeleton.positions @ Q.T,
        rotations=Q @ skeleton.rotations @ Q.T,
        rest_positions=skeleton.rest_positions @ Q.T,
    )


def under_a_root(skeleton: SkeletonMotion) -> SkeletonMotion:
    """Return a skeleton with a root above the pelvis that does not move."""
    n = len(skeleton.time)
    still = np.zeros((n, 1, 3))
    return replace(
        skeleton,
        names=("Root", *skeleton.names),
        parents=(-1, *(parent + 1 for parent in skeleton.parents)),
        positions=np.concatenate([still, skeleton.positions], axis=1),
        rotations=np.concatenate([np.tile(np.eye(3), (n, 1, 1, 1)), skeleton.rotations], axis=1),
        rest_positions=np.concatenate([still[0], skeleton.rest_positions]),
        ends=np.concatenate([still, skeleton.ends], axis=1),
    )


def same_motion(found: SkeletonMotion, expected: SkeletonMotion) -> None:
    """Compare heights and the rotations of joints relative to the pelvis."""
    rows = [found.names.index(name) for name in expected.names]
    heights = found.positions[:, rows, 2] - expected.positions[..., 2]
    assert np.ptp(heights) < 2e-3
    inner = [
        np.swapaxes(R[:, :1], 2, 3) @ R for R in (found.rotations[:, rows], expected.rotations)
    ]
    np.testing.assert_allclose(*inner, atol=1e-4)


@pytest.mark.parametrize("axes", FILE_AXES)
@pytest.mark.parametrize("unit", ["m", "cm", "mm"])
def test_any_axes_and_units_give_the_same_motion(walk, tmp_path, axes, unit):
    skeleton = named(walk.skeleton, "Mixamo")
    path = write_bvh(in_axes(skeleton, FILE_AXES[axes]), tmp_path / "a.bvh", unit=unit)
    same_motion(read_bvh(path).skeleton, skeleton)


@pytest.mark.parametrize("rest", ["standing", "no person"])
def test_end_sites_and_a_root_above_the_pelvis_change_nothing(walk, tmp_path, rest):
    skeleton = named(walk.skeleton, "SOMA")
    if rest == "no person":
        skeleton = baked(skeleton, UP_FORWARD_LEFT)
    plain = read_bvh(write_bvh(skeleton, tmp_path / "a.bvh")).skeleton
    path = write_bvh(under_a_root(skeleton), tmp_path / "b.bvh")
    text = path.read_text("utf-8")
    path.write_text(re.sub(r"\s*End Site\s*\{[^}]*\}", "", text), "utf-8")
    assert "End Site" not in path.read_text("utf-8")
    same_motion(read_bvh(path).skeleton, plain)

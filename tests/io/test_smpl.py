"""Pose parameters of SMPL: layouts, axes, kinematics of other engines, our own motion again."""

import pickle
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from plantigrade.errors import FileError, ParameterError, PlantigradeError
from plantigrade.io import format_of, read
from plantigrade.io.skeletons import tree_kinematics
from plantigrade.io.smpl import PELVIS_TILT, leg_factors, read_smpl
from plantigrade.io.smpl_tree import NAMES, PARENTS, mean_offsets
from plantigrade.kinematics.coordinate_fit import fit_coordinates
from plantigrade.kinematics.retarget import fit_skeleton
from plantigrade.models import Human, Person
from plantigrade.motion import Table
from tests.io.smpl_files import smpl_arrays

TO_OURS = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
UPRIGHT = np.array([np.pi / 2, 0, 0])  # rotation vector that takes y up to z up


def random_poses(n: int = 6, width: int = 156) -> dict[str, np.ndarray]:
    """Return an AMASS motion of moderate rotations, upright, that moves forward."""
    rng = np.random.default_rng(0)
    poses = 0.3 * rng.normal(size=(n, width))
    poses[:, :3] = UPRIGHT
    trans = np.cumsum(0.05 * rng.normal(size=(n, 3)), axis=0)
    rate, gender = np.array(60.0), np.array("female")
    return {"poses": poses, "trans": trans, "mocap_framerate": rate, "gender": gender}


@pytest.fixture
def file(tmp_path):
    def write(arrays, name: str = "a.npz"):
        path = tmp_path / name
        if path.suffix == ".npz":
            np.savez(path, **arrays)
        else:
            path.write_bytes(pickle.dumps(arrays))
        return path

    return write


def joint(recording, name: str) -> np.ndarray:
    return recording.skeleton.positions[:, NAMES.index(name)]


def test_without_rotations_it_is_a_standing_t_pose_that_faces_x(file):
    still = random_poses()
    still["poses"] = np.tile([*UPRIGHT, *np.zeros(153)], (6, 1))
    still["trans"] = np.tile([1.0, 2.0, 3.0], (6, 1))
    recording = read(file(still))
    body = recording.skeleton
    assert recording.subject.sex == "female"
    assert body.time[1] == pytest.approx(1 / 60)
    # The model faces z with y up: AMASS turns it to -y, so left is x.
    across = (joint(recording, "left_hip") - joint(recording, "right_hip"))[0]
    np.testing.assert_allclose(across / np.linalg.norm(across), [1, 0, 0], atol=1e-9)
    toes = (joint(recording, "left_foot") - joint(recording, "left_ankle"))[0]
    assert toes[1] < -0.1 and abs(toes[0]) < 1e-9
    # Rest pose: x forward, y left, z up; the pelvis leans forward by the tilt of standing people.
    rest = dict(zip(NAMES, body.rest_positions, strict=True))
    assert rest["left_wrist"][1] > 0.6 and rest["left_wrist"][2] > 0.3
    assert rest["left_foot"][0] - rest["left_ankle"][0] == pytest.approx(0.13, abs=0.02)
    assert rest["head"][2] > 0.4 and rest["left_ankle"][2] < -0.85
    axis = body.rotations[0, 0] @ [1.0, 0, 0]
    np.testing.assert_allclose(axis, [0, -np.cos(PELVIS_TILT), -np.sin(PELVIS_TILT)], atol=1e-9)
    np.testing.assert_allclose(joint(recording, "pelvis")[0], [1, 1.78, 3.03], atol=1e-9)


def test_kinematics_agree_with_mujoco():
    rng = np.random.default_rng(1)
    offsets = mean_offsets(1.7, "male")
    vectors, root = rng.normal(size=(5, 22, 3)), rng.normal(size=(5, 3))
    spec = mujoco.MjSpec()
    bodies = [spec.worldbody]
    for j, parent in enumerate(PARENTS):
        body = bodies[parent + 1].add_body(name=NAMES[j], pos=offsets[j])
        body.mass, body.inertia = 1.0, np.ones(3)
        kind = mujoco.mjtJoint.mjJNT_FREE if j == 0 else mujoco.mjtJoint.mjJNT_BALL
        body.add_joint(name=NAMES[j], type=kind)
        bodies.append(body)
    model = spec.compile()
    data = mujoco.MjData(model)
    R, p = tree_kinematics(
        PARENTS,
        Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix().reshape(5, 22, 3, 3),
        root,
        offsets,
    )
    quat = np.empty(4)
    for k in range(5):
        data.qpos[:3] = root[k]
        for j in range(22):
            angle = np.linalg.norm(vectors[k, j])
            mujoco.mju_axisAngle2Quat(quat, vectors[k, j] / angle, angle)
            first = model.joint(NAMES[j]).qposadr[0] + 3 * (j == 0)
            data.qpos[first : first + 4] = quat
        mujoco.mj_kinematics(model, data)
        order = [model.body(name).id for name in NAMES]
        np.testing.assert_allclose(p[k], data.xpos[order], atol=1e-12)
        np.testing.assert_allclose(R[k], data.xmat[order].reshape(-1, 3, 3), atol=1e-12)


@pytest.mark.slow
def test_kinematics_agree_with_the_smplx_library():
    torch, lbs = pytest.importorskip("torch"), pytest.importorskip("smplx.lbs")
    names = pytest.importorskip("smplx.joint_names").JOINT_NAMES
    assert tuple(names[:22]) == NAMES
    rng = np.random.default_rng(2)
    offsets = mean_offsets(1.7, None)
    vectors, root = rng.normal(size=(5, 22, 3)), rng.normal(size=(5, 3))
    rest = np.zeros((22, 3))
    for j, parent in enumerate(PARENTS[1:], start=1):
        rest[j] = rest[parent] + offsets[j]
    theirs = lbs.batch_rodrigues(torch.tensor(vectors.reshape(-1, 3))).reshape(5, 22, 3, 3)
    joints = torch.tensor(np.tile(rest, (5, 1, 1)))
    places, _ = lbs.batch_rigid_transform(theirs, joints, torch.tensor(PARENTS))
    ours = Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix().reshape(5, 22, 3, 3)
    _, p = tree_kinematics(PARENTS, ours, root, offsets)
    # The library adds the translation to the joints after the rotations, the pelvis unmoved.
    np.testing.assert_allclose(p, places.numpy() + root[:, None], atol=1e-6)


def y_up(arrays: dict) -> dict:
    """Return the rotations and translations of an AMASS motion in a world with y up."""
    turn = Rotation.from_rotvec(-UPRIGHT)
    poses = arrays["poses"].copy()
    poses[:, :3] = (turn * Rotation.from_rotvec(poses[:, :3])).as_rotvec()
    # The pelvis is at the translation plus a point that does not turn with the world.
    pelvis = np.array([0.0, -0.22, 0.03])
    return {**arrays, "poses": poses, "trans": turn.apply(arrays["trans"] + pelvis) - pelvis}


def test_every_layout_gives_the_same_motion(file):
    amass = random_poses()
    same = y_up(amass)
    body, rate = same["poses"][:, 3:66], {"mocap_framerate": amass["mocap_framerate"]}
    parts = {"global_orient": same["poses"][:, :3], "body_pose": body, "transl": same["trans"]}
    expected = read(file(amass)).skeleton
    root = expected.positions[:, 0] - expected.positions[0, 0]
    aist = {
        "smpl_poses": same["poses"][:, :72], "smpl_trans": 93.0 * same["trans"],
        "smpl_scaling": np.array([93.0]), "smpl_loss": 0.1, **rate,
    }  # fmt: skip
    matrices = Rotation.from_rotvec(body.reshape(-1, 3)).as_matrix().reshape(6, 21, 3, 3)
    layouts = {
        "short.npz": {**amass, "poses": amass["poses"][:, :72]},
        "parts.npz": {
            "root_orient": amass["poses"][:, :3], "pose_body": amass["poses"][:, 3:66],
            "trans": amass["trans"], "mocap_frame_rate": np.array(60.0),
        },
        "gvhmr.pkl": {"smpl_params_global": {**parts, **rate}, "smpl_params_incam": parts},
        "matrices.pkl": {**parts, "body_pose": matrices, **rate},
        "aist.pkl": aist,
        "amass.pkl": amass,
    }  # fmt: skip
    for name, arrays in layouts.items():
        got = read(file(arrays, name)).skeleton
        moved = got.positions[:, 0] - got.positions[0, 0]
        turned = got.rotations[:, 0] @ np.swapaxes(expected.rotations[:, 0], 1, 2)
        np.testing.assert_allclose(turned, turned[:1].repeat(6, 0), atol=1e-6, err_msg=name)
        np.testing.assert_allclose(moved, root @ turned[0].T, atol=1e-6, err_msg=name)
        inner = np.swapaxes(got.rotations[:, :1], 2, 3) @ got.rotations
        inside = np.swapaxes(expected.rotations[:, :1], 2, 3) @ expected.rotations
        np.testing.assert_allclose(inner, inside, atol=1e-6, err_msg=name)


def test_wham_gives_the_middle_of_the_hips_and_the_person_seen_longest(file):
    motion = y_up(random_poses())
    person = {"pose_world": motion["poses"][:, :72], "trans_world": motion["trans"]}
    short = {key: value[:2] for key, value in person.items()}
    recording = read(file({1: short, 3: {**person, "pose": np.zeros((6, 72))}}, "wham.pkl"))
    hips = 0.5 * (joint(recording, "left_hip") + joint(recording, "right_hip"))
    np.testing.assert_allclose(hips, motion["trans"] @ TO_OURS.T, atol=0.01)
    assert any("2 people" in note for note in recording.warnings)
    assert any("30 Hz was assumed" in note for note in recording.warnings)


def test_the_rate_can_be_given(file):
    path = file({**random_poses(), "mocap_framerate": np.array(100.0)})
    assert read(path, rate=50).skeleton.time[1] == pytest.approx(0.02)
    with pytest.raises(ParameterError, match="allowed is 1 to 1000 Hz"):
        read_smpl(path, rate=0.0)


@pytest.mark.parametrize("gender", ["male", b"male", "b'male'", "MALE", "m"])
def test_gender_is_text_or_bytes(file, gender):
    assert read(file({**random_poses(), "gender": np.array(gender)})).subject.sex == "male"
    assert read(file({**random_poses(), "gender": gender}, "a.pkl")).subject.sex == "male"


def test_a_body_model_gives_the_lengths(file, tmp_path):
    rng = np.random.default_rng(3)
    v, S, W = rng.normal(size=(40, 3)), rng.normal(size=(40, 3, 4)), rng.random((24, 40))
    np.savez(tmp_path / "model.npz", v_template=v, shapedirs=S, J_regressor=W)
    betas = np.array([0.5, -1.0, 2.0, 0.1, 7.0])
    path = file({**random_poses(), "betas": betas})
    body = read(path, skeleton=tmp_path / "model.npz").skeleton
    J = W @ (v + S @ betas[:4])
    thigh = np.linalg.norm(J[4] - J[1])
    np.testing.assert_allclose(
        np.linalg.norm(body.positions[:, 4] - body.positions[:, 1], axis=1), thigh, rtol=1e-9
    )
    np.testing.assert_allclose(body.rest_positions[15], TO_OURS @ (J[15] - J[0]), atol=1e-9)
    np.savez(tmp_path / "other.npz", v_template=v[:9], shapedirs=S, J_regressor=W)
    with pytest.raises(FileError, match="no body model"):
        read(path, skeleton=tmp_path / "other.npz")


GOOD = random_poses()
BAD = {
    "columns": ({**GOOD, "poses": np.zeros((6, 69))}, "poses: has 23 joints; 22, 24, 52, 55"),
    "not three": ({**GOOD, "poses": np.zeros((6, 70))}, "not three per joint"),
    "frames": ({**GOOD, "trans": np.zeros((5, 3))}, r"has shape \(6, 156\), but trans has 5"),
    "trans": ({**GOOD, "trans": np.zeros((6, 2))}, r"trans: has shape \(6, 2\)"),
    "no frames": ({**GOOD, "trans": np.zeros((0, 3))}, r"has shape \(0, 3\)"),
    "words": ({**GOOD, "poses": np.full((6, 72), "x")}, "not numbers"),
    "gaps": ({**GOOD, "trans": np.full((6, 3), np.nan)}, "trans: holds numbers that are not fin"),
    "centimetres": ({**GOOD, "trans": 100.0 * GOOD["trans"]}, "at most 15 m/s .* in metres"),
    "degrees": ({**GOOD, "poses": np.full((6, 72), 1e6)}, "no rotation of a joint"),
    "rate": ({**GOOD, "mocap_framerate": np.array(0.0)}, "no number of frames per second"),
    "two rates": ({**GOOD, "fps": np.array([1, 2])}, None),
    "no trans": ({"poses": GOOD["poses"]}, "holds no SMPL motion, but poses"),
    "scaling": (
        {"smpl_poses": GOOD["poses"][:, :72], "smpl_trans": GOOD["trans"], "smpl_scaling": 0.0},
        "smpl_scaling: is not one positive number",
    ),
    "camera": ({"pred_rotmat": np.zeros((2, 24, 3, 3)), "pred_cam": 1}, "no ground to stand on"),
    "a list": ([1, 2], "no named arrays"),
    "body": (
        {"root_orient": np.zeros((6, 3)), "pose_body": np.zeros((6, 60)), "trans": GOOD["trans"]},
        "pose_body: has 21 joints with the root; 22 are needed",
    ),
    "matrices": ({**GOOD, "poses": np.ones((6, 24, 3, 3))}, "matrices that are no rotations"),
    "mirrored": ({**GOOD, "poses": -np.tile(np.eye(3), (6, 24, 1, 1))}, "that are no rotations"),
    "scalar": ({**GOOD, "trans": 1.0}, r"trans: has shape \(\)"),
    "none": ({**GOOD, "trans": None}, "trans: is missing"),
}  # fmt: skip


@pytest.mark.parametrize("what", BAD)
def test_what_is_wrong_is_said(file, what):
    arrays, message = BAD[what]
    path = file(arrays, "a.pkl")
    if message is None:
        read_smpl(path)
        return
    with pytest.raises(FileError, match=message):
        read_smpl(path)


def test_formats_are_recognised_by_their_contents(file, tmp_path):
    assert format_of(file(GOOD)).name == "SMPL"
    assert format_of(file(GOOD, "a.pkl")).name == "SMPL"
    assert format_of(file({"qpos": GOOD["poses"], "time": GOOD["trans"]})).name == "npz"
    n = 4000  # whatever comes first: the names of the others are far from both ends
    person = {
        "pose": np.ones((n, 72)),
        "pose_world": np.ones((n, 72)),
        "trans_world": np.ones((n, 3)),
    }
    assert format_of(file({0: person, 1: np.ones((n, 72))}, "c.pkl")).name == "SMPL"
    with pytest.raises(PlantigradeError, match="holds no poses of SMPL"):
        read(file({"weights": np.zeros(3)}, "b.pkl"))
    (tmp_path / "d.npz").touch()
    with pytest.raises(FileError, match="is empty"):
        read(tmp_path / "d.npz")
    (tmp_path / "c.npz").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\n")
    with pytest.raises(FileError, match="pointer of git-lfs.*git lfs pull"):
        read(tmp_path / "c.npz")


def test_leg_lengths_follow_from_feet_that_stand():
    human = Human.create(height=1.85, mass=80.0, sex="male")
    n = 240
    bend = 0.5 * (1 - np.cos(np.linspace(0, 4 * np.pi, n)))[:, None]
    local = np.tile(np.eye(3), (n, 22, 1, 1))
    for name, angle in (("hip", -0.9), ("knee", 1.5), ("ankle", -0.6)):
        for side in ("left", "right"):
            turn = Rotation.from_rotvec(angle * bend * [0.0, 1, 0]).as_matrix()
            local[:, NAMES.index(f"{side}_{name}")] = turn
    offsets = mean_offsets(human.height, "male")
    offsets[[4, 5]] *= 1.03
    _, p = tree_kinematics(PARENTS, local, np.zeros((n, 3)), offsets)
    root = -p[:, NAMES.index("left_foot")]  # the foot stands, the pelvis moves
    found = leg_factors(local, root, mean_offsets(1.70, None), 60.0)
    mean = mean_offsets(1.70, None)
    for factor, error, joint in zip(
        (found.thigh, found.shank), found.standard_errors, (4, 7), strict=True
    ):
        true = np.linalg.norm(offsets[joint]) / np.linalg.norm(mean[joint])
        assert error < 0.03
        assert factor == pytest.approx(true, abs=0.02)
    assert found.stances == 2


@pytest.fixture(scope="module")
def walk(data):
    """A recorded walk of the OpenSim data on our human: 1.5 s of it."""
    recording = read(data / "opensim" / "rajagopal_walk" / "coordinates.sto")
    whole = recording.coordinates
    part = Table(whole.names, whole.time[::10], whole.values[::10])
    fit = fit_coordinates(replace(recording, coordinates=part))
    return fit.human, fit.time, fit.qpos


SAGITTAL = ("hip_flexion", "knee_angle", "ankle_angle")
TOLERANCE_DEG = 2.5


@pytest.mark.parametrize("up", ["z", "y"])
def test_a_recorded_walk_comes_back(walk, tmp_path, up):
    human, time, qpos = walk
    np.savez(tmp_path / "walk.npz", **smpl_arrays(human, time, qpos, up))
    fit = fit_skeleton(read(tmp_path / "walk.npz"))
    for name in (f"{joint}_{side}" for joint in SAGITTAL for side in "rl"):
        ours, theirs = (h.model.joint(name).qposadr[0] for h in (fit.human, human))
        error = np.rad2deg(fit.qpos[:, ours] - qpos[:, theirs])
        assert np.sqrt((error**2).mean()) < TOLERANCE_DEG, name


def test_a_given_height_changes_the_bones_of_amass_and_not_its_path(walk, tmp_path):
    human, time, qpos = walk
    np.savez(tmp_path / "walk.npz", **smpl_arrays(human, time[:40], qpos[:40]))
    recording = read(tmp_path / "walk.npz")
    assert any("stances of the feet give" in note for note in recording.warnings)
    whole = replace(recording.skeleton, lengths_assumed=False)
    tall = Person(height=2.05, mass=90.0)
    fits = [fit_skeleton(each, tall) for each in (recording, replace(recording, skeleton=whole))]
    own, scaled = (np.linalg.norm(np.ptp(fit.qpos[:, :2], axis=0)) for fit in fits)
    true = np.linalg.norm(np.ptp(qpos[:40, :2], axis=0))
    assert own == pytest.approx(true, rel=0.02)
    assert scaled > 1.1 * true

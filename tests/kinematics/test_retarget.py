"""Foreign skeletons: our own motion comes back, mirrors mirror, real files stand on the ground."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

from plantigrade.errors import FitError
from plantigrade.io.amc import read_amc
from plantigrade.io.bvh import read_bvh
from plantigrade.io.deepmimic import read_deepmimic
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.retarget import fit_skeleton
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import ContactFrames, drift_of, find_rests
from plantigrade.models import Human, Person
from plantigrade.models.joint_names import identify, split_name
from plantigrade.motion import Recording, SkeletonMotion

PARTS = {"pelvis": "pelvis", "thorax": "abdomen", "head": "lower_neck"} | {
    f"{joint}_{side}": f"{part}_{side}"
    for side in "rl"
    for joint, part in {
        "hip": "femur", "knee": "tibia", "ankle": "foot", "ball": "toes",
        "shoulder": "humerus", "elbow": "ulna", "wrist": "hand",
    }.items()
}  # fmt: skip
PARENT = {"pelvis": None, "thorax": "pelvis", "head": "thorax"} | {
    f"{joint}_{side}": parent if parent in ("pelvis", "thorax") else f"{parent}_{side}"
    for side in "rl"
    for joint, parent in {
        "hip": "pelvis", "knee": "hip", "ankle": "knee", "ball": "ankle",
        "shoulder": "thorax", "elbow": "shoulder", "wrist": "elbow",
    }.items()
}  # fmt: skip


def exported(human: Human, qpos: np.ndarray, rate: float = 60.0) -> Recording:
    """Return a Human's motion as a foreign skeleton whose rest pose is quiet standing."""
    names = [n for n in PARENT if PARTS[n] in human.skeleton.parts]
    parents = [-1 if PARENT[n] is None else names.index(PARENT[n]) for n in names]
    model, data = human.model, mujoco.MjData(human.model)

    def poses(q):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        p, R = [], []
        for name in names:
            body, offset = human.skeleton.parts[PARTS[name]]
            i = human.body(body)
            R.append(data.xmat[i].reshape(3, 3).copy())
            p.append(data.xpos[i] + R[-1] @ offset)
        return np.array(p), np.array(R)

    rest, R0 = poses(human.standing())
    frames = [poses(q) for q in qpos]
    positions = np.array([p for p, _ in frames])
    rotations = np.array([R @ np.swapaxes(R0, 1, 2) for _, R in frames])
    names = [n.replace("hip", "thigh") for n in names]
    return Recording(
        Path("own"),
        skeleton=SkeletonMotion(
            tuple(names),
            tuple(parents),
            np.arange(len(qpos)) / rate,
            positions,
            rotations,
            rest - rest[0],
            np.full_like(positions, np.nan),
        ),
    )


def steps(human: Human, n: int = 90) -> np.ndarray:
    """Return squats and arm swings on standing feet."""
    q = np.tile(human.standing(), (n, 1))
    bend = 0.6 * np.sin(np.linspace(0, np.pi, n)) ** 2
    swing = 0.5 * np.sin(np.linspace(0, 2 * np.pi, n))
    for side, sign in (("r", 1), ("l", -1)):
        for name, value in {
            "hip_flexion": bend, "knee_angle": 2 * bend, "ankle_angle": bend,
            "arm_flex": sign * swing, "arm_add": -0.15 + 0 * bend,
            "elbow_flex": 0.7 + 0.4 * sign * swing,
        }.items():  # fmt: skip
            q[:, 7 + human.hinge(f"{name}_{side}")] = value
    q[:, 7 + human.hinge("lumbar_extension")] = -0.3 * bend
    q[:, 7 + human.hinge("lumbar_rotation")] = 0.2 * swing
    q[:, 7 + human.hinge("neck_rotation")] = -0.3 * swing
    points = sole_paths(human, q)
    q[:, :3] -= points.position[:, points.of("r", "heel")].mean(axis=1) - points.position[
        0, points.of("r", "heel")
    ].mean(axis=0)
    stance = np.ones((n, 2), bool)
    rests = [ContactFrames(s, region, 0, n) for s in "rl" for region in ("heel", "ball", "toes")]
    return plant_feet(human, q, stance, rate=60.0, rests=rests)


@pytest.mark.parametrize("joints", ["42", "43", "58"])
def test_own_motion_comes_back(joints):
    human = Human.create(1.80, 75, joints=joints)
    q = steps(human)
    fit = fit_skeleton(exported(human, q), Person(height=1.80, joints=joints))
    assert abs(fit.human.dimensions.thigh - human.dimensions.thigh) < 1e-3
    assert fit.metrics["joint_rms_mm"] < 5.0
    legs = [
        i for i, c in enumerate(human.coordinates)
        if c.startswith(("hip", "knee", "ankle", "subtalar", "arm", "elbow", "lumbar"))
    ]  # fmt: skip
    if joints != "42":  # several joints share the back: their sum is what the skeleton shows
        legs = [i for i in legs if "lumbar" not in human.coordinates[i]]
    error = np.rad2deg(np.abs(fit.qpos[:, 7:] - q[:, 7:]))[:, legs]
    assert np.sqrt((error**2).mean()) < 2.0
    assert np.median(error.max(axis=0)) < 2.0


def test_a_scaled_skeleton_gives_the_same_angles():
    """A skeleton in the wrong unit is scaled to the height given; angles do not change."""
    human = Human.create(1.80, 75)
    recording = exported(human, steps(human))
    s = recording.skeleton
    big = replace(
        recording,
        skeleton=replace(
            s, positions=1.3 * s.positions, rest_positions=1.3 * s.rest_positions, ends=s.ends
        ),
    )
    a, b = (fit_skeleton(r, Person(height=1.80)) for r in (recording, big))
    assert np.rad2deg(np.abs(a.qpos[:, 7:] - b.qpos[:, 7:])).mean() < 1.0
    assert any("scaled by" in w for w in b.warnings)


def mirrored(recording: Recording) -> Recording:
    s = recording.skeleton
    M = np.diag([1.0, -1.0, 1.0])
    swap = {"l": "r", "r": "l"}
    names = []
    for name in s.names:
        side = split_name(name)[1]
        if side and name[0] in "lr":
            names.append(swap[name[0]] + name[1:])
        elif name.startswith(("left", "right")):
            names.append(name.replace("left", "RIGHT").replace("right", "left").lower())
        elif name.endswith(("_r", "_l")):
            names.append(name[:-1] + swap[name[-1]])
        else:
            names.append(name)
    return replace(
        recording,
        skeleton=replace(
            s,
            names=tuple(names),
            positions=s.positions @ M,
            rotations=M @ s.rotations @ M,
            rest_positions=s.rest_positions @ M,
            ends=s.ends @ M,
        ),
    )


def test_a_skeleton_of_no_size_is_refused():
    human = Human.create(1.80, 75)
    recording = exported(human, steps(human))
    s = recording.skeleton
    nothing = replace(s, positions=0.0 * s.positions, rest_positions=0.0 * s.rest_positions)
    with pytest.raises(FitError, match="no length"):
        fit_skeleton(replace(recording, skeleton=nothing))


def test_mirrored_motion_gives_mirrored_angles(data):
    recording = read_amc(data / "cmu_asfamc" / "16_15.amc")
    s = recording.skeleton
    recording = replace(
        recording,
        skeleton=replace(
            s,
            time=s.time[:150],
            positions=s.positions[:150],
            rotations=s.rotations[:150],
            ends=s.ends[:150],
        ),
    )
    a, b = fit_skeleton(recording), fit_skeleton(mirrored(recording))
    human = a.human
    assert abs(b.human.height - human.height) < 1e-9
    error = []
    for i, c in enumerate(human.coordinates):
        twin = {"_r": c[:-2] + "_l", "_l": c[:-2] + "_r"}.get(c[-2:], c)
        sign = -1.0 if c.endswith(("bending", "rotation")) else 1.0
        error.append(a.qpos[:, 7 + i] - sign * b.qpos[:, 7 + human.hinge(twin)])
    assert np.rad2deg(np.abs(error)).mean() < 0.5


def thigh_angle(skeleton: SkeletonMotion, side: str) -> np.ndarray:
    """Return the file's own angle of the thigh in the sagittal plane of its root [deg]."""
    p = dict(zip(skeleton.names, np.swapaxes(skeleton.positions, 0, 1), strict=True))
    thigh = p[f"{side}tibia"] - p[f"{side}femur"]
    own = np.einsum("nji,nj->ni", skeleton.rotations[:, 0], thigh)
    return np.rad2deg(np.arctan2(own[:, 0], -own[:, 2]))


WALKS = ("02_01", "02_02", "07_01", "07_05", "07_12", "16_15", "16_21", "49_01")
QUICK = ("02_01", "07_12", "16_21")  # one of each of three people


@pytest.mark.parametrize(
    "name", [n if n in QUICK else pytest.param(n, marks=pytest.mark.slow) for n in WALKS]
)
def test_cmu_walks_stand_on_the_ground(data, name):
    fit = fit_skeleton(read_amc(data / "cmu_asfamc" / f"{name}.amc"))
    m = fit.metrics
    assert m["penetration_max_mm"] < 5.0
    assert m["foot_drift_mean_mm"] < 4.0
    assert m["foot_drift_mean_mm"] < 0.4 * m["foot_drift_mean_mm_before"]
    assert m["joint_rms_mm"] < 20.0
    low, high = fit.human.limits
    assert (fit.qpos[:, 7:] >= low - 1e-9).all() and (fit.qpos[:, 7:] <= high + 1e-9).all()
    for side in "rl":
        knee = np.rad2deg(fit.qpos[:, 7 + fit.human.hinge(f"knee_angle_{side}")])
        assert 50 < np.ptp(knee) < 85  # a step flexes the knee by about 60 degrees
        hip = np.rad2deg(fit.qpos[:, 7 + fit.human.hinge(f"hip_flexion_{side}")])
        assert np.abs(hip - thigh_angle(fit.recording.skeleton, side)).mean() < 4
    contact = sole_paths(fit.human, fit.qpos)
    rests = find_rests(contact, 120.0)
    assert np.median(drift_of(contact, rests)) < 0.004


def test_bone_lengths_are_those_of_the_file(data):
    recording = read_amc(data / "cmu_asfamc" / "02_01.amc")
    fit = fit_skeleton(recording)
    s = recording.skeleton
    p = {n: s.positions[0, i] for i, n in enumerate(s.names)}
    thigh = np.mean([np.linalg.norm(p[f"{k}femur"] - p[f"{k}tibia"]) for k in "lr"])
    upper = np.mean([np.linalg.norm(p[f"{k}humerus"] - p[f"{k}radius"]) for k in "lr"])
    assert abs(fit.human.dimensions.thigh - thigh) < 1e-6
    assert abs(fit.human.dimensions.upper_arm - upper) < 1e-6
    assert abs(fit.human.dimensions.height - fit.human.height) < 1e-9


@pytest.mark.parametrize("file", ["cmu_bvh/07_01.bvh", "cmu_bvh/13_11.bvh"])
def test_bvh_files(data, file):
    fit = fit_skeleton(read_bvh(data / file))
    assert fit.metrics["penetration_max_mm"] < 5.0
    assert fit.metrics["joint_rms_mm"] < 25.0


@pytest.mark.parametrize("name", ["walk", "run", "jump", "stealthy_walk"])
def test_deepmimic_files(data, name):
    fit = fit_skeleton(read_deepmimic(data / "deepmimic" / f"humanoid3d_{name}.txt"))
    assert fit.metrics["penetration_max_mm"] < 5.0
    assert 1.5 < fit.human.height < 1.8


@pytest.mark.parametrize(
    ("hip", "knee", "ankle", "elbow"),
    [
        ("mixamorig:LeftUpLeg", "mixamorig:LeftLeg", "mixamorig:LeftFoot", "mixamorig:LeftForeArm"),
        ("Bip01 L Thigh", "Bip01 L Calf", "Bip01 L Foot", "Bip01 L Forearm"),
        ("thigh_l", "calf_l", "foot_l", "lowerarm_l"),
        ("LeftHip", "LeftKnee", "LeftAnkle", "LeftElbow"),
        ("lThighBend", "lShin", "lFoot", "lForearmBend"),
        ("LeftThigh", "LeftShin", "LeftFoot", "LeftForeArm"),
        ("L_Hip", "L_Knee", "L_Ankle", "L_Elbow"),
        ("upper_leg.L", "lower_leg.L", "foot.L", "forearm.L"),
        ("joint7", "joint8", "joint9", "joint12"),
    ],
)
def test_joints_are_known_under_many_names(hip, knee, ankle, elbow):
    human = Human.create()
    s = exported(human, human.standing()[None]).skeleton
    shoulder = elbow.replace(
        "lowerarm", "upperarm").replace("ForearmBend", "ShldrBend").replace("forearm", "upper_arm"
    ).replace("Elbow", "Shoulder").replace("ForeArm", "Arm").replace(
        "Forearm", "UpperArm").replace("joint12", "joint11")  # fmt: skip
    renamed = {
        "thigh_l": hip, "knee_l": knee, "ankle_l": ankle, "elbow_l": elbow, "shoulder_l": shoulder
    }  # fmt: skip

    def right(name: str) -> str:
        if name.startswith("joint"):
            return f"joint{50 + int(name[5:])}"
        if "Left" in name:
            return name.replace("Left", "Right")
        if name.endswith(("_l", ".L")):
            return name[:-1] + {"l": "r", "L": "R"}[name[-1]]
        for a, b in ((" L ", " R "), ("L_", "R_")):
            if a in name:
                return name.replace(a, b)
        return "r" + name[1:]

    renamed |= {k[:-1] + "r": right(v) for k, v in renamed.items()}
    names = [renamed.get(n, f"joint{100 + i}") for i, n in enumerate(s.names)]
    rest = s.rest_positions.copy()
    if hip.startswith("joint"):  # arms out to the sides, as rest poses have them
        for i, n in enumerate(s.names):
            if n.startswith(("elbow", "wrist")):
                side = 1 if n.endswith("l") else -1
                base = rest[s.names.index("shoulder_" + n[-1])]
                rest[i] = base + [0, side * (0.28 if n.startswith("elbow") else 0.54), 0]
    found = identify(names, s.parents, rest)
    for ours, index in found.joints.items():
        if ours[:-2] in ("hip", "knee", "ankle", "shoulder", "elbow"):
            assert s.names[index] == ours.replace("hip", "thigh")


def test_a_dog_is_refused_with_its_joints_named():
    s = SkeletonMotion(
        ("root", "tail1", "tail2"),
        (-1, 0, 1),
        np.arange(3) / 30,
        np.zeros((3, 3, 3)),
        np.tile(np.eye(3), (3, 3, 1, 1)),
        np.array([[0.0, 0, 0], [-0.1, 0, 0], [-0.3, 0, 0]]),
        np.full((3, 3, 3), np.nan),
    )
    with pytest.raises(FitError, match="tail1.*LeftUpLeg"):
        fit_skeleton(Recording(Path("dog.bvh"), skeleton=s))


def test_no_skeleton_is_refused():
    with pytest.raises(FitError, match="no skeleton"):
        fit_skeleton(Recording(Path("x")))


def test_a_sudden_turn_is_noted(data):
    """The shared walk turns its left shoulder by 29 degrees from one frame to the next."""
    fit = fit_skeleton(read_deepmimic(data / "deepmimic" / "humanoid3d_walk.txt"))
    assert fit.metrics["joint_jumps"] == 1
    assert fit.metrics["joint_jump_max_deg"] == pytest.approx(28.8, abs=0.1)
    assert any("left_shoulder by 29° at 0.63 s" in w for w in fit.warnings)

"""A Human's motion as the arrays of a file of the SMPL family, with offsets of its own.

Rotations are those of our bodies, times a constant for each joint that turns the T-pose of SMPL
into our zero pose: bones along bones, the pelvis tilted as a standing person's. The directions are
those of the mean bodies, read from published MJCF models and rounded to 5 mm; lengths of the legs
are the person's, so a reader with other lengths must find them.
"""

import mujoco
import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.models import Human

NAMES = (
    "pelvis left_hip right_hip spine1 left_knee right_knee spine2 left_ankle right_ankle spine3 "
    "left_foot right_foot neck left_collar right_collar head left_shoulder right_shoulder "
    "left_elbow right_elbow left_wrist right_wrist"
).split()
PARENTS = [-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19]
LEFT = {  # x left, y up, z forward [m]
    "hip": (0.070, -0.090, -0.005), "knee": (0.035, -0.380, -0.005),
    "ankle": (-0.015, -0.400, -0.045), "foot": (0.0, -0.050, 0.120),
    "collar": (0.080, 0.120, -0.035), "shoulder": (0.095, 0.030, -0.010),
    "elbow": (0.255, -0.015, -0.025), "wrist": (0.250, 0.010, -0.005),
}  # fmt: skip
MIDDLE = {
    "pelvis": (0.0, -0.225, 0.030), "spine1": (0.0, 0.110, -0.025), "spine2": (0.0, 0.135, 0.0),
    "spine3": (0.0, 0.055, 0.025), "neck": (0.0, 0.215, -0.045), "head": (0.0, 0.065, 0.050),
}  # fmt: skip
BONES = {"hip": "knee", "knee": "ankle", "shoulder": "elbow", "elbow": "wrist"}
PARTS = {"hip": "femur", "knee": "tibia", "ankle": "foot", "foot": "toes", "shoulder": "humerus",
         "elbow": "ulna", "wrist": "hand"}  # fmt: skip
TO_OURS = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
Z = np.array([0.0, 0, 1])
TILT = np.deg2rad(7.0)  # [rad] of our pelvis in the T-pose of a standing person


def smpl_arrays(human: Human, time: np.ndarray, qpos: np.ndarray, up: str = "z") -> dict:
    """Return the arrays of an AMASS file of a motion (SMPL-H, 52 joints)."""
    model, data = human.model, mujoco.MjData(human.model)
    parts = human.skeleton.parts
    bodies = [human.body(parts[name][0]) for name in map(_part, NAMES)]

    def poses(q):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        R = data.xmat.reshape(-1, 3, 3)
        places = [
            data.xpos[i] + R[i] @ parts[_part(name)][1]
            for name, i in zip(NAMES, bodies, strict=True)
        ]
        return R[bodies].copy(), dict(zip(NAMES, places, strict=True))

    zero, at = poses(model.qpos0)
    constant, offsets = [], {}
    for j, name in enumerate(NAMES):
        side, _, joint = name.partition("_")
        offset = np.array(LEFT[joint] if joint else MIDDLE[name])
        offset = offset * ((-1, 1, 1) if side == "right" else (1, 1, 1))
        offsets[name] = offset
        A = TO_OURS
        if joint in BONES:
            child = np.array(LEFT[BONES[joint]]) * ((-1, 1, 1) if side == "right" else (1, 1, 1))
            ours = zero[j].T @ (at[f"{side}_{BONES[joint]}"] - at[name])
            A = _swing(TO_OURS @ child, ours) @ TO_OURS
        elif joint == "wrist":  # the thumb points forward in the T-pose, outward in ours
            turn = Rotation.from_rotvec([0, 0, np.pi / 2 if side == "left" else -np.pi / 2])
            A = turn.as_matrix() @ _swing(TO_OURS @ offset, -Z) @ TO_OURS
        constant.append(A)
    constant[0] = Rotation.from_rotvec([0, TILT, 0]).as_matrix().T @ TO_OURS
    world, middle = [], 0.5 * (offsets["left_hip"] + offsets["right_hip"])
    trans = np.empty((len(qpos), 3))
    for t, q in enumerate(qpos):
        R, at = poses(q)
        world.append([R[j] @ constant[j] for j in range(len(NAMES))])
        trans[t] = 0.5 * (at["left_hip"] + at["right_hip"]) - world[-1][0] @ middle
    turn = np.eye(3) if up == "z" else TO_OURS.T
    G = turn @ np.array(world)
    local = G.copy()
    for j, parent in enumerate(PARENTS[1:], start=1):
        local[:, j] = np.swapaxes(G[:, parent], 1, 2) @ G[:, j]
    vectors = Rotation.from_matrix(local.reshape(-1, 3, 3)).as_rotvec().reshape(len(qpos), -1)
    return {
        "poses": np.concatenate([vectors, np.zeros((len(qpos), 90))], axis=1),
        "trans": trans @ turn.T - MIDDLE["pelvis"],
        "betas": np.zeros(16),
        "gender": np.array("male"),
        "mocap_framerate": np.array((len(time) - 1) / (time[-1] - time[0])),
        "dmpls": np.zeros((len(qpos), 8)),
    }


def _part(name: str) -> str:
    side, _, joint = name.partition("_")
    if joint in PARTS:
        return f"{PARTS[joint]}_{side[0]}"
    return "pelvis" if name == "pelvis" else "abdomen"


def _swing(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the smallest rotation of direction ``a`` to ``b``."""
    axis = np.cross(a, b)
    angle = np.arctan2(np.linalg.norm(axis), a @ b)
    return Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle).as_matrix()

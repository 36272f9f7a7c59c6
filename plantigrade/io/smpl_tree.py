r"""The tree of joints that SMPL, SMPL-H and SMPL-X share, with the lengths of a mean body.

The body models themselves [SMPL]_, their surface and shape space, may not be redistributed and are
not needed: a pose is a rotation of each joint, and positions follow from any set of offsets,

.. math:: R_j = R_{parent} R^{local}_j, \quad p_j = p_{parent} + R_{parent}\, o_j.

The directions of the offsets in the neutral pose (all rotations zero: a T-pose, the palms down) are
those of the mean bodies to about a degree; lengths are those of our own anthropometry for a
stature (:mod:`plantigrade.models.anthropometry`). Model axes are x left, y up, z forward; this
module has ours, x forward, y left, z up.
"""

from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError
from plantigrade.io.npz import Arrays
from plantigrade.io.skeletons import FORWARD_LEFT_UP_OF_Y_UP
from plantigrade.models.anatomy import hip, lumbar, shoulder
from plantigrade.models.anthropometry import dimensions

NAMES = tuple(
    "pelvis left_hip right_hip spine1 left_knee right_knee spine2 left_ankle right_ankle spine3 "
    "left_foot right_foot neck left_collar right_collar head left_shoulder right_shoulder "
    "left_elbow right_elbow left_wrist right_wrist".split()
)
"""The 22 joints of the body, the same in all three models; ``foot`` is the base of the toes."""
PARENTS = (-1, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 9, 9, 12, 13, 14, 16, 17, 18, 19)
"""Index of each joint's parent."""
ROOT = {"smpl": (0.03, 0.0, -0.22), "smplx": (0.01, 0.0, -0.35)}
"""Pelvis joint of the mean body without translation, model axes turned to ours [m]: a pelvis is at
the translation plus this, which the rotation of the root does not turn."""
MEAN_STATURE = {"male": 1.756, "female": 1.629, None: 1.70}  # [m] of adults, ANSUR II [Gordon2014]_

# Offset from the parent in the neutral pose, in units of a length of the body: forward, left
# (outward for joints of a side), up. "trunk" is the height of the shoulders above the hips, half
# "hips" and "shoulders" the distance of a joint from the midline.
_OFFSETS = {
    "spine1": ("trunk", (-0.05, 0.0, 0.20)),
    "spine2": ("trunk", (0.00, 0.0, 0.25)),
    "spine3": ("trunk", (0.05, 0.0, 0.10)),
    "neck": ("trunk", (-0.08, 0.0, 0.39)),
    "head": ("trunk", (0.09, 0.0, 0.12)),
    "hip": ("trunk", (-0.01, 0.0, -0.17)),
    "knee": ("thigh", (-0.02, 0.09, -1.0)),
    "ankle": ("shank", (-0.11, -0.04, -1.0)),
    "collar": ("trunk", (-0.06, 0.0, 0.22)),
    "shoulder": ("trunk", (-0.02, 0.0, 0.06)),
    "elbow": ("upper_arm", (-0.09, 1.0, -0.05)),
    "wrist": ("forearm", (-0.01, 1.0, 0.03)),
}
_COLLAR = 0.46  # [1] distance of the collar joint from the midline, over that of the shoulder
# [1] The joint "foot" from the ankle over the length of the foot, forward and up: where
# plantigrade.kinematics.skeleton_source expects a toe base. Its side is dropped: in the mean bodies
# it lies 12 to 20 degrees outward of the long axis of the foot.
_TOE_BASE = np.array([0.130 / 0.240, 0.0, -0.154])
_KEYS = {"J_regressor", "v_template", "shapedirs"}
_REMEDY = "name the model as an .npz file, such as SMPLH_MALE.npz or SMPLX_NEUTRAL.npz"


def mean_offsets(height: float, sex: str | None) -> Float[Array, "22 3"]:
    """Return the offset of each joint from its parent in the neutral pose, our axes [m].

    Args:
        height: Stature [m].
        sex: ``"male"``, ``"female"`` or None.
    """
    d = dimensions(height, sex or "male")
    trunk = float((lumbar(d) + shoulder(d) - hip(d))[2])
    lengths = {name: getattr(d, name) for name in ("thigh", "shank", "upper_arm", "forearm")}
    beside = {
        "hip": abs(hip(d)[1]),
        "collar": 0.5 * _COLLAR * d.shoulder_width,
        "shoulder": 0.5 * (1 - _COLLAR) * d.shoulder_width,
    }
    offsets = np.zeros((len(NAMES), 3))
    for i, name in enumerate(NAMES[1:], start=1):
        side, _, joint = name.partition("_")
        joint = joint or side
        if joint == "foot":
            offsets[i] = d.foot_length * _TOE_BASE
            continue
        unit, direction = _OFFSETS[joint]
        row = np.array(direction)
        if unit in lengths:  # a bone of exactly this length
            row *= lengths[unit] / np.linalg.norm(row)
        else:
            row = trunk * row + [0.0, beside.get(joint, 0.0), 0.0]
        offsets[i] = row * (1, -1, 1) if side == "right" else row
    return offsets


def model_offsets(
    path: str | Path, betas: Float[Array, "..."]
) -> tuple[Float[Array, "22 3"], Float[Array, "3"]]:
    r"""Return the offset of each joint from its parent, and the pelvis joint, our axes [m].

    Joints are a linear function of the surface in the neutral pose, and it of the shape numbers:
    :math:`J = W (v + S \beta)`.

    Args:
        path: Body model, ``.npz``.
        betas: Shape numbers; those that the model lacks are ignored, and of several rows the mean
            is taken.
    """
    arrays = Arrays(path, _REMEDY, only=_KEYS)
    v, W = arrays.finite("v_template", None, 3), arrays.finite("J_regressor", None, None)
    S = arrays.finite("shapedirs", None, 3, None)
    if v is None or W is None or S is None or S.shape[0] != len(v) or W.shape[1] != len(v):
        problem = "is no body model with J_regressor, v_template and shapedirs of one surface"
        raise FileError(path, problem, remedy=_REMEDY)
    if len(W) < len(NAMES):
        raise FileError(path, f"has {len(W)} joints", where="J_regressor", remedy=_REMEDY)
    beta = np.asarray(betas, float)
    beta = beta.reshape(-1, beta.shape[-1] if beta.ndim else 1).mean(axis=0)
    n = min(len(beta), S.shape[2])
    J = W[: len(NAMES)] @ (v + S[:, :, :n] @ beta[:n]) @ FORWARD_LEFT_UP_OF_Y_UP.T
    offsets = J - J[np.maximum(PARENTS, 0)]
    return offsets, J[0]

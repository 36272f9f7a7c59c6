"""Bone lengths of a body model file of the SMPL family that the user has."""

from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError
from plantigrade.io.npz import Arrays
from plantigrade.io.skeletons import FORWARD_LEFT_UP_OF_Y_UP
from plantigrade.io.smpl_tree import NAMES, PARENTS

_KEYS = {"J_regressor", "v_template", "shapedirs"}
_REMEDY = "name the model as an .npz file, such as SMPLH_MALE.npz or SMPLX_NEUTRAL.npz"


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

"""Generalised forces as OpenSim's inverse dynamics has them: the oracle of two tests."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.dynamics.inverse import Moments
from plantigrade.spatial.conventions import (
    OPENSIM_TO_WORLD,
    PELVIS,
    quaternion_to_pelvis_angles,
    rotation_matrix,
)


def opensim_moments(
    qpos: Float[Array, "n_frames nq"], moments: Moments
) -> tuple[tuple[str, ...], Float[Array, "n_frames nv"]]:
    r"""Return the generalised forces with OpenSim's names and pelvis coordinates.

    Joint moments are identical. The force of a pelvis translation is the world force in OpenSim's
    axes; the moment of a pelvis angle is the moment about the pelvis' origin projected on the axis
    of that angle, so that power is preserved, :math:`\tau^T v = Q^T \dot q`.

    Args:
        qpos: Configurations.
        moments: From :func:`inverse_dynamics`.

    Returns:
        Names as in OpenSim's inverse dynamics (``pelvis_tilt_moment``, ``pelvis_tx_force``, …,
        ``hip_flexion_r_moment``, …) and values [N m, N].
    """
    rotation = rotation_matrix(qpos[:, 3:7])
    moment = np.einsum("nij,nj->ni", rotation, moments.tau[:, 3:6])
    tilt = quaternion_to_pelvis_angles(qpos[:, 3:7])[:, 0]
    zero = np.zeros_like(tilt)
    tilt_axis = np.stack([zero, zero - 1.0, zero], axis=1)
    list_axis = np.stack([np.cos(tilt), zero, np.sin(tilt)], axis=1)
    turn_axis = rotation[:, :, 2]
    angles = [np.einsum("ni,ni->n", moment, a) for a in (tilt_axis, list_axis, turn_axis)]
    force = moments.tau[:, :3] @ OPENSIM_TO_WORLD
    values = np.hstack([np.stack(angles, axis=1), force, moments.tau[:, 6:]])
    pelvis = tuple(
        f"{n}_force" if n[-2] == "t" and n[-1] in "xyz" else f"{n}_moment" for n in PELVIS
    )
    return pelvis + tuple(f"{n}_moment" for n in moments.names[6:]), values

"""States of MuJoCo as Pinocchio takes them: quaternions ``xyzw``, root velocity in body axes."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.spatial.conventions import rotation_matrix, wxyz_to_xyzw


def free_joint_velocity_to_pinocchio(
    qpos: Float[Array, " nq"], qvel: Float[Array, " nv"]
) -> Float[Array, " nv"]:
    """Return a MuJoCo velocity with the linear velocity of the root in body axes."""
    rotation = rotation_matrix(qpos[3:7])
    return np.concatenate([rotation.T @ qvel[:3], qvel[3:]])


def configuration_to_pinocchio(qpos: Float[Array, " nq"]) -> Float[Array, " nq"]:
    """Return a MuJoCo configuration with the root quaternion as ``xyzw``."""
    return np.concatenate([qpos[:3], wxyz_to_xyzw(qpos[3:7]), qpos[7:]])

r"""Centre of mass, momentum, zero-moment point and centre of pressure over a motion.

The ground must supply the force :math:`F = m(\ddot c - g)` and the moment :math:`\dot L` about the
centre of mass :math:`c`. Both follow exactly from the motion, as the root wrench of inverse
dynamics without contacts. The zero-moment point is the point of a level plane at height :math:`z`
about which this wrench has no horizontal moment,

.. math:: p_x = c_x - \frac{(c_z - z) F_x + \dot L_y}{F_z}, \qquad
    p_y = c_y - \frac{(c_z - z) F_y - \dot L_x}{F_z}.
"""

import copy
from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import sweep
from plantigrade.models import Human
from plantigrade.spatial.conventions import rotation_matrix


@dataclass(frozen=True)
class Centroid:
    r"""Whole-body quantities over time, world axes."""

    com: Float[Array, "n_frames 3"]  #: Centre of mass [m]
    com_vel: Float[Array, "n_frames 3"]  #: Velocity of the centre of mass [m/s]
    angular_momentum: Float[Array, "n_frames 3"]  #: About the centre of mass [kg m²/s]
    #: Required ground force, :math:`m(\ddot c - g)` [N]; None without accelerations, like the next
    #: two
    force: Float[Array, "n_frames 3"] | None = None
    #: Required moment about the centre of mass, :math:`\dot L` [N m]
    moment: Float[Array, "n_frames 3"] | None = None
    #: Zero-moment point on the ground plane [m]; NaN for a vertical force below 1 % of body weight
    zmp: Float[Array, "n_frames 3"] | None = None


def centroid(
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    qvel: Float[Array, "n_frames nv"],
    qacc: Float[Array, "n_frames nv"] | None = None,
    *,
    ground: float = 0.0,
) -> Centroid:
    """Return centre of mass, momentum and, with accelerations, the zero-moment point.

    Args:
        ground: Height of the ground plane [m].

    Raises:
        ParameterError: If the arrays are inconsistent.
    """
    check_motion(human, qpos, qvel, qacc)
    n = len(qpos)
    com, com_vel, momentum = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 3))
    root = np.empty((n, 6)) if qacc is not None else None
    for f, state in enumerate(sweep(human, qpos, qvel)):
        com[f], com_vel[f], momentum[f] = state.com, state.com_velocity, state.angular_momentum
        if root is not None and qacc is not None:
            root[f] = state.inverse_dynamics(qacc[f])[:6]
    if root is None:
        return Centroid(com, com_vel, momentum)
    force, moment = root_wrench_at(root, qpos, com)
    min_force = 0.01 * human.mass * human.gravity
    points = zero_moment_point(force, moment, com, ground, min_force=min_force)
    return Centroid(com, com_vel, momentum, force, moment, points)


def zero_moment_point(
    force: Float[Array, "n_frames 3"],
    moment: Float[Array, "n_frames 3"],
    about: Float[Array, "n_frames 3"],
    ground: float,
    *,
    min_force: float,
) -> Float[Array, "n_frames 3"]:
    """Return the point of a level plane at which a wrench has no horizontal moment [m].

    Args:
        force: Force [N], world axes.
        moment: Moment [N m] about the points ``about``.
        about: Reference points of the moment [m].
        ground: Height of the plane [m].
        min_force: Vertical force below which the point is undefined (NaN) [N].
    """
    up = np.where(force[:, 2] > min_force, force[:, 2], np.nan)
    drop = about[:, 2] - ground
    x = about[:, 0] - (drop * force[:, 0] + moment[:, 1]) / up
    y = about[:, 1] - (drop * force[:, 1] - moment[:, 0]) / up
    return np.stack([x, y, np.where(np.isfinite(x), ground, np.nan)], axis=1)


def root_wrench_at(
    root: Float[Array, "n_frames 6"],
    qpos: Float[Array, "n_frames nq"],
    points: Float[Array, "n_frames 3"],
) -> tuple[Float[Array, "n_frames 3"], Float[Array, "n_frames 3"]]:
    """Return the generalised force of the free joint as force and moment about points, world.

    ``root`` is the world force [N] at the pelvis' origin, and the moment about it [N m], body axes.
    """
    force = root[:, :3]
    moment = np.einsum("nij,nj->ni", rotation_matrix(qpos[:, 3:7]), root[:, 3:])
    return force.copy(), moment + np.cross(qpos[:, :3] - points, force)


def without_constraints(human: Human):
    """Return the person's model with contacts and joint limits switched off."""
    model = copy.deepcopy(human.model)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    return model


def check_motion(human: Human, qpos, qvel, qacc=None) -> None:
    """Raise a ParameterError unless the arrays are a finite motion of this person."""
    n, model = len(qpos), human.model
    for name, values, width in (
        ("qpos", qpos, model.nq),
        ("qvel", qvel, model.nv),
        ("qacc", qacc, model.nv),
    ):
        if values is None:
            continue
        if values.shape != (n, width):
            raise ParameterError(
                f"{name} has shape {values.shape}; {n} frames of this person need ({n}, {width})"
            )
        if not np.isfinite(values).all():
            frame = int(np.flatnonzero(~np.isfinite(values).all(axis=1))[0])
            raise ParameterError(f"{name} has missing values (first in frame {frame})")

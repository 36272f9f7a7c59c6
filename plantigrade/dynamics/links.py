"""The moving bodies of a MuJoCo model as constants, for recursions over them."""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array
from plantigrade.errors import ParameterError
from plantigrade.spatial.conventions import rotation_matrix

_ROUNDING = 1e-13  # [1] relative size below which constants are rounded to zero


@dataclass(frozen=True)
class Link:
    """A moving body as constants, in its own axes."""

    parent: int  #: Index of the parent link; -1 is the world
    offset: Array  #: Origin in the parent's frame (3, 1) [m]
    turn: Array | None  #: Fixed rotation to the parent's axes (3, 3); None if they are the same
    hinges: tuple[tuple[int, Array], ...]  #: (index in q, axis) of every hinge, in order
    mass: float  #: Mass [kg]
    first: Array  #: First moment of mass about the origin (3, 1) [kg m]
    second: Array  #: Second moment of mass about the origin (3, 3) [kg m²]


def inertia(link: Link) -> Array:
    """Return the rotational inertia about a link's origin (3, 3) [kg m²]."""
    return np.trace(link.second) * np.eye(3) - link.second


def links_of(model: mujoco.MjModel) -> tuple[Link, ...]:
    """Return the bodies of a model, with the pelvis angles as hinges of the first body."""
    hinge = int(mujoco.mjtJoint.mjJNT_HINGE)
    passive = (model.dof_damping, model.dof_armature, model.dof_frictionloss, model.jnt_stiffness)
    fine = (
        np.count_nonzero(model.body_parentid[1:] == 0) == 1
        and int(model.jnt_bodyid[0]) == 1
        and model.nq == model.nv + 1 == model.njnt + 6  # one free joint
        and np.all(model.jnt_type[1:] == hinge)
        and not np.any(model.jnt_pos)
        and not any(np.any(each) for each in passive)
    )
    if not fine:
        raise ParameterError(
            "a symbolic model is one free pelvis with hinges at the origins of their bodies and no "
            "springs, dampers or armature; this MuJoCo model has something else"
        )
    links = []
    for b in range(1, model.nbody):
        if b == 1:
            axes = -np.eye(3)[1], np.eye(3)[0], np.eye(3)[2]  # tilt, list, rotation
            hinges = tuple(enumerate(axes))
        else:
            first, count = int(model.body_jntadr[b]), int(model.body_jntnum[b])
            joints = range(first, first + count)
            hinges = tuple(
                (int(model.jnt_dofadr[j]), _clean(model.jnt_axis[j], 1.0)) for j in joints
            )
        quat = model.body_quat[b]
        aligned = b == 1 or bool(np.all(quat[1:] == 0.0))
        mass, com = float(model.body_mass[b]), np.array(model.body_ipos[b])
        axes_of_inertia = rotation_matrix(np.array(model.body_iquat[b]))
        central = axes_of_inertia @ np.diag(model.body_inertia[b]) @ axes_of_inertia.T
        second = 0.5 * np.trace(central) * np.eye(3) - central + mass * np.outer(com, com)
        links.append(
            Link(
                int(model.body_parentid[b]) - 1,
                _clean(model.body_pos[b], 1.0),
                None if aligned else rotation_matrix(np.array(quat)),
                hinges,
                mass,
                _clean(mass * com, mass),
                _clean(second, float(np.trace(second))),
            )
        )
    return tuple(links)


def _clean(values: Array, scale: float) -> Array:
    """Return values with rounding errors relative to ``scale`` set to zero."""
    values = np.array(values, float)
    return np.where(np.abs(values) < _ROUNDING * scale, 0.0, values)

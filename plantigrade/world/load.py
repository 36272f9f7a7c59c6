"""A load on the back, unknown to the controller."""

from weakref import WeakKeyDictionary

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.constants import MAX_LOAD
from plantigrade.contact.scene import SceneObject
from plantigrade.world.disturbance import Disturbance, body_index
from plantigrade.world.world import World

PACK_OFFSET = np.array([-0.2, 0.0, 0.05])  # [m] of the pack's centre from that of the trunk
PACK_DENSITY = 350.0  # [kg/m³] of a full pack, about 20 kg in 60 l
PACK_PROPORTIONS = np.array([0.6, 0.9, 1.85])
"""Depth, width and height of the pack, relative to the edge of a cube of its volume."""


class Load(Disturbance):
    """A pack on the back, fixed to the upper trunk.

    Args:
        mass: Mass of the pack [kg].

    Raises:
        ParameterError: If that is out of range.
    """

    def __init__(self, mass: float):
        number("load", mass, 0, MAX_LOAD, "kg", "a load")
        self.mass = float(mass)
        self._trunk_inertia: WeakKeyDictionary[World, tuple[float, Array, Array, Array]] = (
            WeakKeyDictionary()
        )

    def reset(self, world: World) -> None:
        """Attach the pack."""
        self.set_mass(world, self.mass)

    def set_mass(self, world: World, mass: float) -> None:
        """Change the mass of the pack [kg].

        Raises:
            ParameterError: If that is out of range.
        """
        number("load", mass, 0, MAX_LOAD, "kg", "a load")
        model, body = world.model, body_index(world.human)
        if world not in self._trunk_inertia:
            if mass == 0.0:
                return
            self._trunk_inertia[world] = (
                float(model.body_mass[body]),
                model.body_ipos[body].copy(),
                model.body_iquat[body].copy(),
                model.body_inertia[body].copy(),
            )
        own, com, rotation, inertia = self._trunk_inertia[world]
        axes = np.zeros(9)
        mujoco.mju_quat2Mat(axes, rotation)
        tensor = axes.reshape(3, 3) * inertia @ axes.reshape(3, 3).T
        # Two bodies about their common centre of mass: the reduced mass at their distance.
        reduced = own * mass / (own + mass)
        tensor += reduced * (
            PACK_OFFSET @ PACK_OFFSET * np.eye(3) - np.outer(PACK_OFFSET, PACK_OFFSET)
        )
        sizes, principal = np.linalg.eigh(tensor)
        principal[:, 2] *= np.linalg.det(principal)
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, principal.ravel())
        model.body_mass[body] = own + mass
        model.body_ipos[body] = com + mass / (own + mass) * PACK_OFFSET
        model.body_iquat[body], model.body_inertia[body] = quat, sizes
        mujoco.mj_setConst(model, mujoco.MjData(model))

    @property
    def scene_object(self) -> SceneObject | None:
        """The pack at the start."""
        return pack_of(self.mass)

    def pose(self, world: World) -> Float[Array, " 7"]:
        """Return the pose of the pack, in the axes of the trunk."""
        body, data = body_index(world.human), world.data
        own = (
            self._trunk_inertia[world][1]
            if world in self._trunk_inertia
            else world.model.body_ipos[body]
        )
        middle = data.xpos[body] + data.xmat[body].reshape(3, 3) @ (own + PACK_OFFSET)
        return np.concatenate([middle, data.xquat[body]])


def pack_of(mass: float) -> SceneObject | None:
    """Return the pack of a load [kg]; None for no load."""
    if mass == 0.0:
        return None
    x, y, z = 0.5 * PACK_PROPORTIONS * np.cbrt(mass / PACK_DENSITY)
    return SceneObject("pack", "box", (float(x), float(y), float(z)))

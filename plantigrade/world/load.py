"""A load on the back: weight that a controller does not know of."""

from weakref import WeakKeyDictionary

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import number
from plantigrade.contact.thing import Thing
from plantigrade.world.disturbance import Disturbance, trunk
from plantigrade.world.world import World

BACK = np.array([-0.2, 0.0, 0.05])
"""Where it is, from the centre of mass of the trunk: a pack, its middle 20 cm behind [m]."""
MOST = 60.0
"""Greatest load [kg]."""
PACKED = 350.0
"""Density of a full pack, 20 kg in 60 l or so [kg/m³]."""
SLIM = np.array([0.6, 0.9, 1.85])
"""Depth, width and height of the pack, as parts of the edge of a cube of its volume."""


class Load(Disturbance):
    """A pack on the back, fixed to the upper trunk.

    Args:
        mass: Its mass [kg].

    Raises:
        ParameterError: If that is out of range.
    """

    def __init__(self, mass: float):
        number("load", mass, 0, MOST, "kg", "a load")
        self.mass = float(mass)
        self._own: WeakKeyDictionary[World, tuple[float, Array, Array, Array]] = WeakKeyDictionary()

    def reset(self, world: World) -> None:
        """Put it on."""
        self.carry(world, self.mass)

    def carry(self, world: World, mass: float) -> None:
        """Change it to another mass [kg].

        Raises:
            ParameterError: If that is out of range.
        """
        number("load", mass, 0, MOST, "kg", "a load")
        model, body = world.model, trunk(world.human)
        if world not in self._own:
            if mass == 0.0:
                return
            self._own[world] = (
                float(model.body_mass[body]),
                model.body_ipos[body].copy(),
                model.body_iquat[body].copy(),
                model.body_inertia[body].copy(),
            )
        own, place, turn, inertia = self._own[world]
        axes = np.zeros(9)
        mujoco.mju_quat2Mat(axes, turn)
        tensor = axes.reshape(3, 3) * inertia @ axes.reshape(3, 3).T
        # Two masses about their common centre: the reduced mass, at their distance.
        reduced = own * mass / (own + mass)
        tensor += reduced * (BACK @ BACK * np.eye(3) - np.outer(BACK, BACK))
        sizes, principal = np.linalg.eigh(tensor)
        principal[:, 2] *= np.linalg.det(principal)
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, principal.ravel())
        model.body_mass[body] = own + mass
        model.body_ipos[body] = place + mass / (own + mass) * BACK
        model.body_iquat[body], model.body_inertia[body] = quat, sizes
        mujoco.mj_setConst(model, mujoco.MjData(model))

    @property
    def thing(self) -> Thing | None:
        """The pack it starts with."""
        return pack_of(self.mass)

    def place(self, world: World) -> Float[Array, " 7"]:
        """Return where it is, in the axes of the trunk."""
        body, data = trunk(world.human), world.data
        own = self._own[world][1] if world in self._own else world.model.body_ipos[body]
        middle = data.xpos[body] + data.xmat[body].reshape(3, 3) @ (own + BACK)
        return np.concatenate([middle, data.xquat[body]])


def pack_of(mass: float) -> Thing | None:
    """Return the pack of a load [kg]; None where there is none."""
    if mass == 0.0:
        return None
    x, y, z = 0.5 * SLIM * np.cbrt(mass / PACKED)
    return Thing("pack", "box", (float(x), float(y), float(z)))

r"""Commands of a controller to the joints, and their implementation.

A :class:`StablePD` law with stiffness :math:`k_p` and damping :math:`k_d` is meant at the end of a
step of length :math:`h` [Tan2011]_,

.. math:: \tau = k_p (\bar q - q - h \dot q) + k_d (\bar v - \dot q) - h (k_d + h k_p) \ddot q .

Its last term is an armature of :math:`h (k_d + h k_p)`. Put into the mass matrix that MuJoCo also
solves contacts with, the law is exact for diagonal gains and stable at any step; computed outside,
with the contact forces of the last step, it is neither.

An :class:`Acceleration` is prescribed in the same way: with an armature :math:`K` far above any
inertia of a limb and :math:`\tau = K \bar a + h(q, v)`, contacts meet a body whose joints move as
told. What a joint then needed is :math:`K (\bar a - \ddot q) + h`. It is an ideal motor, whose
torque is reported and not limited.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Float

Hinges = Float[Array, " n_hinges"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Command:
    """No command: the joints are left to their passive moments.

    Attributes:
        signals: What the controller wants to be kept with this command, by name: one number or
            one array of the same shape in every command.
    """

    signals: Mapping[str, float | Array] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Torque(Command):
    """Torques of the hinges.

    Attributes:
        torque: Torques, in the order of :attr:`Human.coordinates`, within its limits [N m].
    """

    torque: Hinges


@dataclass(frozen=True, eq=False)
class StablePD(Command):
    """Springs and dampers to a target, which hold at any step.

    Attributes:
        target: Angles to be reached [rad].
        velocity: Their rates; zero if absent [rad/s].
        torque: Torque in addition; none if absent [N m].
        stiffness: Stiffness; :attr:`World.stiffness` if absent [N m/rad].
        damping: Damping; :attr:`World.damping` if absent [N m s/rad].
    """

    target: Hinges
    velocity: Hinges | None = None
    torque: Hinges | None = None
    stiffness: Hinges | float | None = None
    damping: Hinges | float | None = None


@dataclass(frozen=True, eq=False)
class PD(StablePD):
    """The same as plain torques of the present state, as a motor's own loop gives them.

    Light segments on strong springs need small steps: it is stable where
    :math:`h k_d` stays below the inertia that the joint moves.
    """


@dataclass(frozen=True, eq=False)
class Acceleration(Command):
    """Prescribed accelerations of the hinges; see the module.

    Attributes:
        acceleration: Accelerations [rad/s²].
    """

    acceleration: Hinges


Commanded = Command | Float[np.ndarray, " n_hinges"] | None
"""What a controller may return: a command, plain torques, or nothing."""

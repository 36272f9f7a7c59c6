r"""Commands of a controller to the joints.

A :class:`StablePD` law with stiffness :math:`k_p` and damping :math:`k_d` refers to the state at
the end of a step of length :math:`h` [Tan2011]_,

.. math:: \tau = k_p (\bar q - q - h \dot q) + k_d (\bar v - \dot q) - h (k_d + h k_p) \ddot q .

Its last term is an armature of :math:`h (k_d + h k_p)`. In the mass matrix with which MuJoCo solves
contacts, it makes the law exact for diagonal gains and stable at any step; an explicit torque with
the contact forces of the last step is neither.

An :class:`Acceleration` is prescribed in the same way, by an armature :math:`K` far above the
inertia of any limb and :math:`\tau = K \bar a + h(q, v)`. The torque of this ideal motor is
:math:`K (\bar a - \ddot q) + h`; it is reported and not limited.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Float

Hinges = Float[Array, " n_hinges"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Command:
    """No command: only passive moments act at the joints.

    Attributes:
        signals: Signals of the controller to be recorded, by name: a number, or an array of the
            same shape in every command.
    """

    signals: Mapping[str, float | Array] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Torque(Command):
    """Joint torques.

    Attributes:
        torque: Torques in the order of :attr:`Human.coordinates`, limited by the strength of the
            joints [N m].
    """

    torque: Hinges


@dataclass(frozen=True, eq=False)
class StablePD(Command):
    """Springs and dampers towards a target, stable at any time step.

    Attributes:
        target: Target angles [rad].
        velocity: Target rates; zero if absent [rad/s].
        torque: Additional torque; zero if absent [N m].
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
    """Explicit PD, computed from the state before each step, as in the control loop of a motor.

    It is stable if :math:`h k_d` is below the inertia that the joint moves, so light segments with
    strong springs need small steps.
    """


@dataclass(frozen=True, eq=False)
class Acceleration(Command):
    """Prescribed joint accelerations, as described at the top of the module.

    Attributes:
        acceleration: Accelerations [rad/s²].
    """

    acceleration: Hinges


AnyCommand = Command | Float[np.ndarray, " n_hinges"] | None
"""Return value of a controller: a command, torques, or None."""

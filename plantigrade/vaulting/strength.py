r"""Torque of a joint: strength times velocity factor times activation ([Cheng2009]_, Eqs. 1 and 2).

.. math:: T = T_{max}(\theta)\, h(\omega)\, A(t), \qquad
    h(\omega) = \frac{\omega_0 - \omega}{\omega_0 + \Gamma\omega}
    \;\text{ for } \omega/\omega_0 \le 1, \quad 0 \text{ beyond},

with :math:`\omega_0 = \pm 20` rad/s, whose sign is that of the effort, and :math:`\Gamma = 2.5`.
Positive is extension; the shoulder extends as the angle between arm and trunk opens, which
anatomy calls flexion.

**Where the report is wrong.** Its second line, :math:`h = 0` for :math:`\omega/\omega_0 \ge 1`, is
the same bound as the first line's: they agree there. But a muscle that is lengthened has
:math:`\omega/\omega_0 < 0`, and the formula grows without bound towards a pole at
:math:`-1/\Gamma`: at 8 rad/s, which joints reach in a vault. Lengthening muscles follow
instead a hyperbola with the same slope at rest and the limit
:math:`e = 1.4` [Yeadon2006]_:

.. math:: h = e - \frac{e - 1}{1 - s\,\omega/\omega_0}, \qquad s = \frac{1 + \Gamma}{e - 1}.

**What it leaves open** is the strength. :math:`T_{max}` is that of the Human (both limbs together)
times a bell curve of the joint's angle, whose centre and width are those measured on a vaulting
gymnast, for the elbow on a tennis player ([Jackson2010]_, [Kentel2011]_, as tabled in
[Felis2017]_).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.models import Human
from plantigrade.vaulting.segments import JOINTS

OMEGA_0 = 20.0
"""Angular velocity at which a joint has no torque left [rad/s]."""
GAMMA = 2.5
"""Shape of the velocity factor."""
LENGTHENING = 1.4
"""Greatest torque of lengthening muscle, in isometric strengths."""

OPENS = np.array([1.0, -1.0, -1.0, -1.0, -1.0])
"""Sign of each coordinate in which the joint extends; the ankle extends as the toes point."""

# Angle of greatest strength and width of the bell, of extension and of flexion [rad].
BELLS = (
    ((0.890118, 1.28980), (2.14675, 1.83085)),  # shoulder: what opens it is called flexion there
    ((1.64319, 1.30795), (0.33, 3.62155)),
    ((1.06465, 1.05941), (0.733038, 1.21999)),
    ((0.942478, 0.509636), (1.02974, 1.11003)),
    ((0.408, 0.660752), (-0.187, 0.60868)),
)


@dataclass(frozen=True)
class Stop:
    """Where a joint ends: range of its coordinate [rad]."""

    low: float
    high: float


STOPS = (
    Stop(-1.0, np.deg2rad(180.0)),
    Stop(0.0, np.deg2rad(145.0)),
    Stop(np.deg2rad(-25.0), np.deg2rad(125.0)),
    Stop(0.0, np.deg2rad(145.0)),
    Stop(np.deg2rad(-55.0), np.deg2rad(35.0)),
)
"""Ends of the joints, which the report does not have: bone and ligament, of no strength's doing."""
STOP_STIFFNESS, STOP_DAMPING = 300.0, 3.0
"""Of a stop, in the form of the report's Eq. 3, in strengths of the joint: 3.3° hold its whole
strength (estimates) [1/rad², s/rad²]."""


def velocity_factor(ratio: Any, ca: Any = np) -> Any:
    r"""Return :math:`h` of :math:`\omega/\omega_0`, an array or a CasADi expression.

    Example:
        >>> velocity_factor(np.array([-0.5, 0.0, 0.5, 1.0, 2.0])).round(3).tolist()
        [1.326, 1.0, 0.222, 0.0, 0.0]
    """
    up, down = ca.fmax(ratio, 0.0), ca.fmin(ratio, 0.0)
    slope = (1.0 + GAMMA) / (LENGTHENING - 1.0)
    shortening = ca.fmax((1.0 - up) / (1.0 + GAMMA * up), 0.0)
    return shortening + (LENGTHENING - 1.0) * (1.0 - 1.0 / (1.0 - slope * down))


def strengths(human: Human) -> Float[Array, "5 2"]:
    """Return the isometric strength of both limbs in extension and flexion, both positive [N m]."""
    hinges = [1 + human.hinge(f"{name}_r") for name in JOINTS]
    ranges = human.model.jnt_actfrcrange[hinges]
    both = 2.0 * np.abs(ranges)
    return np.where(OPENS[:, None] > 0, both[:, ::-1], both)


def torques(
    strength: Float[Array, "5 2"], angle: Any, rate: Any, activation: Any,
    ca: Any = np,
) -> list[Any]:  # fmt: skip
    """Return the muscles' torque of each joint, both limbs, positive as its coordinate [N m].

    Args:
        strength: From :func:`strengths`.
        angle: Coordinates in the order of :data:`~plantigrade.vaulting.segments.JOINTS` [rad].
        rate: Their rates [rad/s].
        activation: -1 (flexion) to 1 (extension) each.
        ca: ``numpy`` or ``casadi``.
    """
    found = []
    for i, bells in enumerate(BELLS):
        ratio = OPENS[i] * rate[i] / OMEGA_0
        extend, flex = (
            strength[i, k] * ca.exp(-0.5 * ((angle[i] - at) / width) ** 2)
            for k, (at, width) in enumerate(bells)
        )
        up, down = ca.fmax(activation[i], 0.0), ca.fmin(activation[i], 0.0)
        total = up * extend * velocity_factor(ratio, ca) + down * flex * velocity_factor(-ratio, ca)
        found.append(OPENS[i] * total)
    return found


def stops(strength: Float[Array, "5 2"], angle: Any, rate: Any, ca: Any = np) -> list[Any]:
    """Return the torque of each joint's ends, both limbs, positive as its coordinate [N m]."""
    found = []
    for i, stop in enumerate(STOPS):
        size = float(strength[i].mean())
        over, under = ca.fmax(angle[i] - stop.high, 0.0), ca.fmax(stop.low - angle[i], 0.0)
        push = ca.fmax(over * (STOP_STIFFNESS * over + STOP_DAMPING * rate[i]), 0.0)
        lift = ca.fmax(under * (STOP_STIFFNESS * under - STOP_DAMPING * rate[i]), 0.0)
        found.append(size * (lift - push))
    return found


def use(strength: Float[Array, "5 2"], torque: Any, ca: Any = np) -> Any:
    """Return the greatest torque of a joint, in the most that its lengthening muscle can have.

    Args:
        strength: From :func:`strengths`.
        torque: Of muscles and stops together, positive as the coordinates [N m].
        ca: ``numpy`` or ``casadi``.
    """
    greatest: Any = 0.0
    for i, each in enumerate(torque):
        extend, flex = LENGTHENING * strength[i]
        greatest = ca.fmax(greatest, ca.fmax(OPENS[i] * each / extend, -OPENS[i] * each / flex))
    return greatest

r"""Joint torques: strength times velocity factor times activation ([Cheng2009]_, Eqs. 1 and 2).

.. math:: T = T_{max}(\theta)\, h(\omega)\, A(t),

with the velocity factor of :mod:`plantigrade.dynamics.muscle_speed`. Extension is positive; the
shoulder extends as the angle between arm and trunk opens (anatomical flexion).

**Strength** is not in the report. :math:`T_{max}` is that of the Human (both limbs) times a
Gaussian of the joint angle, with centre and width measured on a vaulting gymnast, for the elbow on
a tennis player ([Jackson2010]_, [Kentel2011]_, as tabulated in [Felis2017]_).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.dynamics.muscle_speed import MAX_ECCENTRIC_FACTOR, OMEGA_0, velocity_factor
from plantigrade.models import Human
from plantigrade.vaulting.segments import COORDINATES

EXTENSION_SIGN = np.array([1.0, -1.0, -1.0, -1.0, -1.0])
"""Sign of each coordinate in extension; plantarflexion extends the ankle."""

# [rad] Angle of maximum strength and width of the Gaussian, for extension and flexion.
STRENGTH_BELLS = (
    (
        (0.890118, 1.28980),
        (2.14675, 1.83085),
    ),  # shoulder; the opening direction is called flexion there
    ((1.64319, 1.30795), (0.33, 3.62155)),
    ((1.06465, 1.05941), (0.733038, 1.21999)),
    ((0.942478, 0.509636), (1.02974, 1.11003)),
    ((0.408, 0.660752), (-0.187, 0.60868)),
)


@dataclass(frozen=True)
class JointStop:
    """Range of motion of a joint coordinate [rad]."""

    low: float
    high: float


JOINT_STOPS = (
    JointStop(-1.0, np.deg2rad(180.0)),
    JointStop(0.0, np.deg2rad(145.0)),
    JointStop(np.deg2rad(-25.0), np.deg2rad(125.0)),
    JointStop(0.0, np.deg2rad(145.0)),
    JointStop(np.deg2rad(-55.0), np.deg2rad(35.0)),
)
"""Passive joint stops (bone and ligament), which the report lacks."""
STOP_STIFFNESS = 300.0
"""Stiffness of a stop in the form of the report's Eq. 3, relative to joint strength [1/rad²].
Estimate; full strength at 3.3°."""
STOP_DAMPING = 3.0  #: Damping of a stop relative to joint strength [s/rad²]. Estimate


def strengths(human: Human) -> Float[Array, "5 2"]:
    """Return the isometric strength of both limbs in extension and flexion, positive [N m]."""
    hinges = [1 + human.hinge(f"{name}_r") for name in COORDINATES]
    ranges = human.model.jnt_actfrcrange[hinges]
    both = 2.0 * np.abs(ranges)
    return np.where(EXTENSION_SIGN[:, None] > 0, both[:, ::-1], both)


def muscle_torques(
    strength: Float[Array, "5 2"], angle: Any, rate: Any, activation: Any,
    ca: Any = np,
) -> list[Any]:  # fmt: skip
    """Return the muscle torque of each joint, both limbs, positive as its coordinate [N m].

    Args:
        strength: From :func:`strengths`.
        angle: Coordinates in the order of :data:`~plantigrade.vaulting.segments.COORDINATES` [rad].
        rate: Rates of the coordinates [rad/s].
        activation: Activations, -1 (flexion) to 1 (extension).
        ca: ``numpy`` or ``casadi``.
    """
    found = []
    for i, bells in enumerate(STRENGTH_BELLS):
        ratio = EXTENSION_SIGN[i] * rate[i] / OMEGA_0
        extend, flex = (
            strength[i, k] * ca.exp(-0.5 * ((angle[i] - at) / width) ** 2)
            for k, (at, width) in enumerate(bells)
        )
        up, down = ca.fmax(activation[i], 0.0), ca.fmin(activation[i], 0.0)
        total = up * extend * velocity_factor(ratio, ca) + down * flex * velocity_factor(-ratio, ca)
        found.append(EXTENSION_SIGN[i] * total)
    return found


def stop_torques(strength: Float[Array, "5 2"], angle: Any, rate: Any, ca: Any = np) -> list[Any]:
    """Return the torque of each joint's stops, both limbs, positive as its coordinate [N m]."""
    found = []
    for i, stop in enumerate(JOINT_STOPS):
        size = float(strength[i].mean())
        over, under = ca.fmax(angle[i] - stop.high, 0.0), ca.fmax(stop.low - angle[i], 0.0)
        push = ca.fmax(over * (STOP_STIFFNESS * over + STOP_DAMPING * rate[i]), 0.0)
        lift = ca.fmax(under * (STOP_STIFFNESS * under - STOP_DAMPING * rate[i]), 0.0)
        found.append(size * (lift - push))
    return found


def relative_load(strength: Float[Array, "5 2"], torque: Any, ca: Any = np) -> Any:
    """Return the maximum joint torque relative to the eccentric strength of its muscles [1].

    Args:
        strength: From :func:`strengths`.
        torque: Sum of muscle and stop torques, positive as the coordinates [N m].
        ca: ``numpy`` or ``casadi``.
    """
    greatest: Any = 0.0
    for i, each in enumerate(torque):
        extend, flex = MAX_ECCENTRIC_FACTOR * strength[i]
        greatest = ca.fmax(
            greatest, ca.fmax(EXTENSION_SIGN[i] * each / extend, -EXTENSION_SIGN[i] * each / flex)
        )
    return greatest

r"""Mechanical work of the muscles at the joints of a motion.

It is :math:`\int \max(\tau_m \dot q, 0)\, dt` over all joints, with :math:`\tau_m` the joint torque
less the passive moment of tissue (:mod:`plantigrade.dynamics.passive`). Muscles across two joints
and stretched tendons make the true work of muscle fibres smaller; heat is not counted.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.dynamics.passive import passive_moments, scale
from plantigrade.errors import ParameterError
from plantigrade.record import Record


@dataclass(frozen=True)
class MuscleWork:
    """Work of the muscles at the joints of a motion."""

    positive: float  #: Work done [J]
    negative: float  #: Work absorbed, a positive number [J]
    distance: float  #: Travelled along the ground [m]
    weight: float  #: Body weight [N]

    @property
    def cost_of_transport(self) -> float:
        """Positive work per newton of weight and metre of distance; NaN without distance."""
        if self.distance <= 0:
            return float("nan")
        return self.positive / (self.weight * self.distance)


def muscle_work(record: Record, distance: float) -> MuscleWork:
    """Return the work of the muscles.

    Args:
        record: A motion with joint torques.
        distance: Travelled along the ground [m].

    Raises:
        ParameterError: If the record has no joint torques.
    """
    if record.qfrc_actuator is None:
        raise ParameterError("this record has no joint torques, so the work of muscles is unknown")
    motion, human = record.motion, record.human
    q, v, tau = motion.qpos[:, 7:], motion.qvel[:, 6:], record.qfrc_actuator[:, 6:]
    factor = scale(human.mass, human.height)
    tissue = passive_moments(human.coordinates, list(q.T), list(v.T), factor)
    power = (tau - np.stack([np.broadcast_to(m, len(q)) for m in tissue], axis=1)) * v
    done = float(np.trapezoid(np.maximum(power, 0.0).sum(axis=1), motion.time))
    absorbed = float(np.trapezoid(np.maximum(-power, 0.0).sum(axis=1), motion.time))
    return MuscleWork(done, absorbed, distance, record.weight)

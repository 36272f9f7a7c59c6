"""A device that adds torque at a joint: an exoskeleton with a motor or with a spring."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.errors import ParameterError
from plantigrade.models.mirror import mirror_sign, mirrored_name
from plantigrade.motion.blends import cubic_rise
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.terms.term import Term

CLUTCH_SHARE = 0.03  # [strides] in which the spring is coupled after strike and let go at toe-off


@dataclass(frozen=True)
class Device(Term):
    """A device on a leg that adds torque at a joint of a gait: a profile, a spring, or both.

    The profile is that of tethered ankle exoskeletons [Zhang2017]_: it rises and falls along a
    cubic, in fractions of the stride from the strike of the foot. The spring pulls in the negative
    direction while the foot stands and the joint is beyond an angle, as with a clutch
    [Collins2015]_. The defaults are the mean of the profiles that suited people best.

    The task makes the body with it (:meth:`~plantigrade.trajopt.tasks.task.MotionTask.body_of`).
    """

    coordinate: str  #: Name of the coordinate
    torque: float = 0.0  #: At the peak [N m]; negative at the ankle: plantarflexion
    peak: float = 0.529  #: When the peak is [strides]
    rise: float = 0.262  #: How long the torque rises [strides]
    fall: float = 0.098  #: How long it falls [strides]
    stiffness: float = 0.0  #: Of the spring [N m/rad]
    taut: float = 0.0  #: Angle beyond which the spring pulls [rad]

    def values(self, times: Float[Array, " n"], plan: ContactPlan) -> Float[Array, "n 3"]:
        """Return torque [N m], stiffness [N m/rad] and the angle where the spring is taut [rad]."""
        strike, stance, stride = _stance(plan, self.coordinate[-1])
        phase = ((times - strike) / stride) % 1.0
        late = (phase - self.peak + 0.5) % 1.0 - 0.5  # after the peak, before it negative
        share = np.where(late < 0, 1.0 + late / self.rise, 1.0 - late / self.fall)
        coupled = np.minimum(phase, stance - phase) / CLUTCH_SHARE
        return np.stack(
            [
                self.torque * cubic_rise(share),
                self.stiffness * cubic_rise(coupled),
                np.full(len(times), self.taut),
            ],
            axis=1,
        )

    def add_to(self, b: ProblemBuilder) -> None:
        """Check that the body wears it.

        Raises:
            ParameterError: If it does not, or the motion is no gait.
        """
        if self not in b.body.external.devices:
            raise ParameterError(
                f"the task has a device at {self.coordinate}, and the body wears none: make it "
                "with task.body_of(human)"
            )
        b.column(self.coordinate)
        if not b.plan.periodic or self.coordinate[-2:] not in ("_r", "_l"):
            raise ParameterError(
                "a device works at a right or left joint in a periodic walk or run; its times are "
                "those of the stride"
            )

    def mirrored(self) -> "Device":
        """Return the same device on the other side."""
        sign = mirror_sign(self.coordinate)
        return replace(self, coordinate=mirrored_name(self.coordinate), torque=self.torque * sign)


def _stance(plan: ContactPlan, side: str) -> tuple[float, float, float]:
    """Return a strike of a foot [s], how long it stands [strides], and the time of a stride [s]."""
    stride = plan.duration * (2.0 if plan.mirrored else 1.0)
    own = [s for s in plan.stances if s.footprint.side == side]
    found, later = (own[0], 0.0) if own else (plan.stances[0], plan.duration)
    return (found.heel_strike + later, (found.toe_off - found.heel_strike) / stride, stride)

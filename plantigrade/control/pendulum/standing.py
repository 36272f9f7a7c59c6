"""From the last step of a walk to quiet standing, and from there to the first step."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.site import contact_sites
from plantigrade.control.balance import Reference, ReferenceState
from plantigrade.control.gait.reference import ReferenceTables
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.motion.blends import quintic_rise


class Settling(Reference):
    """The posture of the last step turns into standing; feet stay where they are.

    Args:
        qpos: The posture of the last step.
        standing: Quiet standing at the same place.
        time: When it begins [s].
        duration: How long it takes [s].
    """

    def __init__(
        self,
        human: Human,
        qpos: Float[Array, " nq"],
        standing: Float[Array, " nq"],
        time: float,
        duration: float,
    ):
        self._points = PointSet.of(human, contact_sites(human))
        self._body, self._first, self._last = (
            BodyState(human, qpos),
            np.array(qpos),
            np.array(standing),
        )
        if self._first[3:7] @ self._last[3:7] < 0.0:
            self._last[3:7] *= -1.0
        self._time, self._duration, self._part = time, duration, -1.0
        self._rest = np.zeros(human.model.nv)
        self._everywhere = np.ones(len(self._points), dtype=bool)

    def at(self, time: float) -> ReferenceState:
        """Return the desired state at a time [s]."""
        part = float(quintic_rise((time - self._time) / self._duration))
        if part == self._part:
            return self._desired
        self._part = part
        qpos = (1.0 - part) * self._first + part * self._last
        qpos[3:7] /= np.linalg.norm(qpos[3:7])
        self._body = body = self._body.moved_to(qpos)
        still = np.zeros(3)
        self._desired = ReferenceState(
            qpos, self._rest, self._rest, body.com, still, still,
            body.position(self._points), self._everywhere,
        )  # fmt: skip
        return self._desired


@dataclass(frozen=True)
class GaitStart:
    """The instant of a recording with which a walk begins from standing."""

    phase: float  #: Phase of the recording, when a foot is about to leave the ground [s]
    stance: int  #: Which foot stays
    lateral_offset: float  #: Offset of the extrapolated centre of mass to the left of that foot [m]

    @classmethod
    def of(cls, recorded: ReferenceTables, ahead: float) -> "GaitStart":
        """Return that of a walk.

        Args:
            ahead: How far the right foot is ahead of the left one [m]; that stays on.
        """
        stance = 0 if ahead >= 0.0 else 1
        times = np.arange(0.0, recorded.duration, 0.01).tolist()
        both = [all(recorded.schedule.standing(s, t) is not None for s in SIDES) for t in times]
        ends = (k for k in range(len(times)) if both[k] and not both[(k + 1) % len(times)])
        front = (t for t in (times[k] for k in ends) if _front_foot(recorded, t) == stance)
        phase = next(front, 0.0)
        now = recorded.at(phase)
        xi = now.com + now.com_velocity / recorded.omega
        return cls(phase, stance, float(xi[1] - now.foot_position[stance, 1]))


def _front_foot(recorded: ReferenceTables, phase: float) -> int:
    return int(recorded.at(phase).foot_position[:, 0].argmax())

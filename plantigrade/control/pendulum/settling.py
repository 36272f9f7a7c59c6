"""From the end of a walk to quiet standing: what balance is led to."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.site import contact_sites
from plantigrade.control.balance import Wanted
from plantigrade.kinematics.state import PointSet, State
from plantigrade.models import Human

TAKES = 1.5
"""So long it takes from the last step to quiet standing [s]."""


class Settling:
    """The posture of the last step turns into standing; feet stay where they are.

    Args:
        human: The person.
        qpos: The posture of the last step.
        stands: Quiet standing at the same place.
        time: When it begins [s].
    """

    def __init__(
        self,
        human: Human,
        qpos: Float[Array, " nq"],
        stands: Float[Array, " nq"],
        time: float,
    ):
        self._points = PointSet.of(human, contact_sites(human))
        self._body, self._first, self._last = State(human, qpos), np.array(qpos), np.array(stands)
        if self._first[3:7] @ self._last[3:7] < 0.0:
            self._last[3:7] *= -1.0
        self._time, self._part = time, -1.0
        self._rest = np.zeros(human.model.nv)
        self._everywhere = np.ones(len(self._points), dtype=bool)

    def at(self, time: float) -> Wanted:
        """Return what is wanted at a time [s]."""
        part = min(max((time - self._time) / TAKES, 0.0), 1.0)
        part = part**3 * (10.0 - 15.0 * part + 6.0 * part**2)
        if part == self._part:
            return self._wanted
        self._part = part
        qpos = (1.0 - part) * self._first + part * self._last
        qpos[3:7] /= np.linalg.norm(qpos[3:7])
        self._body = body = self._body.moved_to(qpos)
        self._wanted = Wanted(
            qpos,
            self._rest,
            self._rest,
            body.com,
            np.zeros(3),
            np.zeros(3),
            body.position(self._points),
            self._everywhere,
        )
        return self._wanted

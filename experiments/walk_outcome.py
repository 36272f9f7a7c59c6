"""The outcome of a walk: whether the person stayed upright and returned to the gait."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float

SPEED_TOLERANCE = 0.20
"""Largest error of the mean speed of a stride of the recorded gait, relative. Chosen."""
HEIGHT_TOLERANCE = 0.05
"""Largest error of the mean height of the centre of mass in such a stride [m]. Chosen."""


@dataclass(frozen=True)
class Landing:
    """A landing of a foot.

    Attributes:
        time: Time of touchdown [s].
        side: Side of the foot.
        place: Position of the ankle from the start, ahead and to the left [m].
        heel: Whether the centre of pressure was behind the ankle.
    """

    time: float
    side: str
    place: tuple[float, float]
    heel: bool


@dataclass(frozen=True, eq=False)
class WalkOutcome:
    """The outcome of a walk.

    Attributes:
        survived: Whether only the feet touched the ground until the end, and no leg passed
            through the other.
        end: Reason why the person did not survive; empty otherwise.
        time: Times of the control steps [s].
        com: Centre of mass: forward, to the left, height above the ground below it [m].
        error: Joint angle error reported by the controller [rad]; NaN without a report.
        landings: Touchdowns of the feet.
        pushed: Start and end of the disturbances [s]; None without one.
        speed: Speed of the gait [m/s].
        height: Mean height of its centre of mass [m].
        period: Duration of a stride [s].
        peak: Greatest vertical force on a foot [body weights]; of a pushed walk since the push, as
            the next two.
        lean: Greatest angle of the upper trunk against the vertical [deg].
        bend: Greatest angle of the upper trunk against the pelvis, their upward axes [deg].
    """

    survived: bool
    end: str
    time: Float[Array, " n"]
    com: Float[Array, "n 3"]
    error: Float[Array, " n"]
    landings: tuple[Landing, ...]
    pushed: tuple[float, float] | None
    speed: float
    height: float
    period: float
    peak: float = 0.0
    lean: float = float("nan")
    bend: float = float("nan")

    @property
    def seconds(self) -> float:
        """Time on the feet [s]."""
        return float(self.time[-1]) if len(self.time) else 0.0

    def mean_speed(self, since: float = 0.0) -> float:
        """Return the mean speed along the direction of the gait from a time on [m/s]."""
        k = int(np.searchsorted(self.time, since))
        if k >= len(self.time) - 1:
            return 0.0
        return float((self.com[-1, 0] - self.com[k, 0]) / (self.time[-1] - self.time[k]))

    @property
    def rms(self) -> float:
        """RMS error of the joint angles [rad]; NaN where the controller reports none."""
        known = self.error[np.isfinite(self.error)]
        return float(np.sqrt(np.mean(known**2))) if len(known) else float("nan")

    @property
    def as_recorded(self) -> tuple[Float[Array, " k"], Any]:
        """Ends of all windows of one stride [s], and whether each was as recorded.

        It requires speed within :data:`SPEED_TOLERANCE` and height of the centre of mass within
        :data:`HEIGHT_TOLERANCE`.
        """
        if len(self.time) < 3:
            return np.zeros(0), np.zeros(0, dtype=bool)
        step = float(np.median(np.diff(self.time)))
        n = max(round(self.period / step), 1)
        if len(self.time) <= n:
            return np.zeros(0), np.zeros(0, dtype=bool)
        speed = (self.com[n:, 0] - self.com[:-n, 0]) / (self.time[n:] - self.time[:-n])
        total = np.concatenate([[0.0], np.cumsum(self.com[:, 2])])
        height = (total[n + 1 :] - total[1:-n]) / n
        fine = np.abs(speed - self.speed) <= SPEED_TOLERANCE * self.speed
        return self.time[n:], fine & (np.abs(height - self.height) <= HEIGHT_TOLERANCE)

    @property
    def back(self) -> float | None:
        """Time from the end of the disturbance to the permanent return to the recorded gait [s].

        None without a return, or after a fall. Strides that began before it count.
        """
        ends, fine = self.as_recorded
        if not self.survived or not len(fine) or not fine[-1]:
            return None
        since = 0.0 if self.pushed is None else self.pushed[1]
        bad = np.flatnonzero(~fine)
        first = float(ends[bad[-1] + 1]) if len(bad) else float(ends[0])
        return max(first - since, 0.0)

    @property
    def withstood(self) -> bool:
        """Whether the person survived and returned to the gait by the end."""
        return self.back is not None

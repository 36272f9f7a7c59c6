r"""The rate of turn of a walk, and where its centre of mass is to be for the turn ahead.

Footsteps on a bend leave the straight line of the walk, each farther than the one before. Their
effect is in the extrapolated centre of mass beforehand: on a linear pendulum it is the mean of all
pressures to come, :math:`\xi = \int \omega e^{-\omega \tau} p(t + \tau)\,\mathrm{d}\tau`. With
steps of the duration :math:`T` it is therefore nearer to the inside of the bend, at a touchdown, by

.. math::

    \sum_{j \ge 1} \left(e^{-\omega j T} - e^{-\omega (j + 1) T}\right) y_j,

where :math:`y_j` is how far to the left the j-th foot from then on will be: on the bend by then,
and ahead of the mass by :math:`v / \omega - v T / (e^{\omega T} - 1)` in the direction of then.
For short steps that is :math:`v r / \omega^2`, the centripetal offset of a circle of the rate
:math:`r`; with people's steps it is three quarters of that. Walks that leaned the whole of it
drifted inward by 10 cm a step, and those that knew the rate of each moment only crossed their feet
as a turn ended.
"""

from dataclasses import dataclass
from math import ceil, exp
from typing import NamedTuple

import numpy as np

from plantigrade.arrays import Array, Float

STRAIGHT_TOLERANCE = 1e-6  # [rad, rad/s] heading error and rate of turn that are zero
PREDICTION_STEP = 0.04  # [s] of the numerical prediction
N_LATER_FOOTSTEPS = 4  # after the next one that count; later ones weigh a thousandth


@dataclass(frozen=True, kw_only=True)
class TurnSettings:
    """How fast a walk turns."""

    max_rate: float = 0.3
    """Greatest rate of turn [rad/s]. Chosen (±20 %: below 2 %)."""
    heading_gain: float = 2.0
    """Rate of turn by heading error, and its greatest change by the greatest rate [1/s]. Chosen
    (±20 %: below 2 %)."""

    def next_rate(self, heading_error: float, rate: float, step: float) -> float:
        """Return the rate of turn a time step later [rad/s].

        Args:
            heading_error: From the present to the desired heading, to the left [rad].
            rate: Rate of turn now [rad/s].
            step: The time step [s].
        """
        desired = min(max(self.heading_gain * heading_error, -self.max_rate), self.max_rate)
        change = self.heading_gain * self.max_rate * step
        return rate + min(max(desired - rate, -change), change)


class PredictedTurn(NamedTuple):
    """The turn of a walk until a touchdown."""

    angle: float = 0.0
    """Angle of the turn until then, to the left [rad]."""
    lateral_offset: float = 0.0
    """Offset of the extrapolated centre of mass to the left, in axes that have turned [m]."""
    foot_angle: float = 0.0
    """Half the angle of the step that begins then, which the foot is turned by [rad]."""


class Turn:
    """The turn of a walk: its rate, and the prediction of what follows.

    Attributes:
        rate: Rate of turn, to the left [rad/s].
    """

    def __init__(self, settings: TurnSettings | None = None):
        self.settings, self.rate = settings or TurnSettings(), 0.0
        self._path: Float[Array, "n 3"] | None = None

    def update(
        self, heading_error: float, speed: float, duration: float, omega: float, step: float
    ) -> None:
        """Advance by a time step, and predict the rest of the turn.

        Args:
            heading_error: From the present to the desired heading, to the left [rad].
            speed: Speed of the walk [m/s].
            duration: Duration of its steps [s].
            omega: Root of gravity by height [1/s].
            step: The time step [s].
        """
        own = self.settings
        self.rate = own.next_rate(heading_error, self.rate, step)
        if abs(heading_error) + abs(self.rate) < STRAIGHT_TOLERANCE:
            self.rate, self._path = 0.0, None
            return
        self._duration, self._omega = duration, omega
        self._ahead = speed / omega - speed * duration / (exp(omega * duration) - 1.0)
        rate, angle, angles = self.rate, 0.0, [0.0]
        for _ in range(ceil((N_LATER_FOOTSTEPS + 1) * duration / PREDICTION_STEP) + 1):
            rate = own.next_rate(heading_error - angle, rate, PREDICTION_STEP)
            angle += PREDICTION_STEP * rate
            angles.append(angle)
        headings = np.array(angles)
        middle = 0.5 * (headings[1:] + headings[:-1])
        self._path = np.zeros((len(headings), 3))
        self._path[:, 0] = headings
        self._path[1:, 1] = PREDICTION_STEP * speed * np.cumsum(np.cos(middle))
        self._path[1:, 2] = PREDICTION_STEP * speed * np.cumsum(np.sin(middle))

    def predicted(self, time: float) -> PredictedTurn:
        """Return the turn until the touchdown in a time [s]."""
        path, n = self._path, N_LATER_FOOTSTEPS
        if path is None:
            return PredictedTurn()
        times = (time + self._duration * np.arange(n + 1)) / PREDICTION_STEP
        i = np.minimum(times.astype(int), len(path) - 2)
        part = np.minimum(times - i, 1.0)[:, None]
        angle, x, y = ((1.0 - part) * path[i] + part * path[i + 1]).T
        c, s = np.cos(angle[0]), np.sin(angle[0])
        offset = c * (y - y[0]) - s * (x - x[0]) + self._ahead * np.sin(angle - angle[0])
        decay = np.exp(-self._omega * self._duration * np.arange(1, n + 1))
        weight = decay - np.append(decay[1:], 0.0)
        return PredictedTurn(
            float(angle[0]), float(weight @ offset[1:]), 0.5 * float(angle[1] - angle[0])
        )

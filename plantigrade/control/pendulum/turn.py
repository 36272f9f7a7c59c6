r"""A turn foreseen: how fast a walk turns, and where its mass is to be for that.

Feet that land on a bend stand beside the straight line that the walk would take from now on, each
farther than the one before. What they will push is in the extrapolated centre of mass beforehand:
on a linear pendulum it is the mean of all pressures to come,
:math:`\xi = \int \omega e^{-\omega \tau} p(t + \tau)\,\mathrm{d}\tau`. With steps of the duration
:math:`T` it is therefore nearer to the inside of the bend, when a foot strikes, by

.. math::

    \sum_{j \ge 1} \left(e^{-\omega j T} - e^{-\omega (j + 1) T}\right) y_j,

where :math:`y_j` is how far to the left the j-th foot from then on will be: on the bend by then,
and ahead of the mass by :math:`v / \omega - v T / (e^{\omega T} - 1)` in the direction of then.
Where steps are short that is :math:`v r / \omega^2`, what a circle of the rate :math:`r` asks for;
with people's steps it is three quarters of that. Walks that leaned the whole of it drifted inward
by 10 cm a step, and those that knew the rate of each moment only crossed their feet as a turn
ended.
"""

from math import ceil, exp

import numpy as np

from plantigrade.arrays import Array, Float

FASTEST = 0.3
"""A walk is turned so fast, at most [rad/s]."""
TWISTING = 1.0
"""So much sooner it is turned [rad/s²]."""
STEERING = 2.0
"""A bearing that is missed is turned to at this rate [1/s]."""
FINE = 0.04
"""In such steps a turn is foreseen [s]."""
STEPS = 4
"""So many steps after the next one count: what comes later is a thousandth."""
STILL = 1e-6
"""A turn slower and a bearing missed by less than this is none [rad/s, rad]."""


class Turn:
    """A turn.

    Attributes:
        rate: How fast it turns to the left now [rad/s].
    """

    def __init__(self):
        self.rate = 0.0
        self._path: Float[Array, "n 3"] | None = None

    def look(self, off: float, speed: float, duration: float, omega: float, step: float) -> None:
        """Go on by a step, and foresee the rest.

        Args:
            off: By how much the bearing is missed, to the left [rad].
            speed: How fast the walk is [m/s].
            duration: Of its steps [s].
            omega: Root of gravity by height [1/s].
            step: How long the step is by which it goes on [s].
        """
        self.rate = steered(off, self.rate, step)
        if abs(off) + abs(self.rate) < STILL:
            self.rate, self._path = 0.0, None
            return
        self._duration, self._omega = duration, omega
        self._ahead = speed / omega - speed * duration / (exp(omega * duration) - 1.0)
        rate, angle, angles = self.rate, 0.0, [0.0]
        for _ in range(ceil((STEPS + 1) * duration / FINE) + 1):
            rate = steered(off - angle, rate, FINE)
            angle += FINE * rate
            angles.append(angle)
        ways = np.array(angles)
        middle = 0.5 * (ways[1:] + ways[:-1])
        self._path = np.zeros((len(ways), 3))
        self._path[:, 0] = ways
        self._path[1:, 1] = FINE * speed * np.cumsum(np.cos(middle))
        self._path[1:, 2] = FINE * speed * np.cumsum(np.sin(middle))

    def after(self, left: float) -> tuple[float, float, float]:
        """Return by how much it will have turned, and how far inward the mass is to be then.

        Args:
            left: In what time, when a foot is to strike [s].

        Returns:
            The angle, to the left [rad]; how far the extrapolated centre of mass is then to the
            left of where it is on a straight way, in axes that are turned so [m]; half the angle
            of the step that begins then [rad].
        """
        if self._path is None:
            return 0.0, 0.0, 0.0
        path = self._path
        times = (left + self._duration * np.arange(STEPS + 1)) / FINE
        i = np.minimum(times.astype(int), len(path) - 2)
        part = np.minimum(times - i, 1.0)[:, None]
        angle, x, y = ((1.0 - part) * path[i] + part * path[i + 1]).T
        c, s = np.cos(angle[0]), np.sin(angle[0])
        beside = c * (y - y[0]) - s * (x - x[0]) + self._ahead * np.sin(angle - angle[0])
        falls = np.exp(-self._omega * self._duration * np.arange(1, STEPS + 1))
        weight = falls - np.append(falls[1:], 0.0)
        return float(angle[0]), float(weight @ beside[1:]), 0.5 * float(angle[1] - angle[0])


def steered(off: float, rate: float, step: float) -> float:
    """Return how fast a walk turns a little later [rad/s].

    Args:
        off: By how much its bearing is missed [rad].
        rate: How fast it turns now [rad/s].
        step: How much later [s].
    """
    wanted = min(max(STEERING * off, -FASTEST), FASTEST)
    far = TWISTING * step
    return rate + min(max(wanted - rate, -far), far)

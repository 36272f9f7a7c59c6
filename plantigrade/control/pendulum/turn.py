r"""A turn foreseen: how fast a walk turns, and where its mass is to be for that.

Who goes round a bend at the speed :math:`v` and the rate :math:`r` is accelerated towards its
centre by :math:`v r`. On a linear pendulum the mass is then nearer to the centre than the feet, by
:math:`d = v r / \omega^2`, where the bend is a circle. Where the rate changes, the extrapolated
centre of mass :math:`\xi` has to be where what is still to come needs it, and the mass follows it:

.. math::

    \dot \xi = \omega (\xi - d), \qquad \dot x = \omega (\xi - x),

of which the first is solved backwards from the end of what is foreseen, the second forwards from
now. With the :math:`d` of each moment alone, feet that ended a turn were set across each other.
"""

from math import exp

import numpy as np

FASTEST = 0.4
"""A walk is turned so fast, at most [rad/s]."""
TWISTING = 1.0
"""So much sooner it is turned [rad/s²]."""
STEERING = 2.0
"""A bearing that is missed is turned to at this rate [1/s]."""
FINE, AHEAD = 0.04, 40
"""Steps in which a turn is foreseen [s], and how many."""
STILL = 1e-6
"""A turn slower and a bearing missed by less than this is none [rad/s, rad]."""


class Turn:
    """A turn.

    Attributes:
        rate: How fast it turns to the left now [rad/s].
        inward: How far the mass is to be to the left of where it is on a straight way [m].
        drift: How fast that grows [m/s].
    """

    def __init__(self):
        self.rate = self.inward = self.drift = 0.0
        self._clock = np.arange(AHEAD + 1) * FINE
        self._angle, self._inward, self._drift = np.zeros((3, AHEAD + 1))

    def look(self, off: float, speed: float, omega: float, step: float) -> None:
        """Go on by a step, and foresee the rest.

        Args:
            off: By how much the bearing is missed, to the left [rad].
            speed: How fast the walk is [m/s].
            omega: Root of gravity by height [1/s].
            step: How long the step is [s].
        """
        self.rate = steered(off, self.rate, step)
        if abs(off) + abs(self.rate) < STILL:
            self.rate = 0.0
            if abs(self.inward) < STILL:
                self.inward = self.drift = 0.0
                self._angle[:] = self._inward[:] = self._drift[:] = 0.0
                return
        angle, rate, needs = 0.0, self.rate, []
        for k in range(1, AHEAD + 1):
            needs.append(speed * rate / omega**2)
            rate = steered(off - angle, rate, FINE)
            angle += FINE * rate
            self._angle[k] = angle
        left, xi = exp(-omega * FINE), speed * rate / omega**2
        goals = []
        for need in reversed(needs):
            xi = left * xi + (1.0 - left) * need
            goals.append(xi)
        goals.reverse()
        goals.append(goals[-1])
        part = 1.0 - exp(-omega * step)
        self.inward += part * (goals[0] - self.inward)
        x = self.inward
        for k, goal in enumerate(goals):
            self._inward[k], self._drift[k] = x, omega * (goal - x)
            x += (1.0 - left) * (goal - x)
        self.drift = float(self._drift[0])

    def after(self, left: float) -> tuple[float, float, float]:
        """Return by how much it will have turned, and how much farther inward the mass will be.

        Args:
            left: In what time [s].

        Returns:
            The angle, to the left [rad]; how much farther inward than now [m]; how much faster it
            will go there [m/s].
        """
        k = min(left / FINE, AHEAD - 1e-6)
        i = int(k)
        part = k - i
        angle, inward, drift = (
            float((1.0 - part) * row[i] + part * row[i + 1])
            for row in (self._angle, self._inward, self._drift)
        )
        return angle, inward - self.inward, drift - self.drift


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

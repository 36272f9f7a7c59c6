"""Ground that tilts as somebody wants it to."""

from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.world.platform import Platform
from plantigrade.world.simulated_world import SimulatedWorld

FAR = 60.0
"""Half its length and width: people walk on it [m]."""
LIFTS = 0.15
"""It lifts nobody faster who is far from its middle [m/s]."""
QUICK = 4.0
"""How fast the plate follows what is wanted [rad/s]: half the way in 0.4 s."""


class Slope(Platform):
    """A plate that turns to the slope that is wanted, with a critically damped spring.

    Attributes:
        wanted: Slope up in front, and up on the left [rad].
    """

    half = FAR

    def __init__(self):
        self.wanted = np.zeros(2)
        self._still()

    def reset(self, world: SimulatedWorld) -> None:
        """Lie level: a person who starts stands on level ground."""
        self.wanted = np.zeros(2)
        self._still()
        super().reset(world)

    def act(self, world: SimulatedWorld) -> None:
        """Follow what is wanted, the more slowly the farther the person is from its middle."""
        x, y = world.data.qpos[:2].tolist()
        self._fastest = LIFTS / max(hypot(x, y), 1e-2)
        super().act(world)

    def position(self, time: float) -> Float[Array, " 4"]:
        """Return where the plate is to be by now: it has no path of its own."""
        return np.array([0.0, 0.0, *self._slope])

    def path(self, time: float) -> tuple[Array, Array, Array]:
        """Return place, speed and acceleration; the spring is followed up to this time."""
        h, self._time = max(time - self._time, 0.0), max(time, self._time)
        far = self._fastest * h
        self._near = self._near + np.clip(self.wanted - self._near, -far, far)
        off, rate = self._slope - self._near, self._rate
        b, decay = rate + QUICK * off, np.exp(-QUICK * h)
        self._slope = self._near + (off + b * h) * decay
        self._rate = (rate - QUICK * b * h) * decay
        pull = -(QUICK**2) * (self._slope - self._near) - 2 * QUICK * self._rate
        still = np.zeros(2)
        return self.position(time), np.r_[still, self._rate], np.r_[still, pull]

    def _still(self) -> None:
        self._slope, self._rate, self._time = np.zeros(2), np.zeros(2), 0.0
        self._near, self._fastest = np.zeros(2), 1e3

"""Ground that tilts to a slope set by the user."""

from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.world.platform import Platform
from plantigrade.world.simulated_world import SimulatedWorld

HALF_SIZE = 60.0  # [m] half length and half width, room for walking
MAX_LIFT_SPEED = 0.15  # [m/s] of the ground under the person, far from the axis
FOLLOWING_RATE = 4.0  # [rad/s] of the response to the desired slope, half of it in 0.4 s


class Slope(Platform):
    """A plate that follows the desired slope like a critically damped spring.

    Attributes:
        desired: Desired slope, up in front and up on the left [rad].
    """

    half = HALF_SIZE

    def __init__(self):
        self.desired = np.zeros(2)
        self._level()

    def reset(self, world: SimulatedWorld) -> None:
        """Level the plate, because a person starts on level ground."""
        self.desired = np.zeros(2)
        self._level()
        super().reset(world)

    def act(self, world: SimulatedWorld) -> None:
        """Follow the desired slope, more slowly if the person is far from the axis."""
        x, y = world.data.qpos[:2].tolist()
        self._max_rate = MAX_LIFT_SPEED / max(hypot(x, y), 1e-2)
        super().act(world)

    def position(self, time: float) -> Float[Array, " 4"]:
        """Return the present position of the plate, which has no path in advance."""
        return np.array([0.0, 0.0, *self._slope])

    def path(self, time: float) -> tuple[Array, Array, Array]:
        """Return position, velocity and acceleration after advancing the spring to a time."""
        h, self._time = max(time - self._time, 0.0), max(time, self._time)
        far = self._max_rate * h
        self._goal = self._goal + np.clip(self.desired - self._goal, -far, far)
        off, rate = self._slope - self._goal, self._rate
        b, decay = rate + FOLLOWING_RATE * off, np.exp(-FOLLOWING_RATE * h)
        self._slope = self._goal + (off + b * h) * decay
        self._rate = (rate - FOLLOWING_RATE * b * h) * decay
        pull = -(FOLLOWING_RATE**2) * (self._slope - self._goal) - 2 * FOLLOWING_RATE * self._rate
        still = np.zeros(2)
        return self.position(time), np.r_[still, self._rate], np.r_[still, pull]

    def _level(self) -> None:
        self._slope, self._rate, self._time = np.zeros(2), np.zeros(2), 0.0
        self._goal, self._max_rate = np.zeros(2), 1e3

"""The offset of a swing foot from the motion, until it reaches its footstep."""

from dataclasses import dataclass
from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float

_MIN_SEGMENT = 0.02  # [s] keeps the duration of both parts of a path off zero


@dataclass(frozen=True, kw_only=True)
class SwingOffsetSettings:
    """How the offset of a swing foot reaches that of its footstep, past the other leg."""

    max_acceleration: float = 80.0
    """Greatest acceleration of a swing foot: of its offset, or on a path of its own [m/s²]. Chosen
    (±20 %: deviation 30 %)."""
    arrival_lead: float = 0.02
    """Time before touchdown at which the foot is over its footstep [s]. Chosen (±20 %: 0.6 s)."""
    min_arrival_time: float = 0.05
    """Least time in which the path ends, and in which a foot then takes its load [s]. Chosen (±20
    %: deviation 29 %)."""
    min_foot_distance: float = 0.08
    """Least lateral distance of the feet, unless the motion has less [leg lengths]. Chosen (±20 %:
    deviation 25 %)."""
    passing_length: float = 0.30
    """Distance ahead or behind within which a foot passes the other on its side, and beyond which
    it may land across the other: nearer, the legs are in each other's way [leg lengths]. Chosen
    (±20 %: deviation 14 %)."""
    passing_slope: float = 0.5
    """Decrease of the lateral distance by the distance beyond that. Chosen (±20 %: deviation 19
    %)."""


class SwingOffset:
    """The offset of a swing foot, on a cubic to that of its footstep, planned anew at every tick.

    Args:
        offset: Offset from the motion at lift-off [m].

    Attributes:
        offset: Offset from the motion [m].
        velocity: Its velocity [m/s].
        acceleration: Its acceleration [m/s²].
        own: Velocity [m/s] and acceleration [m/s²] over the ground of a foot that has left the path
            of the motion; else None.
    """

    def __init__(self, offset: Float[Array, " 2"], settings: SwingOffsetSettings | None = None):
        self.offset, self.velocity = np.array(offset, dtype=float), np.zeros(2)
        self.acceleration = np.zeros(2)
        self.settings = settings or SwingOffsetSettings()
        self.own: tuple[Array, Array] | None = None

    def lead(self, target: Float[Array, " 2"], left: float, step: float) -> None:
        """Advance by a time step, to be at rest at the target at touchdown.

        Args:
            target: Offset of the footstep [m].
            left: Time until touchdown [s].
            step: The time step [s].
        """
        a = self.acceleration = self._cubic(target - self.offset, self.velocity, left)
        self.offset = self.offset + step * self.velocity + 0.5 * step**2 * a
        self.velocity = self.velocity + step * a
        self.own = None

    def go(
        self,
        foot: Float[Array, "2 2"],
        motion: Float[Array, "2 2"],
        goal: Float[Array, " 2"],
        left: float,
        step: float,
        via: Float[Array, " 2"] | None = None,
    ) -> None:
        """Go straight to a footstep from where the foot is, off the path of the motion.

        A step at twice its rate or more, or around the other foot, has little in common with the
        recorded one, from which a cubic would swing out far. Begun with the rate of the
        recorded foot, or led on while the real one is held up, the path ends decimetres beyond its
        goal; therefore it begins anew at every tick.

        Args:
            foot: Position [m] and velocity [m/s] of the foot.
            motion: The same of the motion, at the rate of now.
            goal: The footstep [m].
            left: Time until touchdown [s].
            step: The time step [s].
            via: A point on the way [m].
        """
        at, speed = foot
        if via is None:
            a = self._cubic(goal - at, speed, left)
        else:
            a = self._two_cubics(via - at, goal - via, speed, left)
        self.offset = at + step * speed + 0.5 * step**2 * a - motion[0]
        self.own = speed + step * a, a
        self.velocity, self.acceleration = self.own[0] - motion[1], a

    def hold_back(self, outward: Float[Array, " 2"], by: float) -> None:
        """Move the foot outward, and stop its inward motion: the other leg is in the way."""
        self.offset = self.offset + by * outward
        self.velocity = _no_less(self.velocity, outward)
        self.acceleration = _no_less(self.acceleration, outward)
        if self.own is not None:
            self.own = _no_less(self.own[0], outward), _no_less(self.own[1], outward)

    def pass_beside(
        self,
        off: Float[Array, " 2"],
        planned: Float[Array, " 2"],
        axes: Float[Array, "2 2"],
        side: float,
        leg_length: float,
        overlap: float,
    ) -> None:
        """Hold the foot on its side of the other one while it passes it.

        Args:
            off: Position in the motion, from where the other foot really is [m].
            planned: The same as the motion has both [m].
            axes: Ahead and to the left, as columns.
            side: 1 for the left foot, -1 for the right.
            leg_length: Length of the leg [m].
            overlap: Greatest depth of one leg in the other in the motion itself [m].
        """
        settings, outward = self.settings, side * axes[:, 1]
        ahead = float((off + self.offset) @ axes[:, 0])
        distance = float((off + self.offset) @ outward)
        width = abs(float(planned @ axes[:, 1]))
        least = min(settings.min_foot_distance * leg_length, width)
        if overlap > 0.0:
            least = max(least, width + overlap)
        beyond = max(abs(ahead) - settings.passing_length * leg_length, 0.0)
        least -= settings.passing_slope * beyond
        if distance < least:
            self.hold_back(outward, least - distance)

    def _cubic(
        self, way: Float[Array, " 2"], velocity: Float[Array, " 2"], left: float
    ) -> Float[Array, " 2"]:
        """Return the acceleration at the beginning of a cubic that ends at rest [m/s²]."""
        T = self._duration(left)
        return self._limited((6.0 * way - 4.0 * velocity * T) / T**2)

    def _two_cubics(
        self,
        first: Float[Array, " 2"],
        then: Float[Array, " 2"],
        velocity: Float[Array, " 2"],
        left: float,
    ) -> Float[Array, " 2"]:
        """Return the acceleration at the beginning of :func:`two_cubics` to the goal [m/s²].

        Their durations are proportional to their lengths.
        """
        T = self._duration(left)
        near, far = hypot(*first), hypot(*then)
        h = max(T * near / max(near + far, 1e-9), _MIN_SEGMENT)
        return self._limited(two_cubics(first, then, velocity, h, max(T - h, _MIN_SEGMENT))[0])

    def _duration(self, left: float) -> float:
        return max(left - self.settings.arrival_lead, self.settings.min_arrival_time)

    def _limited(self, a: Float[Array, " 2"]) -> Float[Array, " 2"]:
        return a * min(1.0, self.settings.max_acceleration / max(hypot(*a), 1e-9))


def two_cubics(
    first: Float[Array, "*n 2"],
    then: Float[Array, "*n 2"],
    velocity: Float[Array, " 2"],
    h: Float[Array, "*n 1"] | float,
    rest: Float[Array, "*n 1"] | float,
) -> tuple[Float[Array, "*n 2"], Float[Array, "*n 2"]]:
    """Return the first acceleration of two smooth cubics to rest, and the velocity between them.

    Args:
        first: The way on the first [m]; ``then`` is that on the second.
        h: Duration of the first [s]; ``rest`` is that of the second.
    """
    passing = 3.0 * (first / h**2 + then / rest**2) - velocity / h
    passing = passing / (2.0 * (1.0 / h + 1.0 / rest))
    return (6.0 * first / h - 4.0 * velocity - 2.0 * passing) / h, passing


def _no_less(vector: Float[Array, " 2"], direction: Float[Array, " 2"]) -> Float[Array, " 2"]:
    """Return a vector without its part against a direction."""
    return vector + direction * max(-float(vector @ direction), 0.0)

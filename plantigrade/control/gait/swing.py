"""The offset of a swinging foot from the motion: how it gets to its landing place."""

from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float

FASTEST = 60.0
"""Acceleration of the offset, or of a foot that goes its own way [m/s²]."""
NARROW = 0.08
"""Feet are at least so far apart sideways, of the leg length, unless the motion has them nearer."""
BESIDE = 0.30
"""A swinging foot nearer than this to the other fore and aft, of the leg, passes it on its side."""
SLACK = 0.005
"""So much nearer than planned it may pass [m]."""
SLANT = 0.5
"""Farther away it may be so much nearer to the line ahead, by its distance."""
APART, WIDER = 0.005, 0.12
"""Legs that overlap in the motion are led so far apart [m], up to this part of the leg length."""


class SwingOffset:
    """The offset of a swinging foot, led to that of its landing by a cubic, anew at every tick.

    Args:
        offset: Where the foot left the ground, beside the motion [m].

    Attributes:
        offset: Where it is, beside the motion [m].
        velocity: How fast that changes [m/s].
        acceleration: And how fast that does [m/s²].
        own: Velocity [m/s] and acceleration [m/s²] over the ground of a foot that no longer goes
            along with the motion; else None.
    """

    def __init__(self, offset: Float[Array, " 2"]):
        self.offset, self.velocity = np.array(offset, dtype=float), np.zeros(2)
        self.acceleration = np.zeros(2)
        self.own: tuple[Array, Array] | None = None

    def lead(self, target: Float[Array, " 2"], left: float, step: float) -> None:
        """Go on for a time step, to be at rest at the target when the time left is over.

        The end is planned 20 ms early, and no sooner than in 50 ms.

        Args:
            target: The offset to be reached [m].
            left: In what time [s].
            step: The time step [s].
        """
        a = self.acceleration = _cubic(target - self.offset, self.velocity, left)
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
        by: Float[Array, " 2"] | None = None,
    ) -> None:
        """Go straight to a place from where the foot is, and no longer along with the motion.

        A step that is taken at twice its rate or more, or around the other foot, has little in
        common with the recorded one, which would swing out far beyond a cubic beside it. Begun
        with the rate of the recorded foot, or led on while the real one is held up, the path ends
        decimetres beyond its goal; therefore it begins anew at every tick.

        Args:
            foot: Where the foot is [m], and its velocity [m/s].
            motion: The same of the motion, at the rate of now.
            goal: The place to be reached [m].
            left: In what time [s].
            step: The time step [s].
            by: A point on the way [m].
        """
        at, pace = foot
        a = _cubic(goal - at, pace, left) if by is None else _past(by - at, goal - by, pace, left)
        self.offset = at + step * pace + 0.5 * step**2 * a - motion[0]
        self.own = pace + step * a, a
        self.velocity, self.acceleration = self.own[0] - motion[1], a

    def hold_back(self, outward: Float[Array, " 2"], by: float) -> None:
        """Go on from so far outward, and no longer inward: the other leg is in the way."""
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
        leg: float,
        overlap: float,
    ) -> None:
        """Hold the foot on its side of the other one while it passes it.

        Args:
            off: Where the motion has it now, less where the other foot really is [m].
            planned: The same as the motion has both [m].
            axes: Ahead and to the left, as columns.
            side: 1 for the left foot, -1 for the right.
            leg: Length of the leg [m].
            overlap: How deep one leg is in the other in the motion itself, at most [m].
        """
        outward = side * axes[:, 1]
        ahead = float((off + self.offset) @ axes[:, 0])
        aside = float((off + self.offset) @ outward)
        width = abs(float(planned @ axes[:, 1]))
        narrow = min(NARROW * leg, width - SLACK)
        if overlap > 0.0:
            narrow = max(narrow, min(width + overlap + APART, WIDER * leg))
        narrow -= SLANT * max(abs(ahead) - BESIDE * leg, 0.0)
        if aside < narrow:
            self.hold_back(outward, narrow - aside)


def _cubic(
    way: Float[Array, " 2"], velocity: Float[Array, " 2"], left: float
) -> Float[Array, " 2"]:
    """Return the acceleration at the beginning of a cubic that ends at rest [m/s²]."""
    T = max(left - 0.02, 0.05)
    a = (6.0 * way - 4.0 * velocity * T) / T**2
    return a * min(1.0, FASTEST / max(hypot(*a), 1e-9))


def _past(
    first: Float[Array, " 2"], then: Float[Array, " 2"], velocity: Float[Array, " 2"], left: float
) -> Float[Array, " 2"]:
    """Return the acceleration at the beginning of two cubics that end at rest [m/s²].

    Acceleration is steady where one goes over into the other; their times are as their lengths.
    """
    T = max(left - 0.02, 0.05)
    near, far = hypot(*first), hypot(*then)
    h = max(T * near / max(near + far, 1e-9), 0.02)
    rest = max(T - h, 0.02)
    passing = 3.0 * (first / h**2 + then / rest**2) - velocity / h
    passing = passing / (2.0 * (1.0 / h + 1.0 / rest))
    a = (6.0 * first / h - 4.0 * velocity - 2.0 * passing) / h
    return a * min(1.0, FASTEST / max(hypot(*a), 1e-9))


def _no_less(vector: Float[Array, " 2"], way: Float[Array, " 2"]) -> Float[Array, " 2"]:
    """Return a vector without what it has against a direction."""
    return vector + way * max(-float(vector @ way), 0.0)

"""Where a sole can stand on uneven ground: how it lies there, and a better place near by.

A foot that lands half on an edge along it rolls over that edge; people put it beside. An edge
across it does little harm: heel and ball are far apart, and the foot lies on both.
"""

from math import hypot

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.control.gait.phase import Foot
from plantigrade.control.pendulum.frame import Underfoot

ALONG, ACROSS = (-0.07, 0.05, 0.17), 0.045
"""Heel, middle and ball ahead of the ankle, and half the width of a sole [leg lengths]."""
ROLLED, PITCHED = 0.15, 0.4
"""A sole is tilted so much with the ground, at most, sideways and along it [rad]: over an edge it
is kept level by the ankle."""
ROLL, PITCH = 0.12, 0.3
"""Tilts of the ground, sideways and along the sole, that cost 1 [rad]."""
SHIFT = (0.09, 0.06)
"""Shifts of a place ahead and sideways that cost 1 [leg lengths]."""
AHEAD, ASIDE = (-0.1, -0.05, 0.0, 0.05, 0.1), (-0.07, -0.035, 0.0, 0.035, 0.07)
"""Shifts that are tried, likewise."""
STAYS = 0.3
"""Another place is taken where it costs so much less."""
SETTLED = 0.1
"""So long before it lands a foot goes where it was to go [s]."""
INWARD = 0.1
"""A place is not shifted nearer to the other foot than that, sideways [leg lengths]."""
AXIS = np.array([1.0, 0.0])
"""Where a foot points that lands."""


class Sole:
    """One foot, and the ground under it.

    Args:
        leg: Length of the leg [m].
        left: 1 for the left foot, -1 for the right.

    """

    def __init__(self, leg: float, left: float):
        self.leg, self.left = leg, left
        self._normal = np.array([0.0, 0.0, 1.0])
        self._shift = np.zeros(2)
        n = [(x, y) for x in ALONG for y in (ACROSS, -ACROSS)]
        self._points = leg * np.array(n)
        self._tried = leg * np.array([(x, y) for x in AHEAD for y in ASIDE])
        self._cost = ((self._tried / (leg * np.array(SHIFT))) ** 2).sum(axis=1)

    def heights(
        self, ground: Ground | Underfoot, places: Float[Array, "n 2"], ahead: Float[Array, " 2"]
    ) -> Float[Array, "n 3 2"]:
        """Return heights of the ground under heel, middle and ball, left and right [m].

        Args:
            ground: The ground.
            places: Of the ankle [m].
            ahead: Where the foot points, of length one.
        """
        axes = np.array([ahead, [-ahead[1], ahead[0]]])
        points = np.zeros((len(places), len(self._points), 3))
        points[:, :, :2] = places[:, None] + self._points @ axes
        normal = ground.normal
        high = (ground.under(points) - points @ normal) / normal[2]
        return high.reshape(-1, len(ALONG), 2)

    def normal(
        self,
        ground: Ground | Underfoot,
        own: Foot,
        phase: float,
        place: Float[Array, " 3"],
        ahead: Float[Array, " 2"],
        goal: Float[Array, " 2"] | None,
    ) -> Float[Array, " 3"]:
        """Return the normal of the sole: as it stands, or on the way from there to its landing.

        Args:
            ground: The ground.
            own: The foot.
            phase: Of the gait [s].
            place: Of the ankle [m].
            ahead: Where the foot points, over the ground.
            goal: Where it lands; None if nobody knows [m].
        """
        if own.stands:
            ahead = ahead / max(hypot(*ahead), 1e-6)
            self._normal, self._shift = self.under(ground, place[:2], ahead), np.zeros(2)
            return self._normal
        if goal is None:
            return self._normal
        lasts = max(own.touchdown - own.lifted, 1e-3)
        part = min(max((phase - own.lifted) / lasts, 0.0), 1.0)
        normal = (1.0 - part) * self._normal + part * self.under(ground, goal, AXIS)
        return normal / np.linalg.norm(normal)

    def under(
        self, ground: Ground | Underfoot, place: Float[Array, " 2"], ahead: Float[Array, " 2"]
    ) -> Float[Array, " 3"]:
        """Return the normal of a sole that lies at a place.

        It rests on what is highest under heel and ball; sideways it follows the ground a little.

        Args:
            ground: The ground.
            place: Of the ankle [m].
            ahead: Where the foot points, of length one.
        """
        high = self.heights(ground, place[None], ahead)[0]
        top = high.max(axis=1)
        pitch = float(top[2] - top[0]) / (self.leg * (ALONG[2] - ALONG[0]))
        roll = float((high[:, 0] - high[:, 1]).mean()) / (2.0 * self.leg * ACROSS)
        pitch, roll = min(max(pitch, -PITCHED), PITCHED), min(max(roll, -ROLLED), ROLLED)
        x, y = ahead.tolist()
        normal = np.array([-pitch * x + roll * y, -pitch * y - roll * x, 1.0])
        return normal / np.linalg.norm(normal)

    def shift(
        self,
        ground: Ground | Underfoot,
        place: Float[Array, " 2"],
        other: Float[Array, " 2"],
        left: float,
    ) -> Float[Array, " 2"]:
        """Return how far from a place the foot is to land, to stand well [m].

        Args:
            ground: The ground.
            place: Where balance wants it [m].
            other: The other foot [m].
            left: In how much time it lands [s].
        """
        if left < SETTLED:
            return self._shift
        tried = np.vstack([self._tried, self._shift])
        high = self.heights(ground, place + tried, AXIS)
        roll = np.abs(high[:, :, 0] - high[:, :, 1]).max(axis=1) / (2.0 * self.leg * ACROSS)
        top = high.max(axis=2)
        pitch = np.abs(top[:, 2] - top[:, 0]) / (self.leg * (ALONG[2] - ALONG[0]))
        cost = (roll / ROLL) ** 2 + (pitch / PITCH) ** 2
        cost[:-1] += self._cost
        cost[-1] += ((self._shift / (self.leg * np.array(SHIFT))) ** 2).sum() - STAYS
        apart = self.left * (place[1] - other[1])
        inward = apart + self.left * tried[:, 1] < min(INWARD * self.leg, apart)
        cost[inward] = np.inf
        self._shift = tried[int(np.argmin(cost))]
        return self._shift

"""How a foot swings: the recorded path, rescaled to the predicted step, over what is in its way."""

from collections.abc import Callable
from math import hypot, sqrt

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.control.gait.phase import Foot

CLEAR = 0.012
"""A foot is swung so much higher than recorded, in the middle: recorded toes pass the ground within
millimetres, and soles of fitted feet are somewhat in it [leg lengths]."""
LIFT = 0.02
"""And so much by how fast it is led elsewhere [s]."""
HEEL, TOE, NEAR = -0.08, 0.24, 0.03
"""How far a sole reaches behind the ankle and ahead of it; so far the ground about the ankle tells
how it is tilted [leg lengths]."""
ALONG = np.linspace(0.0, 1.0, 9)
"""Where the ground on the way is looked at."""
UP, DOWN = 0.35, 0.7
"""Parts of a swing by which a foot is over what is in its way, and until which it stays there."""
STRAIGHT = 0.99
"""A swinging leg is stretched so far, hip to ankle [leg lengths]."""

Level = Callable[[Array], float]
"""Height of the ground at a place [m]."""


class SwingPath:
    """The way of one foot from where it stood to where it lands.

    Args:
        leg: Length of the leg [m].
    """

    def __init__(self, leg: float):
        self.leg = leg
        self._start = np.zeros(3)
        self._goal, self._high = np.full(2, np.inf), 0.0

    def stands(self, place: Float[Array, " 3"]) -> None:
        """Keep where the foot stands [m]."""
        self._start, self._goal = np.array(place), np.full(2, np.inf)

    def height(
        self,
        own: Foot,
        phase: float,
        rate: float,
        place: Float[Array, " 3"],
        pace: Float[Array, " 3"],
        goal: Float[Array, " 2"] | None,
        level: Level,
        normal: Float[Array, " 3"] | None,
    ) -> tuple[float, float]:
        """Return how much higher than recorded the foot is to be, and how fast it rises so.

        Args:
            own: The foot.
            phase: Of the gait [s].
            rate: Of the phase.
            place: Where the foot is to be [m]; its height does not count.
            pace: How fast it is to go there [m/s].
            goal: Where it lands; None if nobody knows.
            level: Height of the ground at a place [m].
            normal: Of the ground where it is a plane; else None.
        """
        clear = CLEAR * self.leg + LIFT * min(hypot(*own.swing.velocity), 2.0)
        lasts = max(own.touchdown - own.lifted, 1e-3)
        u = min(max((phase - own.lifted) / lasts, 0.0), 1.0)
        rises = 4.0 * clear * (1.0 - 2.0 * u) * rate / lasts
        high = 4.0 * clear * u * (1.0 - u)
        if normal is not None or goal is None:
            if normal is not None:
                rises -= float(normal[:2] @ pace[:2]) / float(normal[2])
            return high + level(place), rises
        start = level(self._start)
        end = level(np.append(goal, 0.0))
        if np.abs(goal - self._goal).max() > 0.02 * self.leg:
            self._goal, self._high = goal.copy(), self._in_the_way(goal, start, end, level)
        way = goal - self._start[:2]
        far = max(float(way @ way), 1e-6)
        part = min(max(float((place[:2] - self._start[:2]) @ way) / far, 0.0), 1.0)
        if 0.0 < part < 1.0:
            rises += (end - start) * float(pace[:2] @ way) / far
        up, down = u / UP, (1.0 - u) / (1.0 - DOWN)
        over = min(up, down, 1.0)
        if over < 1.0:
            speed = (1.0 / UP if up < down else -1.0 / (1.0 - DOWN)) * rate / lasts
            rises += self._high * 6.0 * over * (1.0 - over) * speed
        high += self._high * over * over * (3.0 - 2.0 * over)
        return high + start + (end - start) * part, rises

    def _in_the_way(self, goal: Array, start: float, end: float, level: Level) -> float:
        """Return how much the ground is above the straight way, under any part of the sole [m]."""
        way = goal - self._start[:2]
        ahead = way / max(float(np.linalg.norm(way)), 1e-6) * self.leg
        most = 0.0
        for part in ALONG:
            line = start + (end - start) * part
            at = [self._start[:2] + part * way + x * ahead for x in (HEEL, 0.0, 0.5 * TOE, TOE)]
            under = [level(np.append(place, 0.0)) for place in (at if part > 0.0 else at[1:2])]
            most = max(most, under[min(1, len(under) - 1)] - line)
            if len(under) == 1:
                continue
            # A foot is tilted as the ground is; on a slope toes are no lower over it than heels.
            near = [level(np.append(at[1] + x * ahead, 0.0)) for x in (-NEAR, NEAR)]
            tilt = (near[1] - near[0]) / (2 * NEAR)
            for x, high in zip((HEEL, 0.5 * TOE, TOE), (under[0], *under[2:]), strict=True):
                most = max(most, high - tilt * x - line)
        return most


def in_reach(
    leg: float,
    hip: Float[Array, " 3"],
    goes: Float[Array, " 3"],
    place: Float[Array, " 3"],
    pace: Float[Array, " 3"],
    push: Float[Array, " 3"],
) -> None:
    """Keep what is wanted of a swinging foot where its leg reaches, at the height it is to have.

    A foot that is led farther pulls the body along with a straight leg, and hangs over the ground
    meanwhile: landing places run away from it. It rather comes down nearer to the hip.

    Args:
        leg: Length of the leg [m].
        hip: Its hip [m].
        goes: Velocity of the hip [m/s].
        place: Where the foot is to be [m]; changed.
        pace: How fast it is to go there [m/s]; changed.
        push: Its acceleration [m/s²]; changed.
    """
    away = place - hip
    down = min(abs(float(away[2])), STRAIGHT * leg)
    far, most = hypot(*away[:2]), sqrt((STRAIGHT * leg) ** 2 - down**2)
    if far <= most:
        return
    out = away[:2] / far
    place[:2] -= (far - most) * out
    pace[:2] -= max(float((pace - goes)[:2] @ out), 0.0) * out
    push[:2] -= max(float(push[:2] @ out), 0.0) * out

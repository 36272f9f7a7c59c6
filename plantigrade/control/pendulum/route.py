"""Where a walk leads, and how fast: what is wanted at a time and a place.

Ways are in the plane of the ground from where the walk starts: x ahead, y to the left.
"""

from dataclasses import dataclass
from math import atan2, cos, hypot, inf, pi, remainder, sin, sqrt, tan

import numpy as np

from plantigrade.control.pendulum.manner import DEEPEST
from plantigrade.control.pendulum.turn import FASTEST as TURNING
from plantigrade.errors import ParameterError
from plantigrade.options import shown

AHEAD = 1.0
"""So far ahead of a walker on a way the place is that is walked to [m]: less turns sooner."""
RADIUS, CUT = 2.0, 0.8
"""Of the turn at a corner; the corner is cut by no more than this [m]."""
BRAKES = 0.8
"""So far before the last point a walk begins to come to a stand [m]."""
BESIDE = 0.2
"""A walk is so slow for a corner that its turn leads no farther beyond the way than this [m]."""
ALONG = 0.2
"""Who looks farther than this towards their way comes back to it [rad]."""
SLOWING, SLOWEST = 0.3, 0.3
"""So much slower it is made before a corner [m/s²], and no slower than this: it would stand, and
who stands does not turn [m/s]."""
FASTEST = 5.0
"""Speeds above this are no walk [m/s]."""
TURNS, MOST, FAR = 10, 1000, 10_000.0
"""Of a path: turns of a bearing, number of points, and how far they are [m], at most."""
SAME = 0.01
"""Points of a path nearer to the one before than this are one with it [m]."""
PATH = (
    "write straight; bearing:DEG, or bearing:0,90@5 to turn left by 90° after 5 s; or "
    "points:X,Y/X,Y such as points:4,0/4,3 in metres, x ahead and y to the left"
)
STOOP = "write CM, or 0,25@3,0@6 to walk with the head 25 cm lower from 3 to 6 s"
SPEED = "write M/S, or 1.2,0.8@5,0@10 to go slower after 5 s and stand after 10 s"


@dataclass(frozen=True)
class Timed:
    """A number that is another one from times on.

    Attributes:
        times: From when, rising, the first zero [s].
        values: What it is from then on.
    """

    times: tuple[float, ...]
    values: tuple[float, ...]

    def at(self, time: float) -> float:
        """Return what it is at a time [s]."""
        i = int(np.searchsorted(self.times, time + 1e-9, side="right"))
        return self.values[max(i - 1, 0)]

    @classmethod
    def written(cls, word: str, what: str, form: str) -> "Timed":
        """Return the numbers of a word, ``VALUE[,VALUE@SECONDS…]``.

        Raises:
            ParameterError: If it is none; ``what`` it should be, and its ``form``.
        """
        times, values = [], []
        try:
            for i, part in enumerate(word.split(",")):
                value, at, when = part.partition("@")
                values.append(float(value))
                times.append(float(when) if at else 0.0)
                if bool(at) == (i == 0) and times[-1] != 0.0 or (i > 0 and not at):
                    raise ValueError
        except ValueError:
            raise ParameterError(f"{word!r} is no {what}: {form}") from None
        if not np.isfinite([*times, *values]).all():
            raise ParameterError(f"{word!r} is no {what}: {form}")
        if (np.diff([0.0, *times]) < 0.0).any():
            raise ParameterError(f"{word!r} is no {what}, as its times must rise: {form}")
        return cls(tuple(times), tuple(values))


def speeds(word: str) -> Timed:
    """Return the speeds of a word [m/s].

    Raises:
        ParameterError: If it is none.

    Example:
        >>> speeds("1.2,0.8@5").at(6.0)
        0.8
    """
    found = Timed.written(word, "speed", SPEED)
    if not all(0.0 <= v <= FASTEST for v in found.values):
        raise ParameterError(f"{word!r}: a speed must be 0–{FASTEST:g} m/s")
    return found


def depths(word: str) -> Timed:
    """Return the stoops of a word [cm].

    Raises:
        ParameterError: If it is none.
    """
    found = Timed.written(word, "stoop", STOOP)
    if not all(0.0 <= d <= DEEPEST for d in found.values):
        raise ParameterError(f"{word!r}: a stoop must be 0–{DEEPEST:g} cm")
    return found


@dataclass(frozen=True)
class Bearings:
    """Walk in a direction, straight on.

    Attributes:
        angles: In which, to the left of the first one [deg].
    """

    angles: Timed

    @property
    def times(self) -> tuple[float, ...]:
        """When it changes, the start with it [s]."""
        return self.angles.times

    def bearing(self, time: float, x: float, y: float) -> float | None:
        """Return where to go [rad]."""
        return self.angles.at(time) * pi / 180.0

    def fastest(self, x: float, y: float, heading: float) -> float:
        """Return infinity: a bearing is turned to at any speed."""
        return inf

    def off(self, x: float, y: float) -> float | None:
        """Return None: a bearing is kept from wherever a walk has turned to it."""
        return None


class Points:
    """Walk from point to point, and no further than to the last.

    The way between two points is followed, not only the next point: who was pushed aside comes back
    to it.

    Args:
        places: The points [m]; one where the walk is already is left out.

    Attributes:
        places: The start and the points [m].
        times: When it changes, whatever the walk does: never but at the start [s].
    """

    def __init__(self, places: tuple[tuple[float, float], ...]):
        kept = [(0.0, 0.0)]
        for place in places:
            if hypot(place[0] - kept[-1][0], place[1] - kept[-1][1]) >= SAME:
                kept.append(place)
        self.places, self.times = tuple(kept), (0.0,)
        self._leg = 1
        ways = np.diff(np.array(self.places), axis=0)
        self._angle = [atan2(y, x) for x, y in ways.tolist()]
        self._length = [hypot(x, y) for x, y in ways.tolist()]
        turns = [toward(b, a) for a, b in zip(self._angle, self._angle[1:], strict=False)]
        half = [0.5 * min(pair) for pair in zip(self._length, self._length[1:], strict=False)]
        # Where turns begin: as far before a corner as a circle needs; and how fast they may be.
        self._early = [min(_early(abs(t)), h) for t, h in zip(turns, half, strict=True)]
        early = zip(self._early, turns, strict=True)
        self._speed = [_turned_at(e * sin(abs(t)), t) for e, t in early]
        self._early.append(min(BRAKES, 0.5 * self._length[-1]) if self._length else 0.0)
        self._speed.append(0.0)
        for i in reversed(range(len(turns))):  # there is less way than it takes to be slower
            later = sqrt(self._speed[i + 1] ** 2 + 2.0 * SLOWING * self._length[i + 1])
            self._speed[i] = min(self._speed[i], later)

    @property
    def passed(self) -> int:
        """How many points were passed; at the last it stands."""
        return self._leg - 1

    def off(self, x: float, y: float) -> float | None:
        """Return how far a place is from the way up to the point that is walked to [m]."""
        ways = zip(self.places, self.places[1 : self._leg + 1], strict=False)
        return min((_beside((x, y), *way) for way in ways), default=hypot(x, y))

    def bearing(self, time: float, x: float, y: float) -> float | None:
        """Return where to go [rad]; None at the end.

        Asked in order of time: a point that was passed is not walked to again.
        """
        if time <= 0.0:
            self._leg = 1
        while self._leg < len(self.places):
            i = self._leg - 1
            ahead, _ = self._along(x, y)
            if ahead < self._length[i] - self._early[i]:
                (x0, y0), way, to = self.places[i], self._angle[i], ahead + AHEAD
                return atan2(y0 + to * sin(way) - y, x0 + to * cos(way) - x)
            self._leg += 1
        return None

    def fastest(self, x: float, y: float, heading: float) -> float:
        r"""Return how fast to go, lest corners and points behind are missed [m/s].

        Who turns by :math:`\theta` to the direction of the way on a circle of radius :math:`r`
        comes :math:`r (1 - \cos \theta)` nearer to it, or beyond it. Who walks along it aside by
        :math:`a` comes back to it, on two such circles, in :math:`2 \sqrt{a r}`. To be asked
        after :meth:`bearing`.

        Args:
            x: Where it is [m].
            y: Likewise.
            heading: Which way it walks [rad].
        """
        i = self._leg - 1
        if i >= len(self._length):
            return 0.0
        ahead, left = self._along(x, y)
        turn = toward(self._angle[i], heading)
        inside = left if turn > 0.0 else -left
        rest = self._length[i] - ahead - (self._early[i] if i < len(self._length) - 1 else 0.0)
        rest = max(rest, 0.0)
        least = min(_turned_at(inside, turn), sqrt(self._speed[i] ** 2 + 2.0 * SLOWING * rest))
        aside = abs(left) - BESIDE
        if aside <= 0.0 or (inside > 0.0 and abs(turn) > ALONG):
            return least
        return min(least, max(0.25 * TURNING * rest**2 / aside, SLOWEST))

    def _along(self, x: float, y: float) -> tuple[float, float]:
        """Return how far a place is along the way that is walked, and to the left of it [m]."""
        (x0, y0), way = self.places[self._leg - 1], self._angle[self._leg - 1]
        c, s = cos(way), sin(way)
        return c * (x - x0) + s * (y - y0), c * (y - y0) - s * (x - x0)


def _early(turn: float) -> float:
    """Return how far before a corner a circle begins that touches both ways [m]."""
    if turn < SAME:
        return 0.0
    return min(RADIUS * tan(min(0.5 * turn, 1.5)), CUT / tan(0.25 * turn))


def _turned_at(inside: float, turn: float) -> float:
    """Return the speed at which a turn leads onto a way [m/s].

    Args:
        inside: How far inside of the way it begins [m].
        turn: By how much it turns [rad].
    """
    nearer = 1.0 - cos(turn)
    return max(TURNING * (max(inside, 0.0) + BESIDE) / max(nearer, 1e-9), SLOWEST)


Way = Bearings | Points


def _beside(
    place: tuple[float, float], start: tuple[float, float], end: tuple[float, float]
) -> float:
    """Return how far a place is from the line between two others [m]."""
    (x, y), (x0, y0), (x1, y1) = place, start, end
    dx, dy = x1 - x0, y1 - y0
    part = ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy)
    part = min(max(part, 0.0), 1.0)
    return hypot(x - x0 - part * dx, y - y0 - part * dy)


def path(word: str) -> Way:
    """Return the way of a word.

    Raises:
        ParameterError: If it is none.

    Example:
        >>> path("points:4,0/4,3").places[-1]
        (4.0, 3.0)
    """
    kind, _, rest = word.partition(":")
    if word == "straight":
        return Bearings(Timed((0.0,), (0.0,)))
    if kind == "bearing":
        found = Timed.written(rest, "bearing", PATH)
        if not all(abs(angle) <= 360.0 * TURNS for angle in found.values):
            raise ParameterError(f"{word!r}: a bearing is at most {360 * TURNS} degrees")
        return Bearings(found)
    if kind == "points":
        try:
            places = [tuple(float(c) for c in each.split(",")) for each in rest.split("/")]
        except ValueError:
            places = []
        if not places or any(len(p) != 2 or not np.isfinite(p).all() for p in places):
            raise ParameterError(f"{word!r} is no path: {PATH}")
        if len(places) > MOST or any(max(abs(p[0]), abs(p[1])) > FAR for p in places):
            raise ParameterError(
                f"{shown(word)}: a path has at most {MOST} points, none farther than {FAR:g} m"
            )
        return Points(tuple((p[0], p[1]) for p in places))
    raise ParameterError(f"{word!r} is no path: {PATH}")


def toward(bearing: float, angle: float) -> float:
    """Return by how much to turn left to look in a direction, the shorter way [rad]."""
    return remainder(bearing - angle, 2.0 * pi)

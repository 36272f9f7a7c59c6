"""Commands of a walk over time: speed, lowering of the head, and the path.

Paths are in the plane of the ground from where the walk starts: x ahead, y to the left.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from math import atan2, cos, hypot, inf, pi, remainder, sin, sqrt

import numpy as np

from plantigrade.control.pendulum.crouch import CrouchSettings
from plantigrade.control.pendulum.speed import SpeedSettings
from plantigrade.control.pendulum.turn import TurnSettings
from plantigrade.errors import ParameterError
from plantigrade.options import shown

PATH = (
    "write straight; bearing:DEG, or bearing:0,90@5 to turn left by 90° after 5 s; or "
    "points:X,Y/X,Y such as points:4,0/4,3 in metres, x ahead and y to the left"
)
STOOP = "write CM, or 0,25@3,0@6 to walk with the head 25 cm lower from 3 to 6 s"
SPEED = "write M/S, or 1.2,0.8@5,0@10 to go slower after 5 s and stand after 10 s"
MAX_POINTS, MAX_COORDINATE = 1000, 10_000.0  # [m] of a path that is accepted
RESOLUTION = 0.01  # [m] distance below which points are one


@dataclass(frozen=True, kw_only=True)
class PathSettings:
    """How a path through points is followed."""

    turn: TurnSettings = TurnSettings()
    """How the walk turns."""
    look_ahead: float = 1.0
    """Distance along the path of the point that is headed for, and from a point at which the walk
    leaves for the next, or begins to stop at the last [m]. Chosen (±20 %: below 2 %)."""
    tolerated_deviation: float = 0.2
    """Distance from the path that turns may lead to: corners are walked so slowly [m]. Chosen (±20
    %: below 2 %)."""
    deceleration: float = SpeedSettings.acceleration
    """Loss of speed before a corner [m/s²]; as of any change of speed."""

    @property
    def min_speed(self) -> float:
        """Least speed before a corner [m/s]: a person who stands does not turn.

        With it a circle at the greatest rate has the distance of the point that is headed for.
        """
        return self.turn.max_rate * self.look_ahead

    def turn_speed(self, inside: float, angle: float) -> float:
        """Return the speed at which a turn leads onto a leg of the path [m/s].

        Args:
            inside: How far inside of it the turn begins [m].
            angle: Angle of the turn [rad].
        """
        nearer = 1.0 - cos(angle)
        room = max(inside, 0.0) + self.tolerated_deviation
        return max(self.turn.max_rate * room / max(nearer, 1e-9), self.min_speed)


@dataclass(frozen=True)
class Timed:
    """A number that changes at times."""

    times: tuple[float, ...]  #: When it changes, rising, the first zero [s]
    values: tuple[float, ...]  #: Its value from then on

    def at(self, time: float) -> float:
        """Return its value at a time [s]."""
        i = int(np.searchsorted(self.times, time + 1e-9, side="right"))
        return self.values[max(i - 1, 0)]

    @classmethod
    def written(cls, word: str, what: str, form: str) -> "Timed":
        """Return the numbers of a word, ``VALUE[,VALUE@SECONDS…]``."""
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


def speeds_of(word: str) -> Timed:
    """Return the speeds of a word [m/s].

    Example:
        >>> speeds_of("1.2,0.8@5").at(6.0)
        0.8
    """
    found = Timed.written(word, "speed", SPEED)
    if min(found.values) < 0.0:
        raise ParameterError(f"{word!r}: a speed must not be negative")
    return found


def depths_of(word: str) -> Timed:
    """Return the lowerings of the head of a word [cm]."""
    found, deepest = Timed.written(word, "stoop", STOOP), CrouchSettings.max_depth_cm
    if not all(0.0 <= d <= deepest for d in found.values):
        raise ParameterError(f"{word!r}: a stoop must be 0–{deepest:g} cm")
    return found


class Path(ABC):
    """A path to be walked.

    Attributes:
        times: When it changes, whatever the walk does, the start with it [s].
    """

    times: tuple[float, ...] = (0.0,)

    def started(self, settings: PathSettings) -> "Path":
        """Return the path for a walk that starts."""
        return self

    @abstractmethod
    def heading(self, time: float, x: float, y: float) -> float | None:
        """Return the desired heading [rad]; None at the end."""

    def speed_limit(self, x: float, y: float, heading: float) -> float:
        """Return the greatest speed that keeps to the path [m/s]."""
        return inf

    def deviation(self, x: float, y: float) -> float | None:
        """Return the distance from the path [m]; None if it goes on from wherever it is."""
        return None


class Bearings(Path):
    """A path in a direction, straight on.

    Args:
        angles: The direction, to the left of the first one [deg].
    """

    def __init__(self, angles: Timed):
        self.angles, self.times = angles, angles.times

    def heading(self, time: float, x: float, y: float) -> float | None:
        """Return the desired heading [rad]."""
        return self.angles.at(time) * pi / 180.0


class Waypoints(Path):
    """A path from point to point that ends at the last.

    The leg between two points is followed, not only the next point: a person who was pushed aside
    comes back to it.

    Args:
        points: The points [m]; one where the walk is already is left out.

    Attributes:
        points: The start and the points [m].
    """

    def __init__(
        self, points: tuple[tuple[float, float], ...], settings: PathSettings | None = None
    ):
        self.settings = own = settings or PathSettings()
        kept = [(0.0, 0.0)]
        for point in points:
            if hypot(point[0] - kept[-1][0], point[1] - kept[-1][1]) >= RESOLUTION:
                kept.append(point)
        self.points = tuple(kept)
        self._leg = 1
        legs = np.diff(np.array(self.points), axis=0)
        self._angle = [atan2(y, x) for x, y in legs.tolist()]
        self._length = [hypot(x, y) for x, y in legs.tolist()]
        turns = [angle_to(b, a) for a, b in zip(self._angle, self._angle[1:], strict=False)]
        # How far before corners turns begin, and how fast they may be.
        pairs = zip(self._length, self._length[1:], strict=False)
        self._early = [min(own.look_ahead, 0.5 * min(pair)) for pair in pairs]
        early = zip(self._early, turns, strict=True)
        self._speed = [own.turn_speed(e * sin(abs(t)), t) for e, t in early]
        self._early.append(min(own.look_ahead, 0.5 * self._length[-1]) if self._length else 0.0)
        self._speed.append(0.0)
        for i in reversed(range(len(turns))):  # a leg may be too short to slow down on
            before = sqrt(self._speed[i + 1] ** 2 + 2.0 * own.deceleration * self._length[i + 1])
            self._speed[i] = min(self._speed[i], before)

    def started(self, settings: PathSettings) -> "Waypoints":
        """Return the path for a walk that starts."""
        return Waypoints(self.points, settings)

    @property
    def passed(self) -> int:
        """Number of points that were passed; at the last the walk stops."""
        return self._leg - 1

    def deviation(self, x: float, y: float) -> float | None:
        """Return the distance from the path up to the point that is headed for [m]."""
        legs = zip(self.points, self.points[1 : self._leg + 1], strict=False)
        return min((_distance((x, y), *leg) for leg in legs), default=hypot(x, y))

    def heading(self, time: float, x: float, y: float) -> float | None:
        """Return the desired heading [rad]; None at the end.

        To be called in order of time: a point that was passed is no goal any more.
        """
        while self._leg < len(self.points):
            i = self._leg - 1
            ahead, _ = self._along(x, y)
            if ahead < self._length[i] - self._early[i]:
                (x0, y0), angle = self.points[i], self._angle[i]
                to = ahead + self.settings.look_ahead
                return atan2(y0 + to * sin(angle) - y, x0 + to * cos(angle) - x)
            self._leg += 1
        return None

    def speed_limit(self, x: float, y: float, heading: float) -> float:
        r"""Return the greatest speed that misses neither corners nor points behind [m/s].

        A turn by :math:`\theta` to the direction of a leg on a circle of radius :math:`r` leads
        :math:`r (1 - \cos \theta)` nearer to it, or beyond it. Two such circles lead a walk along
        the leg, at a distance :math:`a`, back to it in :math:`2 \sqrt{a r}`. To be called after
        :meth:`heading`.

        Args:
            x: Position [m].
            y: Likewise.
            heading: Heading of the walk [rad].
        """
        own, i = self.settings, self._leg - 1
        if i >= len(self._length):
            return 0.0
        ahead, left = self._along(x, y)
        turn = angle_to(self._angle[i], heading)
        inside = left if turn > 0.0 else -left
        rest = self._length[i] - ahead - (self._early[i] if i < len(self._length) - 1 else 0.0)
        rest = max(rest, 0.0)
        corner = sqrt(self._speed[i] ** 2 + 2.0 * own.deceleration * rest)
        limit = min(own.turn_speed(inside, turn), corner)
        aside = abs(left) - own.tolerated_deviation
        if aside <= 0.0 or inside > 0.0:
            return limit
        return min(limit, max(0.25 * own.turn.max_rate * rest**2 / aside, own.min_speed))

    def _along(self, x: float, y: float) -> tuple[float, float]:
        """Return how far a position is along the present leg, and to the left of it [m]."""
        (x0, y0), angle = self.points[self._leg - 1], self._angle[self._leg - 1]
        c, s = cos(angle), sin(angle)
        return c * (x - x0) + s * (y - y0), c * (y - y0) - s * (x - x0)


def _distance(
    point: tuple[float, float], start: tuple[float, float], end: tuple[float, float]
) -> float:
    """Return the distance of a point from the line between two others [m]."""
    (x, y), (x0, y0), (x1, y1) = point, start, end
    dx, dy = x1 - x0, y1 - y0
    part = ((x - x0) * dx + (y - y0) * dy) / (dx * dx + dy * dy)
    part = min(max(part, 0.0), 1.0)
    return hypot(x - x0 - part * dx, y - y0 - part * dy)


def path_of(word: str) -> Path:
    """Return the path of a word.

    Example:
        >>> path_of("points:4,0/4,3").points[-1]
        (4.0, 3.0)
    """
    kind, _, rest = word.partition(":")
    if word == "straight":
        return Bearings(Timed((0.0,), (0.0,)))
    if kind == "bearing":
        return Bearings(Timed.written(rest, "bearing", PATH))
    if kind == "points":
        try:
            points = [tuple(float(c) for c in each.split(",")) for each in rest.split("/")]
        except ValueError:
            points = []
        if not points or any(len(p) != 2 or not np.isfinite(p).all() for p in points):
            raise ParameterError(f"{word!r} is no path: {PATH}")
        far = max(max(abs(x), abs(y)) for x, y in points)
        if len(points) > MAX_POINTS or far > MAX_COORDINATE:
            raise ParameterError(
                f"{shown(word)}: a path has at most {MAX_POINTS} points, none farther than "
                f"{MAX_COORDINATE:g} m"
            )
        return Waypoints(tuple((p[0], p[1]) for p in points))
    raise ParameterError(f"{word!r} is no path: {PATH}")


def angle_to(heading: float, other: float) -> float:
    """Return the angle from another heading to one, to the left, the shorter way [rad]."""
    return remainder(heading - other, 2.0 * pi)

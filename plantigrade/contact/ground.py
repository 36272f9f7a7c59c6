r"""Ground and seats, shared by optimiser, check, exported model and world.

The ground is the surface :math:`n^T x = h(x)`: a plane that may slope along x, with steps, relief
and seats. Its axes are x uphill, y to the left and z along the normal.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import FRICTION
from plantigrade.contact.plan import SAME_HEIGHT, UP, ContactPlan
from plantigrade.contact.relief import Bump, HeightField
from plantigrade.contact.site import CHAIR_PART
from plantigrade.contact.surface_motion import SurfaceMotion
from plantigrade.errors import ParameterError

MAX_COORDINATE = 1e6  #: Maximum coordinate of anything on the ground [m]
FOOT_BEHIND_ANKLE = 0.13
"""Distance from the ankle of a footprint back to the edge of its tread [m]; heel plus 5 cm."""
FOOT_AHEAD_OF_ANKLE = 0.27
"""Distance from the ankle of a footprint forward to the edge of its tread [m]; toes plus 5 cm."""

MIN_CAP_HEIGHT = 1e-6
"""Minimum height of a bump's surface above its centre, relative to its radius [1]; avoids an
infinite slope at the rim."""


def _fixed(numbers: list) -> Array:
    """Return a read-only array."""
    array = np.array(numbers, dtype=float)
    array.flags.writeable = False
    return array


@dataclass(frozen=True)
class GroundStep:
    """A change of ground height at an edge across x."""

    x: float  #: Position of the edge [m]
    height: float  #: Height of the ground beyond the edge, along the normal [m]


@dataclass(frozen=True)
class Seat:
    """A flat surface that supports a part of the body other than a foot: a seat, a wall."""

    site: str  #: Name of the supported contact site
    position: tuple[float, float, float]  #: Position of the contact, world [m]
    normal: tuple[float, float, float] = UP  #: Where the surface faces, of length one
    friction: float | None = None  #: Coefficient of friction; the ground's if None
    #: Name of the board that carries it, drawn as one; level seats of a height share one if empty
    board: str = ""
    #: Stiffness of its cushion and the flesh on it in a simulation [N/m]; hard if None
    stiffness: float | None = None
    #: How it moves, in axes of the ground and in addition to it; it rests there if None
    motion: SurfaceMotion | None = None


@dataclass(frozen=True)
class Ground:
    """The ground under the feet.

    Attributes:
        height: Height along the normal, before the first step [m].
        slope: Inclination along x, positive uphill [rad].
        steps: Edges, in order of x.
        seats: Other supports of the body.
        friction: Coefficient of friction.
        bumps: Spherical caps.
        field: Relief.
        motion: How all of it moves, in its axes; it rests if None. Places are those before.

    Raises:
        ParameterError: If the friction is negative, the slope is 90° or more, the steps are out of
            order, or a position is not finite.
    """

    height: float = 0.0
    slope: float = 0.0
    steps: tuple[GroundStep, ...] = ()
    seats: tuple[Seat, ...] = ()
    friction: float = FRICTION
    bumps: tuple[Bump, ...] = ()
    field: HeightField | None = None
    motion: SurfaceMotion | None = None

    def __post_init__(self):
        places = [*((s.x, s.height) for s in self.steps), *(s.position for s in self.seats)]
        places += [(*b.centre, b.radius) for b in self.bumps]
        places += [(*self.field.corner, *self.field.spacing)] if self.field else []
        if not all(abs(x) <= MAX_COORDINATE for place in ((self.height,), *places) for x in place):
            raise ParameterError(f"every place of the ground must be within {MAX_COORDINATE:g} m")
        if not 0.0 <= self.friction < np.inf:
            raise ParameterError(f"friction={self.friction} must be zero or more")
        if not abs(self.slope) < np.pi / 2:
            raise ParameterError(f"slope={self.slope} [rad] must be less than a right angle")
        if any(b.x < a.x for a, b in zip(self.steps[:-1], self.steps[1:], strict=True)):
            raise ParameterError("the steps of the ground must be in order of x")

    @classmethod
    def of_plan(cls, plan: ContactPlan, friction: float = FRICTION) -> "Ground":
        """Return the ground of a plan along x, with steps between footprints of different height.

        Edges are close to the higher footprint. An obstacle is a step up and one down.
        """
        prints = sorted((s.footprint.position[0], s.footprint.position[2]) for s in plan.stances)
        steps = []
        for (x0, z0), (x1, z1) in zip(prints[:-1], prints[1:], strict=True):
            if abs(z1 - z0) > SAME_HEIGHT:
                steps.append(
                    GroundStep(x1 - FOOT_BEHIND_ANKLE if z1 > z0 else x0 + FOOT_AHEAD_OF_ANKLE, z1)
                )
        height = prints[0][1] if prints else 0.0
        for block in plan.obstacles:
            near, far = block.x - block.width / 2, block.x + block.width / 2
            level = cls(height, steps=tuple(steps)).along(np.array(block.x))
            steps += [GroundStep(near, float(level) + block.height), GroundStep(far, float(level))]
            steps.sort(key=lambda step: step.x)
        ground = cls(height, plan.slope, tuple(steps), friction=friction, motion=plan.motion)
        seats = {
            s.site.name: Seat(
                s.site.name, ground.turned(s.position), ground.turned(s.normal), s.friction,
                "" if s.site.part == CHAIR_PART else s.site.name,
                motion=s.motion,
            )
            for s in plan.supports
            if not plan.on_ground(s)
        }  # fmt: skip
        return replace(ground, seats=tuple(seats.values()))

    def turned(self, vector: tuple[float, float, float]) -> tuple[float, float, float]:
        """Return a vector in axes of the ground as one in those of the world."""
        if not self.slope:
            return vector
        x, y, z = map(float, self.to_world @ vector)
        return x, y, z

    @property
    def moves(self) -> bool:
        """Whether the ground or a seat moves."""
        return self.motion is not None or bool(self.moving_seats)

    @property
    def moving_seats(self) -> tuple[tuple[Seat, ...], ...]:
        """Seats that move, by themselves or with the ground; those that move as one together."""
        found: dict[SurfaceMotion | None, tuple[Seat, ...]] = {}
        for seat in self.seats:
            if self._motions(seat):
                found[seat.motion] = (*found.get(seat.motion, ()), seat)
        return tuple(found.values())

    @property
    def at_rest(self) -> "Ground":
        """The ground where it begins, without the seats that move."""
        moving = {seat for group in self.moving_seats for seat in group}
        still = tuple(seat for seat in self.seats if seat not in moving)
        return replace(self, seats=still, motion=None)

    def shifts(self, times: Float[Array, " n"]) -> Float[Array, "n k 3"]:
        """Return how far each of :attr:`moving_seats` is from its place at times, world [m]."""
        shifts = [self.displacement(times, seats[0]) for seats in self.moving_seats]
        return np.stack([np.zeros((len(times), 3)), *shifts], axis=1)[:, 1:]

    def displacement(
        self, times: Float[Array, " n"], seat: Seat | None = None
    ) -> Float[Array, "n 3"]:
        """Return how far the ground, or a seat on it, is from its place at times, world [m]."""
        return self._summed([m.displacement(times) for m in self._motions(seat)], len(times))

    def velocity(self, times: Float[Array, " n"], seat: Seat | None = None) -> Float[Array, "n 3"]:
        """Return how fast the ground, or a seat on it, moves at times, world [m/s]."""
        return self._summed([m.velocity(times) for m in self._motions(seat)], len(times))

    def _motions(self, seat: Seat | None) -> list[SurfaceMotion]:
        """Return the motions that add up to that of the ground, or of a seat."""
        both = (self.motion, None if seat is None else seat.motion)
        return [motion for motion in both if motion is not None]

    def _summed(self, vectors: list[Array], n: int) -> Float[Array, "n 3"]:
        """Return the sum of vectors in axes of the ground, world."""
        return np.sum([np.zeros((n, 3)), *vectors], axis=0) @ self.to_world.T

    @cached_property
    def normal(self) -> Float[Array, " 3"]:
        """Unit normal of the plane, world; read-only."""
        return _fixed([-np.sin(self.slope), 0.0, np.cos(self.slope)])

    @cached_property
    def to_world(self) -> Float[Array, "3 3"]:
        """Rotation from the axes of the ground (x uphill, z along the normal) to world."""
        c, s = np.cos(self.slope), np.sin(self.slope)
        return _fixed([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])

    def along(
        self, x: Float[Array, "..."], margin: Float[Array, "..."] | float = 0.0
    ) -> Float[Array, "..."]:
        """Return the maximum height within a margin of positions along x, axes of the ground [m].

        Treads must be at least as wide as the margin.
        """
        if not self.steps:
            return np.full(np.shape(x - margin), float(self.height))
        heights = np.array([self.height, *(step.height for step in self.steps)])
        edges = np.array([step.x for step in self.steps])
        near = (x - margin, x + margin)
        return np.asarray(np.maximum(*(heights[np.searchsorted(edges, each)] for each in near)))

    def passed(self, path: Float[Array, "*n 3"]) -> Float[Array, "*n"]:
        """Return the minimum clearance of a path between each of its points and the next [m].

        At an edge the clearance is that above the higher side.

        Args:
            path: Positions, the first axis in order of time, axes of the ground [m].
        """
        x, z = path[..., 0], path[..., 2]
        level = self.along(x)
        height = z - level
        higher = np.maximum(level[:-1], level[1:])
        for step in self.steps:
            before, after = step.x - x[:-1], step.x - x[1:]
            across = before * after < 0
            part = before / np.where(across, before - after, 1.0)
            there = z[:-1] + part * np.diff(z, axis=0) - higher
            height[:-1] = np.where(across, np.minimum(height[:-1], there), height[:-1])
        return height

    def under(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n"]:
        """Return the height of the ground along its normal at world points [m]."""
        if not (self.steps or self.uneven):
            return np.full(points.shape[:-1], float(self.height))
        x = points @ self.to_world
        level = self.along(x[..., 0])
        return np.asarray(np.maximum(level, self._relief_and_slope(x)[0])) if self.uneven else level

    def gap(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n"]:
        """Return the height of world points above the ground, along its normal [m]."""
        return points @ self.normal - self.under(points)

    def above(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n 3"]:
        """Return world points in axes of the ground, with z the height above it [m]."""
        x = points @ self.to_world
        x[..., 2] -= self.under(points)
        return x

    def normal_at(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n 3"]:
        """Return the unit normals of the ground at world points, world."""
        normal = np.empty(points.shape)
        normal[:] = self.normal
        if not self.uneven:
            return normal
        x = points @ self.to_world
        height, slope = self._relief_and_slope(x)
        tilted = np.ones(points.shape)
        tilted[..., :2] = -slope
        tilted /= np.sqrt((tilted * tilted).sum(axis=-1, keepdims=True))
        tilted = tilted @ self.to_world.T
        if not self.steps:  # relief lies nowhere below the ground
            return tilted
        return np.where((height >= self.along(x[..., 0]))[..., None], tilted, normal)

    @property
    def level(self) -> bool:
        """Whether it is a level plane that rests, without seats."""
        return self == Ground(self.height, friction=self.friction)

    @property
    def uneven(self) -> bool:
        """Whether the ground has relief, which changes its normal."""
        return bool(self.bumps) or self.field is not None

    def _relief_and_slope(
        self, x: Float[Array, "*n 3"]
    ) -> tuple[Float[Array, "*n"], Float[Array, "*n 2"]]:
        """Return height [m] and slope along x and y of bumps and field."""
        z, slope = np.full(x.shape[:-1], float(self.height)), np.zeros((*x.shape[:-1], 2))
        if self.field is not None:
            rise, slope = self.field.rise(x[..., 0], x[..., 1])
            z += rise
        for bump in self.bumps:
            off = x[..., :2] - np.array(bump.centre[:2])
            inside = bump.radius**2 - (off * off).sum(axis=-1)
            tall = np.sqrt(np.maximum(inside, (MIN_CAP_HEIGHT * bump.radius) ** 2))
            above = (inside > 0.0) & (bump.centre[2] + tall > z)
            z = np.where(above, bump.centre[2] + tall, z)
            slope = np.where(above[..., None], off / -tall[..., None], slope)
        return z, slope

    def to_dict(self) -> dict[str, Any]:
        """Return a JSON-serialisable description; see :meth:`from_dict`."""
        return asdict(self)

    @classmethod
    def from_dict(cls, description: Mapping[str, Any]) -> "Ground":
        """Return the ground of a description.

        Raises:
            ParameterError: If an entry is missing or has the wrong type.
        """
        try:
            d = dict(description)
            d["steps"] = tuple(
                GroundStep(float(s["x"]), float(s["height"])) for s in d.get("steps", ())
            )
            d["seats"] = tuple(
                Seat(
                    str(s["site"]),
                    _numbers(s["position"], 3),
                    _numbers(s.get("normal", UP), 3),
                    None if s.get("friction") is None else float(s["friction"]),
                    str(s.get("board", "")),
                    None if s.get("stiffness") is None else float(s["stiffness"]),
                    _motion(s.get("motion")),
                )
                for s in d.get("seats", ())
            )
            d["bumps"] = tuple(
                Bump(_numbers(b["centre"], 3), float(b["radius"])) for b in d.get("bumps", ())
            )
            if (field := d.get("field")) is not None:
                heights = tuple(_numbers(row) for row in field["heights"])
                corner, spacing = (_numbers(field[name], 2) for name in ("corner", "spacing"))
                d["field"] = HeightField(corner, spacing, heights)
            d["motion"] = _motion(d.get("motion"))
            d |= {k: float(d[k]) for k in ("height", "slope", "friction") if k in d}
            return cls(**d)
        except (TypeError, ValueError, KeyError, OverflowError) as error:
            if isinstance(error, ParameterError):
                raise
            raise ParameterError(f"not a description of a ground: {error}") from error


LEVEL_GROUND = Ground()  #: The plane z = 0


def _motion(description: Mapping[str, Any] | None) -> SurfaceMotion | None:
    """Return the motion of a surface, by its description."""
    if description is None:
        return None
    return SurfaceMotion(tuple(_numbers(row) for row in description["rows"]))


def _numbers(values: Any, n: int | None = None) -> Any:
    """Return values as a tuple of ``n`` floats, any number if ``n`` is absent."""
    out = tuple(float(x) for x in values)
    if n is not None and len(out) != n:
        raise ValueError(f"{len(out)} numbers where {n} are needed")
    return out

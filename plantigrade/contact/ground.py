r"""The ground and seats under a body, shared by optimiser, check, exported model and world.

Ground is all :math:`x` with :math:`n^T x = h(x)`: a plane that may rise along x, with steps across
it, relief upon it, and seats above it. Its axes are x uphill, y to the left and z off the ground.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import FRICTION
from plantigrade.contact.plan import ContactPlan
from plantigrade.errors import ParameterError

FARTHEST = 1e6
"""Largest coordinate of anything on the ground [m]."""
HEEL, TOE = 0.13, 0.27
"""From the ankle of a footprint back and forth to an edge below it [m]: a foot and 5 cm."""

STEEP = 1e-6
"""Height of a sphere over its widest circle, by its radius, below which it is a wall."""


def _fixed(numbers: list) -> Array:
    """Return an array that nobody can change."""
    array = np.array(numbers, dtype=float)
    array.flags.writeable = False
    return array


@dataclass(frozen=True)
class Step:
    """An edge across x beyond which the ground has another height.

    Attributes:
        x: Where the edge is [m].
        height: Height of the ground beyond it, along the normal [m].
    """

    x: float
    height: float


@dataclass(frozen=True)
class Seat:
    """A level surface that supports a part of the body other than a foot.

    Attributes:
        site: Name of the contact site that rests on it.
        position: Where that site touches it, world [m].
    """

    site: str
    position: tuple[float, float, float]


@dataclass(frozen=True)
class Bump:
    """A sphere in the ground with a cap above it.

    Attributes:
        centre: Its centre, axes of the ground [m].
        radius: Its radius [m].
    """

    centre: tuple[float, float, float]
    radius: float


@dataclass(frozen=True)
class HeightField:
    """Relief on a rectangle of the ground, bilinear between the points of a grid.

    Attributes:
        corner: Where the first point is: smallest x and y, axes of the ground [m].
        spacing: Distance of the points along x and along y [m].
        heights: Height of the points above :attr:`Ground.height`, not negative; one row for every
            y, each along x [m].
    """

    corner: tuple[float, float]
    spacing: tuple[float, float]
    heights: tuple[tuple[float, ...], ...]

    def __post_init__(self):
        """Refuse what is no height field."""
        z = np.array(self.heights, dtype=float) if len(set(map(len, self.heights))) == 1 else None
        if z is None or min(z.shape) < 2 or not (np.isfinite(z).all() and (z >= 0).all()):
            raise ParameterError(
                "a height field needs two or more rows of as many heights [m], none below zero"
            )
        if not min(self.spacing) > 0:
            raise ParameterError(f"spacing={self.spacing} [m] of a height field must be positive")

    @cached_property
    def _grid(self) -> Float[Array, "n_y n_x"]:
        return np.array(self.heights)

    @property
    def size(self) -> tuple[float, float]:
        """Extent along x and y [m]."""
        nx, ny = len(self.heights[0]) - 1, len(self.heights) - 1
        return nx * self.spacing[0], ny * self.spacing[1]

    def at(self, x: Float[Array, "*n"], y: Float[Array, "*n"]) -> Float[Array, "*n"]:
        """Return the height at places; zero beside the rectangle [m]."""
        return self.rise(x, y)[0]

    def rise(
        self, x: Float[Array, "*n"], y: Float[Array, "*n"]
    ) -> tuple[Float[Array, "*n"], Float[Array, "*n 2"]]:
        """Return the height at places [m], and how it rises along x and y; zero beside it."""
        z = self._grid
        u = (x - self.corner[0]) / self.spacing[0]
        v = (y - self.corner[1]) / self.spacing[1]
        inside = (u >= 0) & (u <= z.shape[1] - 1) & (v >= 0) & (v <= z.shape[0] - 1)
        i = np.minimum(np.maximum(np.floor(u).astype(int), 0), z.shape[1] - 2)
        j = np.minimum(np.maximum(np.floor(v).astype(int), 0), z.shape[0] - 2)
        a, b = u - i, v - j
        low = (1 - a) * z[j, i] + a * z[j, i + 1]
        high = (1 - a) * z[j + 1, i] + a * z[j + 1, i + 1]
        along = (1 - b) * (z[j, i + 1] - z[j, i]) + b * (z[j + 1, i + 1] - z[j + 1, i])
        slope = np.stack([along / self.spacing[0], (high - low) / self.spacing[1]], axis=-1)
        return np.where(inside, (1 - b) * low + b * high, 0.0), inside[..., None] * slope


@dataclass(frozen=True)
class Ground:
    """The ground under the feet.

    Attributes:
        height: Height along the normal, before the first step [m].
        slope: How far the ground rises along x [rad].
        steps: Edges, in order of x.
        seats: What else carries the body.
        friction: Coefficient of friction.
        bumps: Spheres that stand out of it.
        field: Relief upon it.

    Raises:
        ParameterError: If the friction is negative, the slope no slope, the steps out of order, or
            a place is not finite.
    """

    height: float = 0.0
    slope: float = 0.0
    steps: tuple[Step, ...] = ()
    seats: tuple[Seat, ...] = ()
    friction: float = FRICTION
    bumps: tuple[Bump, ...] = ()
    field: HeightField | None = None

    def __post_init__(self):
        """Refuse what is no ground."""
        places = [*((s.x, s.height) for s in self.steps), *(s.position for s in self.seats)]
        places += [(*b.centre, b.radius) for b in self.bumps]
        places += [(*self.field.corner, *self.field.spacing)] if self.field else []
        if not all(abs(x) <= FARTHEST for place in ((self.height,), *places) for x in place):
            raise ParameterError(f"every place of the ground must be within {FARTHEST:g} m")
        if not 0.0 <= self.friction < np.inf:
            raise ParameterError(f"friction={self.friction} must be zero or more")
        if not abs(self.slope) < np.pi / 2:
            raise ParameterError(f"slope={self.slope} [rad] must be less than a right angle")
        if any(b.x < a.x for a, b in zip(self.steps[:-1], self.steps[1:], strict=True)):
            raise ParameterError("the steps of the ground must be in order of x")

    @classmethod
    def of_plan(cls, plan: ContactPlan, friction: float = FRICTION) -> "Ground":
        """Return the ground of a plan along x: steps where footprints differ in height, its seats.

        Edges are close to the higher of two footprints.
        """
        prints = sorted((s.footprint.position[0], s.footprint.position[2]) for s in plan.stances)
        steps = []
        for (x0, z0), (x1, z1) in zip(prints[:-1], prints[1:], strict=True):
            if abs(z1 - z0) > 1e-9:
                steps.append(Step(x1 - HEEL if z1 > z0 else x0 + TOE, z1))
        seats = tuple({s.site.name: Seat(s.site.name, s.position) for s in plan.supports}.values())
        height = prints[0][1] if prints else 0.0
        return cls(height, plan.slope, tuple(steps), seats, friction)

    @cached_property
    def normal(self) -> Float[Array, " 3"]:
        """Direction in which the ground pushes, world; read only."""
        return _fixed([-np.sin(self.slope), 0.0, np.cos(self.slope)])

    @cached_property
    def to_world(self) -> Float[Array, "3 3"]:
        """Rotation from the axes of the ground (x uphill, z off the ground) to world; read only."""
        c, s = np.cos(self.slope), np.sin(self.slope)
        return _fixed([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])

    def along(
        self, x: Float[Array, "..."], margin: Float[Array, "..."] | float = 0.0
    ) -> Float[Array, "..."]:
        """Return the highest point within a margin of places along x, axes of the ground [m].

        Treads are no narrower than a foot.
        """
        if not self.steps:
            return np.full(np.shape(x - margin), float(self.height))
        heights = np.array([self.height, *(step.height for step in self.steps)])
        edges = np.array([step.x for step in self.steps])
        near = (x - margin, x + margin)
        return np.asarray(np.maximum(*(heights[np.searchsorted(edges, each)] for each in near)))

    def passed(self, path: Float[Array, "*n 3"]) -> Float[Array, "*n"]:
        """Return how high places on a path are above the ground until the next one [m].

        A path that crosses an edge between two places is above the higher side there.

        Args:
            path: Places at one time after the other, the first axis, in axes of the ground [m].
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
        """Return the height of the ground along its normal, under world points [m]."""
        if not (self.steps or self.uneven):
            return np.full(points.shape[:-1], float(self.height))
        x = points @ self.to_world
        level = self.along(x[..., 0])
        return np.asarray(np.maximum(level, self._relief(x))) if self.uneven else level

    def above(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n 3"]:
        """Return world points in axes of the ground, z their height above it [m]."""
        x = points @ self.to_world
        x[..., 2] -= self.under(points)
        return x

    def normal_at(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n 3"]:
        """Return in which direction the ground under world points pushes, world."""
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
    def uneven(self) -> bool:
        """Whether there is relief, so that it pushes in another direction everywhere."""
        return bool(self.bumps) or self.field is not None

    def _relief(self, x: Float[Array, "*n 3"]) -> Float[Array, "*n"]:
        """Return the height of bumps and field, no steps among them, axes of the ground [m]."""
        return self._relief_and_slope(x)[0]

    def _relief_and_slope(
        self, x: Float[Array, "*n 3"]
    ) -> tuple[Float[Array, "*n"], Float[Array, "*n 2"]]:
        """Return the same, and how it rises along x and y."""
        z, slope = np.full(x.shape[:-1], float(self.height)), np.zeros((*x.shape[:-1], 2))
        if self.field is not None:
            rise, slope = self.field.rise(x[..., 0], x[..., 1])
            z += rise
        for bump in self.bumps:
            off = x[..., :2] - np.array(bump.centre[:2])
            inside = bump.radius**2 - (off * off).sum(axis=-1)
            tall = np.sqrt(np.maximum(inside, (STEEP * bump.radius) ** 2))
            above = (inside > 0.0) & (bump.centre[2] + tall > z)
            z = np.where(above, bump.centre[2] + tall, z)
            slope = np.where(above[..., None], off / -tall[..., None], slope)
        return z, slope

    def to_dict(self) -> dict[str, Any]:
        """Return the ground as JSON can hold it; see :meth:`from_dict`."""
        return asdict(self)

    @classmethod
    def from_dict(cls, description: Mapping[str, Any]) -> "Ground":
        """Return the ground of a description.

        Raises:
            ParameterError: If something is missing or of another kind.
        """
        try:
            d = dict(description)
            d["steps"] = tuple(Step(float(s["x"]), float(s["height"])) for s in d.get("steps", ()))
            d["seats"] = tuple(
                Seat(str(s["site"]), _numbers(s["position"], 3)) for s in d.get("seats", ())
            )
            d["bumps"] = tuple(
                Bump(_numbers(b["centre"], 3), float(b["radius"])) for b in d.get("bumps", ())
            )
            if (field := d.get("field")) is not None:
                heights = tuple(_numbers(row) for row in field["heights"])
                corner, spacing = (_numbers(field[name], 2) for name in ("corner", "spacing"))
                d["field"] = HeightField(corner, spacing, heights)
            d |= {k: float(d[k]) for k in ("height", "slope", "friction") if k in d}
            return cls(**d)
        except (TypeError, ValueError, KeyError, OverflowError) as error:
            if isinstance(error, ParameterError):
                raise
            raise ParameterError(f"not a description of a ground: {error}") from error


LEVEL_GROUND = Ground()
"""The plane z = 0."""


def _numbers(values: Any, n: int | None = None) -> Any:
    """Return numbers as a tuple of floats; refuse another number of them than ``n``."""
    out = tuple(float(x) for x in values)
    if n is not None and len(out) != n:
        raise ValueError(f"{len(out)} numbers where {n} are needed")
    return out

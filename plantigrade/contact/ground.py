r"""What a body stands and sits on: one ground for optimiser, checker, exported model and world.

Ground is all :math:`x` with :math:`n^T x = h(x)`: a plane that may rise along x, with steps across
it, and seats above it.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import FRICTION
from plantigrade.contact.plan import ContactPlan
from plantigrade.errors import ParameterError

HEEL, TOE = 0.13, 0.27
"""From the ankle of a footprint back and forth to an edge below it [m]: a foot and 5 cm."""


@dataclass(frozen=True)
class Step:
    """An edge across x: from it on the ground has another height.

    Attributes:
        x: Where the edge is [m].
        height: Height of the ground beyond it, along the normal [m].
    """

    x: float
    height: float


@dataclass(frozen=True)
class Seat:
    """A level surface that carries a place of the body which is no foot.

    Attributes:
        site: Name of the contact site that rests on it.
        position: Where that site touches it, world [m].
    """

    site: str
    position: tuple[float, float, float]


@dataclass(frozen=True)
class Ground:
    """What feet stand on.

    Attributes:
        height: Height along the normal, before the first step [m].
        slope: How far the ground rises along x [rad].
        steps: Edges, in order of x.
        seats: What else carries the body.
        friction: Coefficient of friction.

    Raises:
        ParameterError: If the friction is negative, the slope no slope, or the steps out of order.
    """

    height: float = 0.0
    slope: float = 0.0
    steps: tuple[Step, ...] = ()
    seats: tuple[Seat, ...] = ()
    friction: float = FRICTION

    def __post_init__(self):
        """Refuse what is no ground."""
        if not self.friction >= 0.0:
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
        seats = tuple(Seat(s.site.name, s.position) for s in plan.supports)
        height = prints[0][1] if prints else 0.0
        return cls(height, plan.slope, tuple(steps), seats, friction)

    @property
    def normal(self) -> Float[Array, " 3"]:
        """Direction in which the ground pushes, world."""
        return np.array([-np.sin(self.slope), 0.0, np.cos(self.slope)])

    @property
    def to_world(self) -> Float[Array, "3 3"]:
        """Rotation from the axes of the ground (x uphill, z off the ground) to world axes."""
        c, s = np.cos(self.slope), np.sin(self.slope)
        return np.array([[c, 0.0, -s], [0.0, 1.0, 0.0], [s, 0.0, c]])

    def along(
        self, x: Float[Array, "..."], margin: Float[Array, "..."] | float = 0.0
    ) -> Float[Array, "..."]:
        """Return the highest point within a margin of places along x, axes of the ground [m].

        Treads are no narrower than a foot.
        """
        heights = np.array([self.height, *(step.height for step in self.steps)])
        edges = np.array([step.x for step in self.steps])
        near = (x - margin, x + margin)
        return np.maximum(*(heights[np.searchsorted(edges, each)] for each in near))

    def under(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n"]:
        """Return the height of the ground along its normal, under world points [m]."""
        return self.along((points @ self.to_world)[..., 0])

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
                Seat(str(s["site"]), tuple(float(x) for x in s["position"]))  # type: ignore[arg-type]
                for s in d.get("seats", ())
            )
            return cls(**d | {k: float(d[k]) for k in ("height", "slope", "friction") if k in d})
        except (TypeError, ValueError, KeyError, OverflowError) as error:
            if isinstance(error, ParameterError):
                raise
            raise ParameterError(f"not a description of a ground: {error}") from error

"""Points of contact of a body, and the friction pyramids of the ground there."""

from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.constants import FRICTION
from plantigrade.kinematics.rigid_points import RigidPoints

N_EDGES = 4
"""Edges of a friction pyramid."""
FORCE_UNIT = 0.1
"""Body weights per unit of a share of an edge: of the size of joint accelerations."""
_CORNER = 2 * np.pi * np.arange(N_EDGES) / N_EDGES


def _no_places() -> Array:
    return np.zeros((0, 3))


@dataclass(frozen=True, eq=False)
class Touching:
    """Points at which the body touches.

    Attributes:
        body: Index of the body of each point.
        place: Its position, world [m].
        normal: Normal of the ground there, world.
        friction: Coefficient of friction.
        along: Direction over the ground in which a pyramid has a corner, from x to y [rad]. Along
            its corners a pyramid has the whole friction, half way between them 0.71 of it.
    """

    body: Int[Array, " k"] = field(default_factory=lambda: np.zeros(0, dtype=int))
    place: Float[Array, "k 3"] = field(default_factory=_no_places)
    normal: Float[Array, "k 3"] = field(default_factory=_no_places)
    friction: float = FRICTION
    along: float = np.pi / N_EDGES

    def __len__(self) -> int:
        return len(self.body)

    def edges(self) -> Float[Array, "k 3 n_edges"]:
        """Return the edges of the friction pyramids: one part along the normal."""
        n = self.normal
        if len(n) and (n == n[0]).all():
            edges = np.empty((len(n), 3, N_EDGES))
            edges[:] = _level(tuple(n[0].tolist()), self.friction, self.along)
            return edges
        return _pyramids(n, self.friction, self.along)


def level_pyramid(friction: float) -> Float[Array, "3 n_edges"]:
    """Return the edges of the pyramid of level ground, one part up."""
    return _level((0.0, 0.0, 1.0), friction, np.pi / N_EDGES)[0]


def _pyramids(n: Float[Array, "k 3"], friction: float, along: float) -> Float[Array, "k 3 n_edges"]:
    """Return the edges of pyramids about normals."""
    corner = _CORNER + along
    aside = friction * np.array([np.cos(corner), np.sin(corner)])
    # two directions across any normal (Duff et al., 2017)
    sign = np.where(n[:, 2] < 0, -1.0, 1.0)
    level = n[:, :2].copy()
    level[:, 0] *= sign
    rise = level @ aside
    edges = np.empty((len(n), 3, N_EDGES))
    edges[:, :2] = n[:, :2, None] * (1.0 - rise / (sign + n[:, 2])[:, None])[:, None]
    edges[:, 0] += aside[0]
    edges[:, 1] += sign[:, None] * aside[1]
    edges[:, 2] = n[:, 2, None] - rise
    return edges


@lru_cache(maxsize=8)
def _level(
    normal: tuple[float, float, float], friction: float, along: float
) -> Float[Array, "1 3 n_edges"]:
    """Return the pyramid of level ground, which is everywhere the same."""
    return _pyramids(np.array([normal]), friction, along)


def wrenches(points: RigidPoints, edges: Float[Array, "k 3 n_edges"]) -> Float[Array, "d m"]:
    """Return the wrenches of forces along edges on the bodies of their points.

    Six rows for each body, moments about its origin first; as many columns for each point
    as it has edges.
    """
    k, bodies = len(points), len(points.body_velocity)
    whole = np.zeros((bodies, 6, k, edges.shape[2]))
    pushed = np.matmul(points.lever.transpose(0, 2, 1), edges)
    whole[points.owner, :, np.arange(k)] = pushed
    return whole.reshape(6 * bodies, k * edges.shape[2])

"""Relief of the ground: bumps, and heights on a grid."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError


@dataclass(frozen=True)
class Bump:
    """A spherical cap on the ground."""

    centre: tuple[float, float, float]  #: Centre of the sphere, axes of the ground [m]
    radius: float  #: Radius of the sphere [m]


@dataclass(frozen=True)
class HeightField:
    """Relief on a rectangle of the ground, bilinear between grid points."""

    #: Position of the first point (smallest x and y), axes of the ground [m]
    corner: tuple[float, float]
    spacing: tuple[float, float]  #: Grid spacing along x and y [m]
    #: Height of the points above :attr:`Ground.height`, not negative; one row per y, each along x
    #: [m]
    heights: tuple[tuple[float, ...], ...]

    def __post_init__(self):
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
        """Return the height at positions; zero outside the rectangle [m]."""
        return self.rise(x, y)[0]

    def rise(
        self, x: Float[Array, "*n"], y: Float[Array, "*n"]
    ) -> tuple[Float[Array, "*n"], Float[Array, "*n 2"]]:
        """Return height [m] and slope along x and y at positions; zero outside the rectangle."""
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

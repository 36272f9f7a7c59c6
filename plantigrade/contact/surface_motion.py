"""Motion of a surface that carries the body: where it is, how fast it moves and accelerates."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError

ROW_LENGTHS = (4, 7, 10)
"""Numbers of a row: time and displacement, then velocity, then acceleration."""


@dataclass(frozen=True)
class SurfaceMotion:
    """How a surface moves along, without turning.

    Each row is a time [s], the displacement from the place of the surface [m] and, if given, its
    velocity [m/s] and acceleration [m/s²]: 4, 7 or 10 numbers. What is not given is zero. From row
    to row the motion is the polynomial of fifth degree that has them all, from rest to rest that of
    least jerk [Flash1985]_; before the first row and after the last one it continues with
    the acceleration of that row. Position, velocity and acceleration are continuous.

    Example:
        >>> SurfaceMotion(((0.0, 0.0, 0.0, 0.0), (2.0, 0.0, 0.3, 0.0))).displacement(
        ...     np.array([1.0, 5.0])
        ... ).tolist()
        [[0.0, 0.15, 0.0], [0.0, 0.3, 0.0]]
    """

    rows: tuple[tuple[float, ...], ...]  #: Time, displacement, velocity and acceleration

    def __post_init__(self):
        if not self.rows or any(len(row) not in ROW_LENGTHS for row in self.rows):
            raise ParameterError(
                "a motion consists of rows with a time, a displacement of 3 numbers and optionally "
                "velocity and acceleration of 3 numbers each: [[0.5, 0, 0, 0], [2.0, 0, 0.2, 0]]"
            )
        if not np.all(np.isfinite(np.concatenate([np.array(row) for row in self.rows]))):
            raise ParameterError("a motion consists of finite numbers")
        for one, two in pairwise(self.rows):
            if not one[0] < two[0]:
                raise ParameterError(
                    f"the times of a motion must increase: {two[0]:g} s comes after {one[0]:g} s"
                )

    def displacement(self, times: Float[Array, " n"]) -> Float[Array, "n 3"]:
        """Return the displacement at times [m]."""
        late, (x, v, a) = self._edges(times)
        return x + late * v + late**2 / 2 * a

    def velocity(self, times: Float[Array, " n"]) -> Float[Array, "n 3"]:
        """Return the velocity at times [m/s]."""
        late, (_, v, a) = self._edges(times)
        return v + late * a

    def acceleration(self, times: Float[Array, " n"]) -> Float[Array, "n 3"]:
        """Return the acceleration at times [m/s²]."""
        return self._edges(times)[1][2]

    def _edges(self, times: Float[Array, " n"]) -> tuple[Array, tuple[Array, Array, Array]]:
        """Return how far times are outside the rows, and the motion at the nearest time inside."""
        inside = np.clip(times, self.rows[0][0], self.rows[-1][0])
        x, v, a = (curve(inside) for curve in self._curves)
        return (times - inside)[:, None], (x, v, a)

    @cached_property
    def _curves(self):
        """Displacement, velocity and acceleration as functions of a time within the rows."""
        from scipy.interpolate import BPoly

        table = np.array([(*row, *(0.0,) * (ROW_LENGTHS[-1] - len(row))) for row in self.rows])
        if len(table) == 1:
            return [
                lambda times, x=table[0, i : i + 3]: np.tile(x, (len(times), 1)) for i in (1, 4, 7)
            ]
        place = BPoly.from_derivatives(table[:, 0], table[:, 1:].reshape(-1, 3, 3))
        return [place, place.derivative(), place.derivative(2)]

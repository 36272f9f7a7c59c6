"""One level of a hierarchical quadratic program: equations and inequalities of one priority."""

from dataclasses import dataclass
from math import isfinite

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError

BOUNDS = "lower and upper bounds must be two vectors of one length, not crossed"


@dataclass  # not frozen, which costs a microsecond each time, and a tick makes many
class Level:
    r"""Rows of one priority: :math:`l \le A x \le u`.

    Attributes:
        matrix: :math:`A`.
        lower: :math:`l`; minus infinity where there is none.
        upper: :math:`u`; infinity where there is none. Equal bounds make an equation.
        name: Its name, for messages.
    """

    matrix: Float[Array, "n_rows n"]
    lower: Float[Array, " n_rows"]
    upper: Float[Array, " n_rows"]
    name: str = ""

    @classmethod
    def equation(cls, matrix, right, name: str = "") -> "Level":
        """Return the level of the equation ``matrix @ x == right``."""
        return cls(matrix, right, right, name)

    def residual(self, x: Float[Array, " n"]) -> Float[Array, " n_rows"]:
        """Return by how much each row is violated at ``x``; signed, zero where it is satisfied."""
        value = self.matrix @ x
        if self.lower is self.upper:
            return value - self.lower
        return np.maximum(value - self.upper, 0.0) + np.minimum(value - self.lower, 0.0)

    def parts(self):
        """Return equations (matrix, right), and inequalities (matrix, low, high) or None."""
        matrix, low, high = self.matrix, self.lower, self.upper
        if low is high:
            return (matrix, low), None
        equal = low == high
        rest = ~equal
        return (matrix[equal], low[equal]), (matrix[rest], low[rest], high[rest])


def check_shapes(levels, lower, upper) -> None:
    """Raise ParameterError unless levels and bounds have shapes that agree."""
    n = len(lower)
    if lower.shape != (n,) or upper.shape != (n,):
        raise ParameterError(BOUNDS)
    for k, level in enumerate(levels):
        m = len(level.lower)
        if level.matrix.shape != (m, n) or level.upper.shape != (m,):
            raise ParameterError(
                f"{level.name or f'level {k}'} has a matrix of shape {level.matrix.shape} and "
                f"bounds of shapes {level.lower.shape} and {level.upper.shape}; {n} unknowns need "
                f"(rows, {n}), (rows,) and (rows,)"
            )


def check_values(levels, lower, upper) -> None:
    """Raise ParameterError if a value is not finite, or bounds cross."""
    if not (lower <= upper).all():
        raise ParameterError(BOUNDS)
    for k, level in enumerate(levels):
        what = level.name or f"level {k}"
        equation = level.lower is level.upper
        finite = isfinite(level.matrix.sum())  # the fastest test of all entries
        if equation:
            finite &= isfinite(level.lower.sum())
        else:
            finite &= not (np.isnan(level.lower).any() or np.isnan(level.upper).any())
        if not finite:
            raise ParameterError(f"{what} holds a value that is not finite")
        if not equation and (level.lower > level.upper).any():
            raise ParameterError(f"{what} has a lower bound above its upper one")

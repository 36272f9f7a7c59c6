"""Array types: shapes in the type, units in the docstring."""

import numpy as np
from jaxtyping import Bool, Float, Int

Array = np.ndarray

__all__ = ["Array", "Bool", "Float", "Int", "root_mean_square", "spread"]


def spread(count: int, most: int) -> Int[Array, " n"]:
    """Return at most ``most`` of ``count`` indices, evenly spread.

    Example:
        >>> spread(10, 4).tolist(), spread(2, 4).tolist()
        ([0, 3, 6, 9], [0, 1])
    """
    return np.unique(np.linspace(0, count - 1, most).astype(int))


def root_mean_square(values: Array) -> float:
    """Return the root mean square of the numbers that are known; NaN if there are none."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")

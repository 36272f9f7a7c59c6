"""Array types: shapes in the type, units in the docstring."""

import numpy as np
from jaxtyping import Bool, Float, Int

Array = np.ndarray

__all__ = ["Array", "Bool", "Float", "Int", "root_mean_square"]


def root_mean_square(values: Array) -> float:
    """Return the root mean square of the numbers that are known; NaN if there are none."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else float("nan")

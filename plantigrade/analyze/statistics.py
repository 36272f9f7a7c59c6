"""Mean of curves, and differences between two curves."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError


def rmse(a: Float[Array, " *shape"], b: Float[Array, " *same"]) -> float:
    """Return the RMS difference over the samples that both have; NaN if there are none.

    Example:
        >>> rmse(np.array([0.0, 0.0, np.nan]), np.array([3.0, 4.0, 9.0]))
        3.5355339059327378
    """
    x, y = _shared(a, b)
    return float(np.sqrt(np.mean((x - y) ** 2))) if len(x) else float("nan")


def rmse_offset_removed(a: Float[Array, " *shape"], b: Float[Array, " *same"]) -> float:
    """Return the RMS difference after removing the mean difference.

    It compares shapes if two conventions differ by a constant, such as the neutral pose of a joint.
    """
    x, y = _shared(a, b)
    return float(np.std(x - y)) if len(x) else float("nan")


def mean_difference(a: Float[Array, " *shape"], b: Float[Array, " *same"]) -> float:
    """Return the mean of ``a - b`` over the samples that both have."""
    x, y = _shared(a, b)
    return float(np.mean(x - y)) if len(x) else float("nan")


def correlation(a: Float[Array, " *shape"], b: Float[Array, " *same"]) -> float:
    """Return Pearson's r over the samples that both have; NaN if one of them is constant."""
    x, y = _shared(a, b)
    if len(x) < 2:
        return float("nan")
    x, y = x - x.mean(), y - y.mean()
    scale = np.sqrt((x @ x) * (y @ y))
    return float(x @ y / scale) if scale > 0 else float("nan")


def mean_sd(values: Float[Array, "n m"]) -> tuple[Float[Array, " m"], Float[Array, " m"]]:
    """Return mean and standard deviation over rows, NaN left out; NaN where nothing is known."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(known, values, 0.0).sum(axis=0) / count
        spread = np.where(known, values - mean, 0.0) ** 2
        sd = np.sqrt(spread.sum(axis=0) / np.maximum(count - 1, 1))
    return mean, sd


def _shared(a, b):
    x, y = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    if x.shape != y.shape:
        raise ParameterError(f"curves of shapes {x.shape} and {y.shape} cannot be compared")
    known = np.isfinite(x) & np.isfinite(y)
    return x[known], y[known]

"""Agreement of two curves, and the mean of several."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float, root_mean_square
from plantigrade.errors import ParameterError


@dataclass(frozen=True)
class Agreement:
    """Agreement of two curves over the samples that both have; NaN if there are none."""

    rmse: float  #: Root mean square difference, in the unit of the curves
    #: The same without the mean difference: it compares shapes if two conventions differ by a
    #: constant, such as the neutral pose of a joint
    rmse_offset_removed: float
    correlation: float  #: Pearson's r; NaN if one of the curves is constant
    mean_difference: float  #: Mean of the first curve minus that of the second


def compare_curves(a: Float[Array, " *shape"], b: Float[Array, " *same"]) -> Agreement:
    """Return the agreement of two curves.

    Raises:
        ParameterError: If their shapes differ.

    Example:
        >>> compare_curves(np.array([0.0, 0.0, np.nan]), np.array([3.0, 4.0, 9.0])).rmse
        3.5355339059327378
    """
    x, y = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    if x.shape != y.shape:
        raise ParameterError(f"curves of shapes {x.shape} and {y.shape} cannot be compared")
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    if not len(x):
        return Agreement(*4 * [float("nan")])
    difference = x - y
    u, w = x - x.mean(), y - y.mean()
    scale = np.sqrt((u @ u) * (w @ w))
    return Agreement(
        rmse=root_mean_square(difference),
        rmse_offset_removed=float(np.std(difference)),
        correlation=float(u @ w / scale) if scale > 0 else float("nan"),
        mean_difference=float(np.mean(difference)),
    )


def known_mean(values: Iterable[float]) -> float:
    """Return the mean of finite values; NaN if there are none."""
    known = [x for x in values if np.isfinite(x)]
    return float(np.mean(known)) if known else float("nan")


def mean_sd(values: Float[Array, "n m"]) -> tuple[Float[Array, " m"], Float[Array, " m"]]:
    """Return mean and standard deviation over rows, NaN left out; NaN where nothing is known."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(known, values, 0.0).sum(axis=0) / count
        spread = np.where(known, values - mean, 0.0) ** 2
        sd = np.sqrt(spread.sum(axis=0) / np.maximum(count - 1, 1))
    return mean, sd

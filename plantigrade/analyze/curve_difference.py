r"""The difference of two sets of curves over the gait cycle, with a confidence band.

The difference between the means of :math:`n_a` and :math:`n_b` cycles is :math:`d(t)`, with Welch's
standard error :math:`s(t)`. The band :math:`d(t) \pm u\, s(t)` contains the whole true difference
with 95 % confidence: :math:`u` is the height that a smooth random curve of Student's *t* with
:math:`\nu` degrees of freedom exceeds nowhere in the cycle in 95 of 100 cases, by random field
theory as in statistical parametric mapping [Pataky2010]_:

.. math:: P(\max_t |t(t)| > u) \approx 2 \left[ P(t_\nu > u) + R\, \frac{\sqrt{4 \ln 2}}{2 \pi}
    \left( 1 + \frac{u^2}{\nu} \right)^{-(\nu - 1) / 2} \right],

with the length :math:`R` of the cycle in units of the curves' smoothness, from the slopes of the
normalised residuals [Kiebel1999]_. The curves differ wherever the band excludes zero; the number of
instants is accounted for.

Cycles are assumed to be independent samples of one person on one day. Successive strides are
correlated, which makes the band somewhat too narrow, and variation between days or marker
placements is not included: a band that excludes zero shows that two recordings differ, not why.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float

ALPHA = 0.05  # two-sided error probability of the 95 % band
MIN_CYCLES = 3  # Minimum number of cycles for a band


@dataclass(frozen=True)
class CurveDifference:
    """A difference over the gait cycle, second minus first."""

    mean: Float[Array, " n_percent"]  #: Difference of the mean curves
    half: Float[Array, " n_percent"] | None  #: Half-width of the band; None without one

    @property
    def rms(self) -> float:
        """Root mean square over the cycle."""
        return float(np.sqrt(np.nanmean(self.mean**2)))

    @property
    def largest(self) -> float:
        """The largest difference, signed."""
        return float(self.mean[np.nanargmax(np.abs(self.mean))])

    @property
    def beyond(self) -> Bool[Array, " n_percent"]:
        """Percentages at which the band excludes zero; none without a band."""
        if self.half is None:
            return np.zeros(len(self.mean), dtype=bool)
        return np.asarray(np.abs(self.mean) > self.half)


def curve_difference(
    first: Float[Array, "n_first n_percent"],
    second: Float[Array, "n_second n_percent"],
    *,
    exact: tuple[bool, bool] = (False, False),
) -> CurveDifference:
    """Return the difference of two sets of cycles; rows with gaps are omitted.

    Args:
        exact: Whether the cycles of each have no variability, as those of a synthesised motion.
    """
    rows = [each[np.isfinite(each).all(axis=1)] for each in (first, second)]
    if not all(len(each) for each in rows):  # gaps in every cycle
        means = [_mean(each) for each in (first, second)]
        return CurveDifference(means[1] - means[0], None)
    mean = rows[1].mean(axis=0) - rows[0].mean(axis=0)
    scattered = [each for each, known in zip(rows, exact, strict=True) if not known]
    if not scattered or min(map(len, scattered)) < MIN_CYCLES:
        return CurveDifference(mean, None)
    parts = np.array([each.var(axis=0, ddof=1) / len(each) for each in scattered])
    variance = parts.sum(axis=0)
    free = np.array([len(each) - 1 for each in scattered])
    moving = variance > 1e-12 * max(float(variance.max()), 1e-12)
    if not moving.any():
        return CurveDifference(mean, np.zeros_like(mean))
    welch = variance[moving] ** 2 / (parts[:, moving] ** 2 / free[:, None]).sum(axis=0)
    residual = np.concatenate([each - each.mean(axis=0) for each in scattered])
    height = threshold(float(np.median(welch)), resels(residual, moving))
    return CurveDifference(mean, np.where(moving, height * np.sqrt(variance), 0.0))


def resels(residual: Float[Array, "n n_percent"], moving: Bool[Array, " n_percent"]) -> float:
    """Return the length of the cycle in units of the smoothness of curves (FWHM) [Kiebel1999]_."""
    size = np.sqrt((residual**2).sum(axis=0))
    unit = residual / np.where(moving, size, np.inf)
    slope = np.sqrt((np.gradient(unit, axis=1) ** 2).sum(axis=0) / (4 * np.log(2)))
    inside = (
        moving & np.roll(moving, 1) & np.roll(moving, -1)
    )  # excludes boundaries of constant parts
    inside[[0, -1]] = moving[[0, -1]]
    return float(slope[inside].mean() * (inside.sum() - 1)) if inside.sum() > 2 else 0.0


def threshold(freedom: float, length: float, alpha: float = ALPHA) -> float:
    """Return the height that a random curve of *t* exceeds with probability ``alpha``, two-sided.

    Example:
        >>> round(threshold(1e6, 0.0), 2)  # a single number: normal distribution
        1.96
    """
    from scipy.optimize import brentq
    from scipy.stats import t

    density = np.sqrt(4 * np.log(2)) / (2 * np.pi)

    def excess(u: float) -> float:
        crossings = length * density * (1 + u * u / freedom) ** (-(freedom - 1) / 2)
        return 2 * (float(t.sf(u, freedom)) + crossings) - alpha

    root: Any = brentq(excess, 0.0, 1e4) if excess(1e4) < 0 else 1e4
    return float(root)


def _mean(rows: Array) -> Array:
    known = np.isfinite(rows)
    with np.errstate(invalid="ignore"):
        return np.where(known, rows, 0.0).sum(axis=0) / known.sum(axis=0)

r"""The difference of two sets of curves over the gait cycle, with a confidence band.

Of :math:`n_a` and :math:`n_b` cycles the difference of the means is :math:`d(t)`, its standard
error (Welch's) :math:`s(t)`. The band :math:`d(t) \pm u\, s(t)` holds the whole true difference
with 95 % confidence: :math:`u` is the height that a smooth random curve of Student's *t* with
:math:`\nu` degrees of freedom exceeds nowhere in the cycle in 95 of 100 cases, by random field
theory as in statistical parametric mapping [Pataky2010]_:

.. math:: P(\max_t |t(t)| > u) \approx 2 \left[ P(t_\nu > u) + R\, \frac{\sqrt{4 \ln 2}}{2 \pi}
    \left( 1 + \frac{u^2}{\nu} \right)^{-(\nu - 1) / 2} \right],

with the length of the cycle in units of the curves' smoothness :math:`R`, from the slopes of the
normalised residuals [Kiebel1999]_. So where the band leaves zero out, the curves differ there,
however many instants are looked at.

It takes the cycles as independent draws of one person on one day. Strides that follow each other
are alike, so that the band is somewhat too narrow, and another day, or markers placed anew, is not
in it at all: a band that leaves zero out says that these two recordings differ, not why.

References:
    [Pataky2010]_, [Kiebel1999]_.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float

ALPHA = 0.05  # two-sided error probability of the 95 % band
FEWEST = 3
"""Cycles of a gait without which there is no band."""


@dataclass(frozen=True)
class CurveDifference:
    """A difference over the gait cycle, second minus first."""

    mean: Float[Array, " n_percent"]  #: Of the mean curves
    half: Float[Array, " n_percent"] | None  #: Half the width of the band; None without one

    @property
    def rms(self) -> float:
        """Root mean square over the cycle."""
        return float(np.sqrt(np.nanmean(self.mean**2)))

    @property
    def largest(self) -> float:
        """The largest difference, with its sign."""
        return float(self.mean[np.nanargmax(np.abs(self.mean))])

    @property
    def beyond(self) -> Bool[Array, " n_percent"]:
        """Where the band leaves zero out; nowhere without a band."""
        if self.half is None:
            return np.zeros(len(self.mean), dtype=bool)
        return np.asarray(np.abs(self.mean) > self.half)


def curve_difference(
    first: Float[Array, "n_first n_percent"],
    second: Float[Array, "n_second n_percent"],
    *,
    exact: tuple[bool, bool] = (False, False),
) -> CurveDifference:
    """Return the difference of two sets of cycles; rows with gaps are left out.

    Args:
        first: Cycles of the first gait.
        second: Cycles of the second gait.
        exact: Whether the cycles of each are all there is: those of a motion that was made, not
            measured, do not scatter.
    """
    rows = [each[np.isfinite(each).all(axis=1)] for each in (first, second)]
    if not all(len(each) for each in rows):  # gaps in every cycle
        means = [_mean(each) for each in (first, second)]
        return CurveDifference(means[1] - means[0], None)
    mean = rows[1].mean(axis=0) - rows[0].mean(axis=0)
    scattered = [each for each, known in zip(rows, exact, strict=True) if not known]
    if not scattered or min(map(len, scattered)) < FEWEST:
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
    inside = moving & np.roll(moving, 1) & np.roll(moving, -1)  # not where stillness begins
    inside[[0, -1]] = moving[[0, -1]]
    return float(slope[inside].mean() * (inside.sum() - 1)) if inside.sum() > 2 else 0.0


def threshold(freedom: float, length: float, alpha: float = ALPHA) -> float:
    """Return the height that a random curve of *t* exceeds with probability ``alpha``, either way.

    Args:
        freedom: Degrees of freedom.
        length: Of the curve, in resels.
        alpha: Probability.

    Example:
        >>> round(threshold(1e6, 0.0), 2)  # one number: that of the normal distribution
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

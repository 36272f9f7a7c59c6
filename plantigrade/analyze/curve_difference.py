r"""The difference of two sets of curves over the gait cycle, with a band, and of their figures.

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

**Figures** of curves are range, peak and time of the peak. The sampling unit of a test is the trial
where both gaits have at least :data:`MIN_TRIALS`, because consecutive strides of one trial are
similar: a paired *t* test where the gaits are the two sides of the same trials, else Welch's. With
fewer trials it is the cycle (Welch's test). Times of a peak are circular: 98 % and 2 % of the cycle
are 4 % apart.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.analyze.norms import unit_of
from plantigrade.analyze.pooled_gait import ComparedGait
from plantigrade.arrays import Array, Bool, Float
from plantigrade.motion.cycles import PERCENT
from plantigrade.side_names import without_side

ALPHA = 0.05  # two-sided error probability of the 95 % band
MIN_CYCLES = 3  # Minimum number of cycles for a band
MIN_TRIALS = 3
"""Minimum number of trials, or of cycles, of each gait for a test; two have no reliable spread."""
MIN_SPREAD = 1e-6  # below it, in the unit of the figure, values are equal and are not tested
PERIOD = 100.0  # [% of the cycle]


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


def threshold(freedom: float, length: float) -> float:
    """Return the height that a random curve of *t* exceeds with probability ALPHA, two-sided.

    Example:
        >>> round(threshold(1e6, 0.0), 2)  # a single number: normal distribution
        1.96
    """
    from scipy.optimize import brentq
    from scipy.stats import t

    density = np.sqrt(4 * np.log(2)) / (2 * np.pi)

    def excess(u: float) -> float:
        crossings = length * density * (1 + u * u / freedom) ** (-(freedom - 1) / 2)
        return 2 * (float(t.sf(u, freedom)) + crossings) - ALPHA

    root: Any = brentq(excess, 0.0, 1e4) if excess(1e4) < 0 else 1e4
    return float(root)


def _mean(rows: Array) -> Array:
    known = np.isfinite(rows)
    with np.errstate(invalid="ignore"):
        return np.where(known, rows, 0.0).sum(axis=0) / known.sum(axis=0)


@dataclass(frozen=True)
class FigureDifference:
    """One figure of one curve of two gaits."""

    curve: str  #: Name of the curve
    figure: str  #: ``"range"``, ``"peak"`` or ``"time of peak"``
    unit: str  #: Its unit
    first: float  #: Mean of the first gait
    second: float  #: Mean of the second gait
    difference: float  #: Second minus first; for times the shorter way around the cycle
    p: float = float("nan")  #: Two-sided error probability of the test; NaN without one
    test: str = ""  #: ``"paired trials"``, ``"trials"``, ``"cycles"``, or empty without a test


def figure_differences(
    first: ComparedGait, second: ComparedGait, names: Sequence[str]
) -> tuple[FigureDifference, ...]:
    """Return range, peak and time of the peak of every curve in both gaits, with a test."""
    found = []
    for name in names:
        unit = unit_of(without_side(name))
        both = [_whole(gait, name) for gait in (first, second)]
        if not all(len(rows) for rows, _ in both):
            continue
        sign = _direction(np.concatenate([rows for rows, _ in both]), unit)
        figures: tuple[tuple[str, str, Callable[[Array], Array]], ...] = (
            ("range", unit, lambda rows: np.ptp(rows, axis=1)),
            ("peak", unit, lambda rows, s=sign: s * (s * rows).max(axis=1)),
            ("time of peak", "%", lambda rows, s=sign: PERCENT[(s * rows).argmax(axis=1)]),
        )
        for figure, of, take in figures:
            values = [take(rows) for rows, _ in both]
            if figure == "time of peak":
                values = _near_each_other(*values)
            trials = [each for _, each in both]
            p, test = _test(values, trials, paired=bool(first.side and second.side))
            if first.exact or second.exact:
                p, test = float("nan"), ""
            one, other = (float(np.mean(each)) for each in values)
            difference = other - one
            if figure == "time of peak":
                one, other = one % PERIOD, other % PERIOD
            found.append(FigureDifference(name, figure, of, one, other, difference, p, test))
    return tuple(found)


def _whole(gait: ComparedGait, name: str) -> tuple[Array, Array]:
    """Return the complete cycles of a curve, and the trial of each."""
    rows = gait.curves[name]
    whole = np.isfinite(rows).all(axis=1)
    trials = gait.trials.get(name, np.zeros(len(rows), int))
    return rows[whole], trials[whole]


def _direction(rows: Float[Array, "n n_percent"], unit: str) -> float:
    """Return the sign of the peak: positive for angles, that of the larger extreme for loads."""
    if unit == "deg":
        return 1.0
    mean = rows.mean(axis=0)
    return 1.0 if mean.max() >= -mean.min() else -1.0


def _near_each_other(first: Array, second: Array) -> list[Array]:
    """Return times of the cycle [%] as numbers around their common circular mean."""
    turn = 2j * np.pi / PERIOD
    middle = np.angle(np.mean(np.exp(turn * np.concatenate([first, second])))) / turn.imag
    return [middle + (each - middle + PERIOD / 2) % PERIOD - PERIOD / 2 for each in (first, second)]


def _test(values: Sequence[Array], trials: Sequence[Array], *, paired: bool) -> tuple[float, str]:
    """Return the error probability of the difference of two means, and the sampling unit."""
    from scipy.stats import ttest_ind, ttest_rel

    means = [
        {int(k): float(own[of == k].mean()) for k in np.unique(of)}
        for own, of in zip(values, trials, strict=True)
    ]
    shared = sorted(means[0].keys() & means[1].keys())
    if paired and len(shared) >= MIN_TRIALS:
        units = [np.array([each[k] for k in shared]) for each in means]
        if np.ptp(units[1] - units[0]) < MIN_SPREAD:
            return float("nan"), ""
        found: Any = ttest_rel(units[1], units[0])
        return float(found.pvalue), "paired trials"
    by_trial = all(len(each) >= MIN_TRIALS for each in means)
    units = [np.array(list(each.values())) for each in means] if by_trial else list(values)
    if min(map(len, units)) < MIN_TRIALS or min(map(np.ptp, units)) < MIN_SPREAD:
        return float("nan"), ""
    found = ttest_ind(units[1], units[0], equal_var=False)
    return float(found.pvalue), "trials" if by_trial else "cycles"

r"""Figures of curves over the gait cycle (range, peak, time of the peak), and their differences.

The sampling unit of a test is the trial where both gaits have at least :data:`MIN_TRIALS`, because
consecutive strides of one trial are similar: a paired *t* test where the gaits are the two sides of
the same trials, else Welch's. With fewer trials it is the cycle (Welch's test). Times of a peak are
circular: 98 % and 2 % of the cycle are 4 % apart.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.analyze.norms import unit_of
from plantigrade.analyze.pooled_gait import Gait
from plantigrade.arrays import Array, Float, Int
from plantigrade.motion.cycles import PERCENT
from plantigrade.side_names import without_side

MIN_TRIALS = 3
"""Minimum number of trials, or of cycles, of each gait for a test; two have no reliable spread."""
MIN_SPREAD = 1e-6  # below it, in the unit of the figure, values are equal and are not tested
PERIOD = 100.0  # [% of the cycle]


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
    first: Gait, second: Gait, names: Sequence[str]
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


def _whole(gait: Gait, name: str) -> tuple[Array, Array]:
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

    means = [_trial_means(*each) for each in zip(values, trials, strict=True)]
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


def _trial_means(values: Float[Array, " n"], trials: Int[Array, " n"]) -> dict[int, float]:
    return {int(k): float(values[trials == k].mean()) for k in np.unique(trials)}

"""Statistics of several reproduced gaits, as in Table I and Figs. 4 to 7 of [Boukheddimi]_.

The paper compares nine simulated gaits with nine recorded ones: the range of motion (ROM) of twelve
rotations, a paired Student test where the differences pass Shapiro and Wilk's test of normality
(both at 5 %), and curves as mean and standard deviation over the cycle.

A test without a significant difference does not prove equality: with few people, or a large spread,
large differences remain undetected. Each test is therefore shown with the 95 % confidence interval
of the mean difference.

The test assumes independent gaits, one per person.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from plantigrade.analyze.reproduction import ROTATIONS, Comparison
from plantigrade.analyze.statistics import known_mean
from plantigrade.arrays import Array, Float
from plantigrade.data_files import number_table
from plantigrade.errors import ParameterError
from plantigrade.motion.cycles import PERCENT

ALPHA = 0.05  # significance level of both tests, as in the paper
MIN_GAITS = 3  #: Minimum number of gaits for a test


@dataclass(frozen=True)
class PaperRow:
    """One row of the paper's Table I, as printed [whole degrees]."""

    simulated: int  #: Mean ROM of its nine simulated gaits
    reference: int  #: Mean ROM of its nine recorded ones
    difference: int  #: Their difference, without sign
    identical: bool = False  #: Whether it marks the two as significantly identical


PAPER_TABLE = {
    name: PaperRow(int(ours), int(theirs), int(apart), identical=bool(same))
    for name, (ours, theirs, apart, same) in number_table(
        "plantigrade.analyze", "boukheddimi_table1.csv", 4
    ).items()
}
"""Table I of [Boukheddimi]_ by coordinate."""

FIGURES = {
    "hip_flexion_r": "Flexion-extension of the right hip",
    "hip_adduction_r": "Abduction-adduction of the right hip",
    "knee_angle_r": "Flexion-extension of the right knee",
    "subtalar_angle_r": "Eversion-inversion of the right ankle",
}
"""What Figs. 4, 5, 6 and 7 of [Boukheddimi]_ show, by coordinate."""


@dataclass(frozen=True)
class StudyRow:
    """One rotation over all gaits; angles in degrees."""

    label: str  #: As in the paper's Table I
    coordinate: str  #: Coordinate
    simulated: float  #: Mean reproduced ROM
    simulated_sd: float  #: Standard deviation over the gaits; NaN for one
    reference: float  #: Mean recorded ROM
    reference_sd: float  #: Its standard deviation; NaN for one
    difference: float  #: Mean of reproduced minus recorded ROM, signed
    difference_abs: float  #: Mean of its absolute value
    interval: tuple[float, float]  #: 95 % confidence interval of ``difference``; NaN for one gait
    shapiro_p: float | None  #: Shapiro and Wilk's p of the differences; None for fewer than three
    test: str  #: ``"t"`` (paired Student), ``"wilcoxon"`` (where normality is rejected), or empty
    p: float | None  #: p of the test; None without a test
    #: Whether there is no significant difference; None without a test
    identical: bool | None
    rmse: float  #: Mean root mean square difference of the curves
    correlation: float  #: Mean Pearson's r of the curves
    paper: PaperRow  #: The paper's row


@dataclass(frozen=True)
class Study:
    """Several reproduced gaits compared with the recorded ones."""

    names: tuple[str, ...]  #: Names of the gaits
    comparisons: tuple[Comparison, ...] = field(repr=False)  #: One per gait
    rows: tuple[StudyRow, ...]  #: The twelve rotations of Table I, in its order
    percent: Float[Array, " n_percent"] = field(repr=False)  #: Percent of the gait cycle

    @property
    def n(self) -> int:
        """Number of gaits."""
        return len(self.names)

    def metrics(self) -> dict[str, Any]:
        """Return flat figures with units; unknown ones are omitted."""
        flat: dict[str, Any] = {"gaits_count": self.n}
        for row in self.rows:
            stem, side = row.coordinate[:-2], row.coordinate[-1]
            figures = {
                f"{stem}_rom_{side}_deg": row.simulated,
                f"{stem}_rom_sd_{side}_deg": row.simulated_sd,
                f"{stem}_rom_reference_{side}_deg": row.reference,
                f"{stem}_rom_reference_sd_{side}_deg": row.reference_sd,
                f"{stem}_rom_error_{side}_deg": row.difference,
                f"{stem}_rom_error_abs_{side}_deg": row.difference_abs,
                f"{stem}_rom_error_low_{side}_deg": row.interval[0],
                f"{stem}_rom_error_high_{side}_deg": row.interval[1],
                f"{stem}_rom_shapiro_p_{side}": row.shapiro_p,
                f"{stem}_rom_p_{side}": row.p,
                f"{stem}_rom_identical_{side}": row.identical,
                f"{stem}_rmse_{side}_deg": row.rmse,
                f"{stem}_correlation_{side}": row.correlation,
            }
            flat |= {k: v for k, v in figures.items() if v is not None and np.isfinite(v)}
        flat["rom_error_mean_deg"] = float(np.mean([abs(row.difference) for row in self.rows]))
        flat["rom_error_max_deg"] = float(np.max([abs(row.difference) for row in self.rows]))
        flat["com_error_max_mm"] = 1e3 * max(c.com_error_max_m for c in self.comparisons)
        flat["contact_drift_max_mm"] = 1e3 * max(c.contact_drift_m for c in self.comparisons)
        flat["sole_lowest_mm"] = 1e3 * min(c.lowest_m for c in self.comparisons)
        return flat


def study(names: Sequence[str], comparisons: Sequence[Comparison]) -> Study:
    """Return the statistics of several reproduced gaits.

    A difference that is not significant does not prove equality; see the interval.

    Args:
        names: Names of the gaits, one per comparison.
        comparisons: One per gait; the tests assume one gait per person.

    Raises:
        ParameterError: If there is none, or one lacks a complete cycle or a rotation of Table I.
    """
    if not comparisons or len(names) != len(comparisons):
        raise ParameterError(
            f"a study needs one name for each comparison and at least one of them; "
            f"{len(names)} names and {len(comparisons)} comparisons were given"
        )
    for name, one in zip(names, comparisons, strict=True):
        if not one.cycles:
            raise ParameterError(f"{name} has no complete gait cycle; leave it out of the study")
        missing = [coordinate for _, coordinate in ROTATIONS if coordinate not in one.rom]
        if missing:
            raise ParameterError(
                f"{name} has no {', '.join(missing)}; a study needs all rotations of its table, "
                "which every joint set with subtalar joints has"
            )
    return Study(
        tuple(names),
        tuple(comparisons),
        tuple(_row(label, name, comparisons) for label, name in ROTATIONS),
        PERCENT,
    )


def _row(label: str, coordinate: str, comparisons: Sequence[Comparison]) -> StudyRow:
    ours, theirs = np.array([c.rom[coordinate] for c in comparisons], dtype=float).T
    difference = ours - theirs
    shapiro_p, test, p = paired_test(difference)
    return StudyRow(
        label=label,
        coordinate=coordinate,
        simulated=float(ours.mean()),
        simulated_sd=_sd(ours),
        reference=float(theirs.mean()),
        reference_sd=_sd(theirs),
        difference=float(difference.mean()),
        difference_abs=float(np.abs(difference).mean()),
        interval=confidence_interval(difference),
        shapiro_p=shapiro_p,
        test=test,
        p=p,
        identical=None if p is None else bool(p >= ALPHA),
        rmse=float(np.mean([c.rmse[coordinate] for c in comparisons])),
        correlation=known_mean([c.correlation[coordinate] for c in comparisons]),
        paper=PAPER_TABLE[coordinate],
    )


def paired_test(difference: Float[Array, " n"]) -> tuple[float | None, str, float | None]:
    """Return Shapiro and Wilk's p, the kind of paired test, and its two-sided p.

    There is no test for equal differences or fewer than three.
    """
    if len(difference) < MIN_GAITS or np.ptp(difference) <= 1e-9 * max(
        1.0, np.abs(difference).max()
    ):
        return None, "", None
    from scipy import stats

    shapiro_p = float(stats.shapiro(difference)[1])
    if shapiro_p < ALPHA:
        ranks: Any = stats.wilcoxon(difference)
        return shapiro_p, "wilcoxon", float(ranks.pvalue)
    student: Any = stats.ttest_1samp(difference, 0.0)
    return shapiro_p, "t", float(student.pvalue)


def confidence_interval(values: Float[Array, " n"]) -> tuple[float, float]:
    """Return the 95 % confidence interval of a mean by Student's distribution; NaN for one."""
    if len(values) < 2:
        return float("nan"), float("nan")
    from scipy import stats

    mean = float(np.mean(values))
    half = float(stats.t.ppf(1 - ALPHA / 2, len(values) - 1) * stats.sem(values))
    return mean - half, mean + half


def _sd(values: Float[Array, " n"]) -> float:
    """Return the sample standard deviation; NaN for a single gait."""
    return float(values.std(ddof=1)) if len(values) > 1 else float("nan")

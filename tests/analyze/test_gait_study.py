"""Statistics over several gaits: against hand calculation and tables."""

import json
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.analyze import Comparison, study
from plantigrade.analyze.gait_study import FIGURES, PAPER_TABLE, confidence_interval, paired_test
from plantigrade.analyze.reproduction import ROTATIONS
from plantigrade.errors import ParameterError
from plantigrade.motion.cycles import PERCENT, Cycle

NAMES = [name for _, name in ROTATIONS]


def comparison(simulated: float, reference: float, *, level: float = 0.0) -> Comparison:
    """One gait in which every rotation has these ranges; its curves are two flat cycles."""
    curve = np.stack([np.full(101, level - 1.0), np.full(101, level + 1.0)])
    return Comparison(
        PERCENT,
        {n: curve + 2 for n in NAMES},
        {n: curve for n in NAMES},
        {n: (simulated, reference) for n in NAMES},
        dict.fromkeys(NAMES, 2.0),
        dict.fromkeys(NAMES, 0.9),
        (Cycle("r", 0.0, 1.0),),
        np.array([0.001, 0.0005]),
        0.002,
        -0.003,
        1.0,
        {"r": (0.01, 0.01), "l": (0.01, 0.01)},
        {"r": (60.0, 60.0), "l": (60.0, 60.0)},
    )


def test_the_papers_table_is_as_printed():
    """Its text: always under 15 degrees and often below 5; the hips' flexion and the right hip's
    abduction are marked; simulated ranges are at most the recorded ones."""
    assert list(PAPER_TABLE) == NAMES and len(NAMES) == 12
    assert [n for n, row in PAPER_TABLE.items() if row.identical] == [
        "hip_flexion_r", "hip_adduction_r", "hip_flexion_l",
    ]  # fmt: skip
    assert all(row.simulated <= row.reference for row in PAPER_TABLE.values())
    assert max(row.difference for row in PAPER_TABLE.values()) == 14
    odd = [n for n, r in PAPER_TABLE.items() if r.difference != r.reference - r.simulated]
    assert odd == ["knee_angle_l", "ankle_angle_l"]
    assert set(FIGURES) <= set(NAMES) and len(FIGURES) == 4


def test_student_by_hand():
    """Of 1 to 5: mean 3, deviation sqrt(2.5), t = 3 / sqrt(0.5) on four degrees of freedom.

    With four degrees the distribution function is closed:
    1/2 + (3/8) s (1 - s²/12), where s = t / sqrt(1 + t²/4).
    """
    difference = np.arange(1.0, 6.0)
    t = 3 / np.sqrt(0.5)
    s = t / np.sqrt(1 + t**2 / 4)
    p = 2 * (0.5 - 0.375 * s * (1 - s**2 / 12))
    shapiro, test, found = paired_test(difference)
    assert test == "t" and shapiro > 0.9
    assert found == pytest.approx(p, rel=1e-9)
    low, high = confidence_interval(difference)
    assert (low + high) / 2 == pytest.approx(3)
    assert (high - low) / 2 == pytest.approx(2.7764 * np.sqrt(0.5), rel=1e-4)  # any t table


def test_skewed_differences_go_to_wilcoxon():
    """Ten differences, all positive: of 2^10 equally likely signs two are as extreme."""
    difference = np.array([0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 90.0])
    shapiro, test, p = paired_test(difference)
    assert test == "wilcoxon" and shapiro < 0.05
    assert p == pytest.approx(2 / 2**10)


@pytest.mark.parametrize("difference", [[1.0, 2.0], [3.0, 3.0, 3.0, 3.0], [0.0, 0.0, 0.0]])
def test_nothing_to_test(difference):
    assert paired_test(np.array(difference)) == (None, "", None)


def test_false_alarms_are_as_many_as_they_should_be():
    """Of samples without a difference one in twenty is called different."""
    rng = np.random.default_rng(3)
    called = [paired_test(rng.normal(size=9))[2] < 0.05 for _ in range(1000)]
    assert 0.03 < np.mean(called) < 0.075


def test_a_row_of_the_table():
    ranges = [(50.0, 52.0), (55.0, 54.0), (60.0, 65.0), (48.0, 50.0)]
    result = study("abcd", [comparison(*r) for r in ranges])
    row = result.rows[3]
    assert (row.label, row.coordinate) == ("Knee R Flex/Exte", "knee_angle_r")
    assert (row.simulated, row.reference) == (53.25, 55.25)
    assert row.difference == -2.0 and row.difference_abs == 2.5
    assert row.reference_sd == pytest.approx(np.std([52, 54, 65, 50], ddof=1))
    assert row.interval[0] < -2 < row.interval[1]
    assert row.identical is (row.p >= 0.05) and row.paper.difference == 11
    assert (row.rmse, row.correlation) == (2.0, 0.9)
    metrics = result.metrics()
    json.dumps(metrics, allow_nan=False)
    assert metrics["knee_angle_rom_error_r_deg"] == -2.0
    assert metrics["rom_error_max_deg"] == metrics["rom_error_mean_deg"] == 2.0
    assert metrics["gaits_count"] == 4 and metrics["sole_lowest_mm"] == -3


def test_one_gait_alone_has_no_spread_and_no_test():
    result = study(["a"], [comparison(50.0, 52.0)])
    row = result.rows[0]
    assert row.p is None and row.identical is None and np.isnan(row.simulated_sd)
    assert not any("_sd_" in k or "_p_" in k or "identical" in k for k in result.metrics())


def test_bad_input():
    one = comparison(1, 1)
    with pytest.raises(ParameterError, match="2 names and 1 comparisons"):
        study("ab", [one])
    with pytest.raises(ParameterError, match="at least one"):
        study([], [])
    with pytest.raises(ParameterError, match="b has no complete gait cycle"):
        study("ab", [one, replace(one, cycles=())])
    without = {n: r for n, r in one.rom.items() if n != "subtalar_angle_l"}
    with pytest.raises(ParameterError, match="a has no subtalar_angle_l"):
        study("a", [replace(one, rom=without)])

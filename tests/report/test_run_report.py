"""What a report says about a run: the run's own figures, beside the norms of its speed."""

from dataclasses import replace

import mujoco
import numpy as np
import pytest

from plantigrade.analyze import norms
from plantigrade.analyze.trial import analyse
from plantigrade.report.run_report import run_data, run_pages
from plantigrade.report.sections import Section
from tests.analyze.plated_walk import plated_walk, without_plates


@pytest.fixture(scope="module")
def trial():
    """The walk with plates."""
    return analyse(plated_walk().fit(), cutoff=None)


@pytest.fixture(scope="module")
def body(trial):
    """Its body."""
    return mujoco.MjModel.from_xml_string(trial.fit.human.xml)


@pytest.fixture(scope="module")
def told(trial, body):
    """What its report says."""
    return run_data(body, trial.record, title="T", sentence="S")


def test_the_table_holds_the_measures_of_the_run(trial, told):
    m = trial.record.metrics
    rows = {row.name: row for row in told.measures}
    assert rows["walking speed"].both == m["walking_speed_m_s"] == pytest.approx(1.25, abs=0.03)
    assert rows["cadence"].both == m["cadence_steps_min"]
    assert (rows["stance"].right, rows["stance"].left) == (m["stance_r_pct"], m["stance_l_pct"])
    # two steps make a stride, stance and swing a cycle
    assert rows["step length"].right + rows["step length"].left == pytest.approx(
        rows["stride length"].right, rel=0.02
    )
    assert rows["stance"].left + rows["swing"].left == pytest.approx(100)
    assert told.toe_off == {"r": m["stance_r_pct"], "l": m["stance_l_pct"]}


def test_curves_are_complete_and_in_their_units(told):
    angles = {c.name for c in told.angles}
    assert {"pelvis_tilt", "hip_flexion_r", "knee_angle_l", "ankle_angle_r"} <= angles
    moments = {c.name: c for c in told.moments}
    assert set(moments) == {
        f"{j}_moment_{s}"
        for j in ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")
        for s in "rl"
    }
    assert {c.unit for c in told.moments} == {"N m/kg"}
    assert {c.unit for c in told.powers} == {"W/kg"}
    up = next(c for c in told.forces if c.name == "ground_force_up_r")
    assert up.unit == "BW" and 0.9 < np.nanmax(up.values) < 1.6


def test_a_textbook_walk_lies_in_the_band_of_the_book(told):
    """The knee of the mean walk stays within two standard deviations of the published mean."""
    band = told.norms["knee_angle"]
    for curve in told.angles:
        if not curve.name.startswith("knee_angle"):
            continue
        mean = np.interp(curve.percent, band.percent, band.mean)
        sd = np.interp(curve.percent, band.percent, band.sd)
        assert (np.abs(curve.values.mean(axis=0) - mean) < 2 * sd).mean() > 0.9


@pytest.mark.parametrize("speed", [0.4, 0.9, 1.25, 1.8, 2.2])
def test_norms_are_those_of_the_speed(trial, body, speed):
    d = trial.fit.human.dimensions
    leg = {f"length_{n}_m": getattr(d, n) for n in ("thigh", "shank", "ankle_height")}
    metrics = {**trial.record.metrics, **leg, "walking_speed_m_s": speed}
    data = run_data(body, replace(trial.record, metrics=metrics), title="T")
    expected = norms.norm("knee_angle", norms.speed_class(speed, sum(leg.values()))).mean
    np.testing.assert_array_equal(data.norms["knee_angle"].mean, expected)
    off = norms.FOOT_OFF[norms.speed_class(speed, sum(leg.values()))]
    stance = next(m for m in data.measures if m.name == "stance")
    assert stance.norm == f"{off[0]} ± {off[1]}"


def test_without_forces_there_are_no_moments(body):
    record = analyse(without_plates(plated_walk().fit()), cutoff=None).record
    data = run_data(body, record, title="T")
    assert data.angles and not data.moments and not data.powers and not data.forces


def test_without_a_cycle_nothing_is_said_of_walking(trial, body):
    still = replace(trial.record, motion=replace(trial.record.motion, events=()), metrics={})
    data = run_data(body, still, title="T")
    assert not data.angles and not data.measures and not data.toe_off
    assert "knee" not in " ".join(data.facts)


def test_missing_figures_are_left_out(trial, body):
    """What a JSON file holds as null is no number."""
    metrics = dict.fromkeys(trial.record.metrics, None)
    data = run_data(body, replace(trial.record, metrics=metrics), title="T")
    assert all(m.both is None and m.right is None for m in data.measures)
    pages = run_pages(body, replace(trial.record, metrics=metrics), title="T")
    assert set(pages) == {"report.html", "viewer.html"}
    for word in ("None", "nan"):
        assert f">{word}<" not in pages["report.html"]


def test_more_sections_can_be_added(trial, body):
    more = Section("Of my own", text="Words of mine.")
    text = run_pages(body, trial.record, title="T", extra=(more,))["report.html"]
    assert "Of my own" in text and "Words of mine." in text


def test_pages_are_the_same_twice(trial, body):
    first, again = (run_pages(body, trial.record, title="T", sentence="S") for _ in range(2))
    assert first == again

"""Figures of many experiments in one file: nothing ends the others, differences are reported."""

from copy import deepcopy

import numpy as np
import pytest

from experiments import figures
from experiments.cached_results import CachedResults
from experiments.figures import compare, figures_of, is_time, measure, read_figures
from experiments.table import ResultTable, Row, at_least, at_most
from plantigrade.errors import FileError

TABLE = ResultTable(
    "Of two",
    [
        at_most("walk", "marker RMS", 5.25, 10, "mm"),
        at_least("walk", "knee, r", 0.99, 0.95),
        at_most("walk", "read, fit and analyse", 1.0, 2.0, "s"),
        Row("run", "fit", None, note="no markers", met=False),
        Row("run", "range", float("nan"), "deg"),
    ],
    figures={"people": np.float64(2.0)},
)


def kept(path, *, fails=False):
    def act():
        if fails:
            raise ZeroDivisionError("of\nall things")
        return figures_of(TABLE)

    return measure({"one": act, "two": lambda: figures_of(TABLE)}, path)


def test_a_table_becomes_figures_and_goals():
    found = figures_of(TABLE)
    assert found["status"] == "ok"
    assert set(found["figures"]) == {
        "walk_marker_rms_mm", "walk_knee_r", "walk_read_fit_and_analyse_s", "run_fit",
        "run_range_deg", "people",
    }  # fmt: skip
    assert found["figures"]["run_fit"] == "no markers", "why, in place of a number"
    assert found["goals"] == {
        "walk_marker_rms_mm": True, "walk_knee_r": True, "walk_read_fit_and_analyse_s": True,
        "run_fit": False,
    }  # fmt: skip


def test_one_that_fails_is_kept_and_the_others_go_on(tmp_path):
    path, said = tmp_path / "below" / figures.FILE, []
    found = kept(path, fails=True)
    assert found["experiments"]["one"]["status"] == "ZeroDivisionError: of all things"
    assert found["experiments"]["two"]["status"] == "ok"
    assert found["time_s"] == sum(e["time_s"] for e in found["experiments"].values())
    written = read_figures(path)
    assert written["experiments"]["two"]["figures"]["walk_marker_rms_mm"] == 5.25
    assert written["experiments"]["two"]["figures"]["run_range_deg"] is None
    text = figures.measured_table(found)
    assert "of all things" in text and "3 of 4" in text

    def stop():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        measure({"first": lambda: figures_of(TABLE), "second": stop}, path, say=said.append)
    assert list(read_figures(path)["experiments"]) == ["first"], "what is done is written"
    assert len(said) == 3


def test_two_equal_files_do_not_differ(tmp_path):
    path = tmp_path / figures.FILE
    kept(path)
    found = compare(read_figures(path), read_figures(path))
    assert found.metrics() == {
        "status": "ok", "figures_identical": 12, "figures_changed": 0, "figures_gone": 0,
        "figures_new": 0, "goals_lost": 0, "goals_won": 0, "statuses_changed": 0,
        "times_changed": 0,
    }  # fmt: skip
    assert found.text().startswith("12 figures identical, 0 changed")


def test_differences_are_reported_by_kind(tmp_path):
    kept(tmp_path / figures.FILE)
    before = read_figures(tmp_path / figures.FILE)
    after = deepcopy(before)
    one, two = after["experiments"]["one"], after["experiments"]["two"]
    one["figures"]["walk_knee_r"] = 0.9405
    one["goals"]["walk_knee_r"] = False
    one["figures"]["run_fit"] = "no feet"
    del one["figures"]["people"]
    one["figures"]["walks"] = 3
    two["figures"]["walk_marker_rms_mm"] = 10.5
    two["figures"]["walk_read_fit_and_analyse_s"] = 3.0
    two["goals"]["walk_read_fit_and_analyse_s"] = False  # on a time: noise
    found = compare(before, after)
    assert [c.name for c in found.changes["figures_changed"]] == [
        "one run_fit", "two walk_marker_rms_mm", "one walk_knee_r"
    ]  # fmt: skip
    assert [c.name for c in found.changes["goals_lost"]] == [
        "one walk_knee_r"
    ] and not found.changes["goals_won"]
    assert [c.name for c in found.changes["figures_gone"]] == ["one people"]
    assert [c.name for c in found.changes["figures_new"]] == ["one walks"]
    assert [c.name for c in found.changes["times_changed"]] == ["two walk_read_fit_and_analyse_s"]
    assert found.status == "one walk_knee_r: goal lost"
    text = found.text()
    assert "+1e+02 %" in text and "-5 %" in text and "Computing times" in text
    assert "7 figures identical, 3 changed, 1 gone, 1 new; 1 goals lost, 0 won" in text
    back = compare(after, before)
    assert [c.name for c in back.changes["goals_won"]] == [
        "one walk_knee_r"
    ] and back.status == "ok"


def test_an_experiment_that_fails_now_is_reported(tmp_path):
    before = kept(tmp_path / figures.FILE)
    found = compare(before, kept(tmp_path / figures.FILE, fails=True))
    assert found.status == "one: ZeroDivisionError: of all things"
    assert len(found.changes["figures_gone"]) == 6 and "How experiments ended" in found.text()
    del before["experiments"]["two"]
    assert "left out" in compare(kept(tmp_path / figures.FILE), before).status


BROKEN = {
    "nothing": "",
    "a list": "[1]",
    "no experiments": "{}",
    "no figures": '{"experiments": {"a": {"status": "ok"}}}',
    "a word for goals": '{"experiments": {"a": {"status": "ok", "figures": {}, "goals": "9"}}}',
    "deep": "[" * 100_000,
}


@pytest.mark.parametrize("text", BROKEN.values(), ids=BROKEN)
def test_another_file_is_refused(tmp_path, text):
    path = tmp_path / "other.json"
    path.write_text(text)
    with pytest.raises(FileError, match="holds no figures of experiments|is empty"):
        read_figures(path)
    with pytest.raises(FileError, match="no such file"):
        read_figures(tmp_path / "nowhere.json")


def test_computing_times_are_distinguished_from_times_of_a_motion():
    assert all(map(is_time, (
        "time_s", "solve_time_s", "walk_time_s", "x_processor_time_s", "x_time_per_cycle_s",
        "x_whole_tick_median_ms", "x_program_median_ms", "x_ms_per_frame", "x_time_median_s",
    )))  # fmt: skip
    assert not any(map(is_time, (
        "stride_time_l_s", "duration_s", "flight_time_s", "walking_speed_m_s",
        "x_heel_strike_against_plates_mean_error_5_ms",
    )))  # fmt: skip


@pytest.mark.parametrize("text", ["[1]", "[" * 100_000])
def test_results_that_are_none_are_refused(tmp_path, text):
    path = tmp_path / "results.json"
    path.write_text(text)
    with pytest.raises(FileError, match="holds no results.*delete it"):
        CachedResults(path)

"""The table of an experiment: goals judged, keys plain, text for a reader."""

import json
import re

import pytest

from experiments.table import ResultTable, Row, at_least, at_most, sheet


def test_goals_are_judged_on_the_right_side():
    assert at_most("a", "error", 3.0, 3.0).met and not at_most("a", "error", 3.01, 3.0).met
    assert at_least("a", "r", 0.97, 0.97).met and not at_least("a", "r", 0.969, 0.97).met
    assert not at_most("a", "error", float("nan"), 3.0).met, "what is not known meets no goal"
    assert not at_least("a", "r", float("nan"), 0.9).met


@pytest.fixture
def table():
    return ResultTable(
        "Of two",
        [
            at_most("c3d/One.c3d", "marker RMS, mean", 5.25, 10, "mm"),
            at_most("c3d/One.c3d", "peak against OpenSim", 12.0, 10, "%"),
            Row("two", "time", 0.4, "ms/frame"),
            Row("two", "fit", None, note="no markers", met=False),
        ],
        ["a note."],
    )


def test_metrics_are_flat_plain_and_counted(table):
    metrics = table.metrics()
    assert metrics["status"] == "ok"
    assert (metrics["goals"], metrics["goals_met"]) == (3, 1)
    assert metrics["c3d_one_c3d_marker_rms_mean_mm"] == 5.25
    assert metrics["two_fit"] is None
    assert all(re.fullmatch(r"[a-z0-9_]+", key) for key in metrics)
    assert len(metrics) == 4 + 3
    json.dumps(metrics, allow_nan=False)


def test_signs_tell_figures_apart():
    assert Row("walk, speed -5 %", "cost", 1.0).key == "walk_speed_minus_5_cost"
    assert Row("walk, speed +5 %", "cost", 1.0).key == "walk_speed_plus_5_cost"
    assert Row("two-segment 1-2", "slip", 1.0, "mm").key == "two_segment_1_2_slip_mm"


def test_text_shows_ours_and_the_goal(table):
    lines = table.text().splitlines()
    assert lines[0] == "Of two"
    assert any(re.search(r"marker RMS, mean +5.25 mm +<= 10 +ok$", line) for line in lines)
    assert any(line.endswith("SHORT") for line in lines)
    assert any("no markers" in line for line in lines)
    assert "1 of 3 goals met" in lines and lines[-1] == "a note."


def test_wide_tables_leave_only_what_falls_short(table):
    wide = ResultTable(table.title, table.rows, table.notes, ["WIDE\na  1"], {"further_mm": 2.0})
    text = wide.text()
    assert "WIDE\na  1\n" in text and "Short of their goals:" in text
    assert "peak against OpenSim" in text and "no markers" in text
    assert "marker RMS" not in text, "a goal that is met is in the wide table"
    assert "1 of 3 goals met" in text
    assert wide.metrics() == {**table.metrics(), "further_mm": 2.0}
    good = ResultTable("Good", table.rows[:1], (), ["WIDE"]).text()
    assert "Short" not in good and "1 of 1 goals met" in good
    assert "goals met" not in ResultTable("None", table.rows[2:3], (), ["WIDE"]).text()


def test_columns_of_a_sheet_line_up():
    lines = sheet("T", ("", "long head"), [("name", "1"), ("a longer name", "22")]).splitlines()
    assert lines[0] == "T"
    assert len({len(line) for line in lines[1:]}) == 1

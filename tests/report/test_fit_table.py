"""The page and the table of several fits."""

import csv
import io
from pathlib import Path

from plantigrade.report.fit_table import Fitted, table_html
from plantigrade.workflows.fit_table import table_csv

GOOD = {"status": "ok", "marker_rms_mean_mm": 4.8, "height_m": 1.58, "walking_speed_m_s": 1.17,
        "gps_deg": 7.3, "strides_r_count": 3}  # fmt: skip
STILL = {"status": "ok", "joint_rms_mm": 12.0, "height_m": 1.7}


def test_every_recording_is_a_line_with_its_figures():
    fitted = [Fitted("a", GOOD, "../fit-a"), Fitted("b <c>", STILL, "../fit b")]
    page = table_html(fitted, {"bad.c3d": "is < damaged"}, status="1 of 3 failed", provenance={})
    assert 'href="../fit-a/report.html"' in page and 'href="../fit%20b/viewer.html"' in page
    assert "b &lt;c&gt;" in page and "bad.c3d: is &lt; damaged" in page
    assert "2 of 3 recordings fitted" in page and "1.17" in page
    assert "<td>4.8</td>" in page and "<td>12.0</td>" in page, "either kind of error"
    assert "8.4 ± 5.1" in page, "mean and SD over recordings"
    assert "cadence" not in page, "a column that nobody fills is left out"


def test_the_table_has_every_column_and_every_file():
    text = table_csv([("a", Path("x/a.c3d"), Path("runs/fit-a"), GOOD)], {"x/bad.c3d": "damaged"})
    rows = list(csv.DictReader(io.StringIO(text)))
    assert [row["recording"] for row in rows] == ["a", "bad"]
    assert rows[0]["error_mm"] == "4.8" and rows[0]["gps_deg"] == "7.3"
    assert rows[0]["cadence_steps_min"] == "" and rows[1]["status"] == "damaged"

"""The page and the tables of a batch."""

import csv
from pathlib import Path

import numpy as np
import pyarrow.parquet as parquet
import pytest

from plantigrade.motion.cycles import PERCENT
from plantigrade.pages.batch import FITS, PAGE, page_html_of
from plantigrade.record import tables
from plantigrade.record.batch import BatchFolder, Curve, Row
from plantigrade.workflows.batch_items import ItemResult

GOOD = {"marker_rms_mean_mm": 4.8, "height_m": 1.58, "walking_speed_m_s": 1.17, "gps_deg": 7.3,
        "strides_r_count": 3, "strides_l_count": 3}  # fmt: skip
STILL = {"joint_rms_mm": 12.0, "height_m": 1.7}
SPEC = {"method": "fit", "settings": {"feet": "rigid", "height": None}}


def batch_page(folder: Path, rows: list[Row]) -> str:
    """Return the page of a batch of these items, each with a knee that bends by its number."""
    store = BatchFolder(folder, SPEC, "plantigrade fit x", overwrite=False)
    for row in rows:
        wave = (10.0 + row.number) * np.sin(np.pi * PERCENT / 100)
        curves = {f"knee_angle_{side}": Curve("deg", 3, wave, 0 * wave + 2) for side in "rl"}
        (folder / row.name).mkdir()
        for page in () if row.failed else ("report.html", "metrics.json"):
            (folder / row.name / page).write_text("{}")
        store.add(row, {} if row.failed else curves)
    ended = [ItemResult(r.name, None, {}, r.figures, r.status, r.failed * r.status) for r in rows]
    counts = FITS.counts(ended)
    page = page_html_of(FITS, store, counts)
    store.finish(counts, {PAGE: page})
    return page


@pytest.fixture(scope="module")
def few(tmp_path_factory):
    """Page and folder of two fits and a failure."""
    folder = tmp_path_factory.mktemp("batches") / "few"
    rows = [
        Row("a", 0, "/x/a.c3d", "k0", "ok", figures=GOOD),
        Row("b <c>", 1, "/x/b.bvh", "k1", "ok", figures={**GOOD, **STILL, "gps_deg": 9.5}),
        Row("bad", 2, "/x/bad.c3d", "k2", "is < damaged", failed=True),
    ]
    return batch_page(folder, rows), folder


def test_every_item_is_a_line_with_its_figures_and_links(few):
    page, _ = few
    assert 'href="a/report.html"' in page and 'href="b%20%3Cc%3E/viewer.html"' in page
    assert "b &lt;c&gt;" in page and "bad: is &lt; damaged" in page
    assert "2 of 3 recordings fitted" in page and "1.17" in page
    assert "<td>4.8</td>" in page and "<td>12.0</td>" in page
    assert "8.4 ± 1.6" in page, "mean and SD over recordings"
    assert "cadence" not in page, "a column that nobody fills is left out"


def test_the_mean_curves_of_two_items_are_drawn(few):
    assert "Curves over the gait cycle" in few[0] and "up to 2 items" in few[0]


def test_the_table_has_every_item_and_the_settings(few):
    with (few[1] / "batch.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["name"] for row in rows] == ["a", "b <c>", "bad"]
    assert rows[0]["gps_deg"] == "7.3" and rows[0]["setting_feet"] == "rigid"
    assert rows[2]["gps_deg"] == "" and rows[2]["status"] == "is < damaged"
    assert (few[1] / "failed.txt").read_text("utf-8") == "/x/bad.c3d\n"


def test_outliers_and_distributions_of_many(tmp_path):
    speeds = [1.1, 1.2, 1.25, 1.3, 1.15, 1.22, 4.0]
    rows = [
        Row(f"walk{k}", k, status="ok", figures={**GOOD, "walking_speed_m_s": speed})
        for k, speed in enumerate(speeds)
    ]
    page = batch_page(tmp_path / "many", rows)
    outliers = page[page.index('id="outliers"') : page.index('id="curves-over-the-gait-cycle"')]
    assert 'href="walk6/report.html"' in outliers and outliers.count("report.html") == 1
    assert "Distributions" in page and "walking speed" in page


def test_an_item_that_fails_now_has_neither_the_curves_nor_the_run_of_its_earlier_result(tmp_path):
    """Its file was replaced by a broken one; the folder of the earlier run is still there."""
    folder = tmp_path / "batch"
    batch_page(folder, [Row("a", 0, status="ok", figures=GOOD), Row("b", 1, status="ok")])
    store = BatchFolder(folder, SPEC, "plantigrade fit x", overwrite=False)
    store.add(Row("b", 1, status="is damaged", failed=True), {})
    assert [name for name, _ in store.curve_means()] == ["a"]
    page = page_html_of(FITS, store, FITS.counts(()))
    store.finish({"status": "1 of 2 failed"}, {PAGE: page})
    assert 'href="a/report.html"' in page and 'href="b/report.html"' not in page
    assert set(parquet.read_table(folder / "curves.parquet")["name"].to_pylist()) == {"a"}


def test_without_pyarrow_there_are_csv_files(tmp_path, monkeypatch):
    monkeypatch.setattr(tables, "has_parquet", lambda: False)
    batch_page(tmp_path / "few", [Row("a", status="ok", figures=GOOD)])
    assert not list((tmp_path / "few").glob("*.parquet"))
    with (tmp_path / "few" / "curves.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == 2 * len(PERCENT) and rows[0]["variable"] == "knee_angle_r"


def test_parquet_holds_what_csv_holds(few):
    table = parquet.read_table(few[1] / "batch.parquet")
    assert table["gps_deg"].to_pylist() == [7.3, 9.5, None]
    assert str(table.schema.field("strides_r_count").type) == "int64"
    curves = parquet.read_table(few[1] / "curves.parquet").to_pylist()
    assert len(curves) == 2 * 2 * len(PERCENT)
    peak = max(row["mean"] for row in curves if row["name"] == "b <c>")
    assert peak == pytest.approx(11.0, rel=1e-6)
    assert str(parquet.read_schema(few[1] / "curves.parquet").field("variable").type).startswith(
        "dictionary"
    )

"""What the pages of a run say, without a browser."""

import base64
import json
import re
from dataclasses import replace

import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.pages.run_pages import pages, report_html, run_viewer
from plantigrade.pages.text import provenance_rows
from plantigrade.pages.viewer import encode, viewer_html
from plantigrade.record import Provenance, Record, Run
from tests.pages.runs import fitted, from_tasks, solved
from tests.pages.walker import walk


def payload(page: str) -> dict:
    found = re.search(r'<script type="application/json" id="scene">(.*?)</script>', page, re.S)
    assert found
    return json.loads(found[1])


def decoded(item: dict) -> np.ndarray:
    words = np.frombuffer(base64.b64decode(item["data"]), "<u2").astype(float)
    return np.where(words == 65535, np.nan, item["low"] + words * item["step"])


def headings(page: str) -> list[str]:
    return re.findall(r"<h2>(.*?)</h2>", page)


def test_budget(record):
    """Four seconds at 100 Hz: under 3 MB each page."""
    made = pages(fitted(record))
    assert set(made) == {"report.html", "viewer.html"}
    assert all(len(page) < 3e6 for page in made.values())


@pytest.mark.parametrize("make", [fitted, from_tasks, solved])
def test_no_outside_address_and_nothing_that_is_no_number(record, make):
    for name, page in pages(make(record)).items():
        outside = set(re.findall(r"(?:https?:)?//[\w.-]+\.\w+[^\s\"'<]*", page))
        assert outside <= {"http://www.w3.org/2000/svg"}
        if name == "report.html":
            assert not re.search(r">(nan|NaN|None|inf)<", page)


@pytest.mark.parametrize("make", [fitted, from_tasks, solved])
def test_a_run_gives_the_same_pages_from_its_folder(record, make, tmp_path):
    run = make(record)
    saved = run.save(tmp_path / "run", files=pages(run))
    again = pages(Run.load(saved.folder))
    for name, page in again.items():
        assert (tmp_path / "run" / name).read_text(encoding="utf-8") == page, name


def test_sections_are_picked_by_what_the_run_has(record):
    fit, tasks, task = (
        headings(report_html(make(record))) for make in (fitted, from_tasks, solved)
    )
    assert "Marker errors" in fit and "Joint moments" in fit
    assert not {"Check", "Tasks and when they are active", "Ranges of motion"} & set(fit)
    assert tasks[:5] == [
        "Warnings", "Reproduced against recorded angles",
        "Toes, pelvis, trunk and arms against the recorded ones", "Ranges of motion",
        "Tasks and when they are active",
    ]  # fmt: skip
    assert task[1] == "Check" and {"Contact plan", "Convergence"} <= set(task)
    # what a fit has besides comes with its signals alone
    signals = {**record.signals, **solved(record).record.signals}
    both = replace(fitted(record), record=replace(record, signals=signals))
    assert {"Check", "Marker errors", "Ranges of motion"} <= set(headings(report_html(both)))


def test_page_keeps_poses_and_gaps(record):
    """What the page decodes is what was recorded, to a millimetre; unseen markers stay unseen."""
    data = payload(viewer_html(record, title="Walk"))
    frames = np.arange(0, record.motion.n_frames, 2)
    assert data["time"] == pytest.approx(record.motion.time[frames], abs=1e-5)
    shown = decoded(data["recorded"]).reshape(len(frames), -1, 3)
    there = record.recorded_markers.positions[frames]
    assert np.array_equal(np.isnan(shown), np.isnan(there))
    np.testing.assert_allclose(shown, there, atol=1e-3)
    position = decoded(data["positions"]).reshape(len(frames), -1, 3)
    np.testing.assert_allclose(position[:, 1], record.motion.qpos[frames, :3], atol=1e-3)


def test_curves_of_the_viewer_are_the_motion_s(record):
    data = payload(run_viewer(fitted(record)))
    curves = {curve["title"]: curve["lines"] for curve in data["curves"]}
    right, left = curves["Knee flexion"]
    assert (right["label"], left["label"], right["unit"]) == ("right", "left", "°")
    knee = np.rad2deg(record.motion["knee_angle_r"][::2])
    np.testing.assert_allclose(decoded(right["values"]), knee, atol=0.01)
    up = curves["Ground force, vertical"][0]
    force = record.foot("r").force[::2, 2] / record.weight
    np.testing.assert_allclose(decoded(up["values"]), force, atol=1e-3)


def test_encode_is_within_a_step():
    values = np.random.default_rng(0).normal(size=(50, 3))
    values[7, 1] = np.nan
    item = encode(values)
    np.testing.assert_allclose(decoded(item), values.ravel(), atol=0.51 * item["step"])
    assert np.isnan(decoded(encode(np.full(4, np.nan)))).all()
    np.testing.assert_array_equal(decoded(encode(np.full(3, 2.5))), 2.5)


def test_words_from_outside_cannot_inject(record):
    hostile = "</script><script>alert(1)</script>"
    run = replace(
        from_tasks(replace(record, notes=(hostile,))),
        title=hostile, sentence=hostile, status=hostile,
        provenance=Provenance(command=hostile, settings={hostile: hostile}),
    )  # fmt: skip
    reference = replace(run.record, references={hostile: record.motion, "recorded": record.motion})
    for page in pages(replace(run, record=reference)).values():
        assert "<script>alert" not in page


def test_nothing_but_a_motion(record):
    """A record without markers, forces or events still gives every page."""
    motion = replace(record.motion, events=())
    run = Run(Record(record.human, motion), "other", title="Bare")
    made = pages(run)
    assert "Recorded markers" not in made["viewer.html"]
    page = made["report.html"]
    assert "the recording has no markers" in page and "no ground reaction" in page
    assert "Joint angles over time, because there is no complete gait cycle" in page


def test_a_single_frame(human):
    motion = replace(walk(human, duration=0.02).motion.frames(slice(0, 1)), events=())
    run = Run(Record(human, motion), "other", title="One")
    assert payload(run_viewer(run))["time"] == [0.0]
    assert "NaN" not in report_html(run)


def test_a_motion_without_frames_is_refused(record):
    none = Run(Record(record.human, record.motion.frames(slice(0, 0))), "other")
    with pytest.raises(ParameterError, match="no frames"):
        pages(none)


def test_a_failed_status_is_shown(record):
    failed = replace(fitted(record), status="did not converge")
    assert "The body does not fit this recording: did not converge." in report_html(failed)


def test_title_is_the_folder_s_name_where_there_is_none(record, tmp_path):
    run = replace(fitted(record), title="").save(tmp_path / "walk-7")
    assert "<title>walk-7</title>" in report_html(run)


def test_provenance_as_rows():
    settings = {"marker_set": "a_b.toml", "static": None}
    found = provenance_rows(
        {"settings": settings, "seed": None, "source_files": {"a_b.c3d": "00"}, "v": "1"}
    )
    assert found == [
        ("settings", [("marker set", "a_b.toml")]),
        ("source files", [("a_b.c3d", "00")]),
        ("v", [("", "1")]),
    ]

"""``plantigrade demo``: quick, close to the truth it made itself."""

import hashlib
import json
import re
import shlex
import tempfile
from pathlib import Path

import numpy as np
import pytest

from plantigrade.analyze import norms
from plantigrade.analyze.clinical import clinical_angles
from plantigrade.commands import main as cli
from plantigrade.record import Run
from tests.browser import colours, moved

FILES = {
    "model.xml",
    "motion.npz",
    "motion.mot",
    "metrics.json",
    "report.html",
    "viewer.html",
    "curves.csv",
}
KEPT = "textbook_walk.c3d"


def figures(run: Path) -> dict:
    """Return the metrics of a run folder."""
    return json.loads((run / "metrics.json").read_text("utf-8"))


@pytest.fixture
def runs(demo):
    """Where the demos of the session are."""
    return demo.folder / "runs"


@pytest.fixture
def first(runs):
    """Metrics of the demo."""
    return figures(runs / "demo")


def test_it_is_whole(first, runs):
    assert {p.name for p in (runs / "demo").iterdir()} == FILES | {KEPT}
    assert set(first["files"]) == FILES - {"metrics.json"} | {KEPT}
    assert first["status"] == "ok"
    assert first["pushed_on_feet"] and first["pushed_speed_at_end_m_s"] > 0.5
    assert (runs / "demo-pushed" / "viewer.html").is_file()


def test_it_is_near_the_truth(first):
    metrics = first
    assert metrics["angle_error_mean_deg"] < 3
    assert metrics["angle_error_offset_removed_deg"] < 1.5
    # not too good either: half a millimetre of noise and skin that slides a centimetre were put on
    assert 1.0 < metrics["marker_rms_mean_mm"] < 6
    assert metrics["walking_speed_m_s"] == pytest.approx(1.25, abs=0.03)
    assert metrics["height_m"] == pytest.approx(1.74, abs=1e-6)
    assert metrics["mass_kg"] == pytest.approx(71.0, abs=0.1)
    for side in "rl":
        assert metrics[f"stance_{side}_pct"] == pytest.approx(59, abs=4)  # Schwartz 2008, free


def test_its_first_page_has_no_warning(first):
    assert first["warnings"] == []
    assert first["estimate_noise_factor"] < 2


def test_it_looks_like_the_healthy_mean(runs):
    """Angles beside adults' norms, and the left beside the right."""
    run = Run.load(runs / "demo")
    angles = clinical_angles(run.record)
    means = {name: np.nanmean(rows, axis=0) for name, rows in angles.items()}
    percent = np.linspace(0, 100, len(means["knee_angle_r"]))
    for name in norms.names(norms.ADULTS):
        band = norms.norm(name, population=norms.ADULTS)
        mean, sd = (np.interp(percent, band.percent, values) for values in (band.mean, band.sd))
        for side in "rl":
            away = (means[f"{name}_{side}"] - mean) / sd
            assert np.sqrt(np.mean(away**2)) < 1 and np.abs(away).max() < 2.5, (name, side)
        assert np.abs(means[f"{name}_r"] - means[f"{name}_l"]).mean() < 2, name
        if name == "foot_progression":
            assert abs(np.mean(means[f"{name}_r"] - mean)) < 3
            assert abs(np.mean(means[f"{name}_l"] - mean)) < 3
    assert run.figures["gps_deg"] < run.figures["gps_reference_deg"]


def test_it_ends_with_the_reproduced_gait(first, runs):
    metrics = first
    made = runs / "demo-reproduced"
    assert {p.name for p in made.iterdir()} == FILES | {"forces.npz", "forces.xml"}
    of_gait = figures(made)
    assert of_gait["status"] == "ok" and of_gait["cycles_count"] >= 2
    assert of_gait["rom_error_mean_deg"] == metrics["reproduced_rom_error_mean_deg"]
    assert metrics["reproduced_com_error_max_mm"] < 5
    # every difference within the paper's own (0 to 14 degrees)
    assert metrics["reproduced_rom_error_max_deg"] <= 14
    assert of_gait["source_files"] == metrics["source_files"]


def test_hidden_markers_were_tolerated(runs):
    run = np.load(runs / "demo" / "motion.npz")
    gaps = ~np.isfinite(run["recorded_markers"][..., 0])
    assert 0.15 < gaps.any(axis=0).mean() < 0.35, "a quarter of the markers has a gap"
    assert np.isfinite(run["qpos"]).all()


def test_the_commands_it_prints_are_the_next_to_try(demo):
    lines = [shlex.split(x) for x in demo.said.splitlines() if x.startswith("  plantigrade ")]
    assert [words[1:] for words in lines] == [
        ["fit", f"runs/demo/{KEPT}"], ["reproduce", f"runs/demo/{KEPT}"],
    ]  # fmt: skip


@pytest.mark.slow
def test_its_recording_can_be_fitted_by_itself(demo, runs):
    """The first command it prints, as printed: the same recording and the same motion."""
    done = demo.call("fit", f"runs/demo/{KEPT}", "--quiet")
    assert "beside it" not in done.stderr  # nothing in a run belongs to a recording
    a, b = (np.load(runs / name / "motion.npz") for name in ("demo", "fit-textbook_walk"))
    assert np.array_equal(a["qpos"], b["qpos"])
    same_source(runs, "demo", "demo-reproduced", "fit-textbook_walk")


@pytest.mark.slow
def test_its_recording_can_be_reproduced_by_itself(demo, runs):
    demo.call("reproduce", f"runs/demo/{KEPT}", "--quiet")
    same_source(runs, "reproduce-textbook_walk")


def same_source(runs: Path, *names: str) -> None:
    """Runs are made from the demo's recording, and nothing in them names a temporary file."""
    raw = hashlib.sha256((runs / "demo" / KEPT).read_bytes()).hexdigest()
    for name in names:
        assert figures(runs / name)["source_files"] == {KEPT: raw}
        for path in (runs / name).iterdir():
            words = re.sub(rb"[A-Za-z0-9+/=]{200,}", b"", path.read_bytes())  # without its numbers
            assert tempfile.gettempdir().encode() not in words, path


@pytest.mark.parametrize("seed", ["-1", str(2**32)])
def test_seeds_are_whole_and_not_negative(seed, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["demo", "--seed", seed]) == 2
    assert "seed must be a whole number from 0" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_folder_of_ones_own_is_refused(tmp_path, capsys):
    (tmp_path / "letters-reproduced").mkdir()
    (tmp_path / "letters-reproduced" / "a.txt").write_text("dear")
    assert cli.main(["demo", "--out", str(tmp_path / "letters"), "--overwrite"]) == 2
    assert not (tmp_path / "letters").exists()
    (tmp_path / "letters").mkdir()
    (tmp_path / "letters" / "a.txt").write_text("dear")
    assert cli.main(["demo", "--out", str(tmp_path / "letters")]) == 2
    assert cli.main(["demo", "--out", str(tmp_path / "letters"), "--overwrite"]) == 2
    assert "not a run folder" in capsys.readouterr().err


@pytest.mark.slow
def test_its_pages_in_a_browser(browser, runs):
    browser.open(
        runs / "demo" / "viewer.html",
        ready="document.body.dataset.ready === '1' && document.body.dataset.time",
    )
    browser.evaluate("plantigrade.pause(); plantigrade.seek(1.0)")
    before = browser.screenshot()[60:740, :900]
    assert colours(before) > 1000, "the stage is (nearly) blank"
    browser.evaluate("plantigrade.seek(1.3)")
    after = browser.screenshot()[60:740, :900]
    assert moved(before, after) > 0.005
    browser.open(runs / "demo" / "report.html")
    text = browser.evaluate("document.body.innerText")
    assert "Textbook walk" in text and "NaN" not in text and "None" not in text
    assert browser.evaluate("document.querySelectorAll('svg.plot').length") > 10
    broken = browser.evaluate(
        "[...document.querySelectorAll('svg path')].filter(p => !p.getAttribute('d')"
        " || /NaN|Infinity/.test(p.getAttribute('d'))).length"
    )
    assert broken == 0
    assert browser.errors == [] and browser.requests == []

"""The path from file to folder as a library: what is read with what, and what is written."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from plantigrade.commands.run_folder import open_run
from plantigrade.errors import FitError, RunExists
from plantigrade.motion import Markers, Recording, Subject
from plantigrade.record.folder import read_run
from plantigrade.report.run_report import run_pages
from plantigrade.workflows import fit as fitting
from tests.analyze.plated_walk import plated_walk
from tests.io.test_companions import coordinates, forces, standing, walking


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The walk with plates, analysed and written: its trial, its folder, its metrics."""
    folder = tmp_path_factory.mktemp("run")
    source = folder / "walk.trc"
    walking(source)
    fit = plated_walk("two-segment").fit()
    fit = dataclasses.replace(fit, recording=dataclasses.replace(fit.recording, source=source))
    settings = fitting.FitSettings(static=Path("somewhere/static.c3d"), feet="two-segment")
    trial = fitting.analyse(fit, settings)
    out, metrics = fitting.write(
        trial, folder / "out", title="A walk", command=["plantigrade", "fit", "walk.trc"],
        settings=settings, sources=[source], seed=3, extra={"made_up_n": 1.5},
    )  # fmt: skip
    return trial, out, metrics


def test_record_comes_back_as_it_was(written):
    trial, out, _ = written
    _, record, _ = read_run(out)
    for field in dataclasses.fields(record):
        if field.name in ("metrics", "motion", "recorded_markers"):
            continue
        was, now = getattr(trial.record, field.name), getattr(record, field.name)
        if isinstance(was, np.ndarray):
            np.testing.assert_array_equal(now, was, err_msg=field.name)
        else:
            assert now == was, field.name
    for field in dataclasses.fields(record.motion):
        was, now = getattr(trial.record.motion, field.name), getattr(record.motion, field.name)
        if isinstance(was, np.ndarray):
            np.testing.assert_array_equal(now, was, err_msg=field.name)
        else:
            assert now == was, field.name


def test_record_read_back_gives_the_same_pages(written):
    _, out, metrics = written
    model, record, stored = open_run(out)
    pages = run_pages(
        model,
        dataclasses.replace(record, metrics=stored),
        title=metrics["title"],
        sentence=metrics["sentence"],
    )
    for name, text in pages.items():
        assert (out / name).read_text(encoding="utf-8") == text, name


def test_metrics_say_what_was_done(written):
    trial, out, _ = written
    metrics = json.loads((out / "metrics.json").read_text())
    assert metrics["settings"]["static"] == "somewhere/static.c3d"
    assert set(metrics["settings"]) == {f.name for f in dataclasses.fields(fitting.FitSettings)}
    assert metrics["seed"] == 3 and metrics["made_up_n"] == 1.5
    assert metrics["command"] == "plantigrade fit walk.trc"
    assert metrics["warnings"] == list(trial.record.warnings)
    sentence = metrics["sentence"]
    for fact in ("walk.trc", f"{len(trial.fit.time)} frames", "71.0 kg", "two-segment", "moments"):
        assert fact in sentence, fact


def test_what_exists_stays(written):
    trial, out, _ = written
    before = (out / "metrics.json").read_bytes()
    with pytest.raises(RunExists, match="--overwrite"):
        fitting.refuse_existing(out, overwrite=False)
    fitting.refuse_existing(out, overwrite=True)
    fitting.refuse_existing(out.with_name("new"), overwrite=False)
    assert (out / "metrics.json").read_bytes() == before


def test_companions_are_said_and_counted_as_sources(tmp_path):
    path = walking(tmp_path / "p1_walk1.trc")
    static = standing(tmp_path / "p1_static.trc")
    grf = forces(tmp_path / "p1_walk1_grf.mot")
    loaded = fitting.load(path, fitting.FitSettings())
    assert loaded.sources == (path, static, grf)
    assert len(loaded.recording.plates) == 2
    said = " ".join(loaded.recording.warnings)
    assert "p1_static.trc" in said and "p1_walk1_grf.mot" in said
    alone = fitting.load(path, fitting.FitSettings(companions=False))
    assert alone.static is None and not alone.recording.plates and alone.sources == (path,)
    named = fitting.load(path, fitting.FitSettings(companions=False, static=static, forces=grf))
    assert named.sources == (path, static, grf) and not named.recording.warnings


def test_files_that_are_not_what_they_were_named_for(tmp_path):
    path = walking(tmp_path / "walk.trc")
    other = coordinates(tmp_path / "angles.mot")
    with pytest.raises(FitError, match="no standing trial"):
        fitting.load(path, fitting.FitSettings(static=other))
    with pytest.raises(FitError, match="no ground reactions"):
        fitting.load(path, fitting.FitSettings(forces=other))


def test_what_holds_no_motion_cannot_be_fitted(tmp_path):
    path = forces(tmp_path / "grf.mot")
    settings = fitting.FitSettings()
    with pytest.raises(FitError, match="ground reactions alone"):
        fitting.fit(fitting.load(path, settings), settings)


def test_the_standing_trial_says_who_it_is():
    """Mass and stature told by the standing trial alone are known, not guessed."""
    from plantigrade.analyze.trial import analyse
    from plantigrade.kinematics.fit import fit_markers
    from tests.kinematics.test_fit import markers_of, walker

    human, time, qpos = walker(n=60)
    walk = Recording(Path("walk.trc"), markers_of(human, time, qpos))
    still = np.tile(human.standing(), (20, 1))
    static = Recording(
        Path("static.c3d"),
        markers_of(human, time[:20], still),
        subject=Subject(height=1.68, mass=62.0, sex="female"),
    )
    fit = fit_markers(walk, static=static)
    trial = analyse(fit)
    assert trial.fit.human.mass == pytest.approx(62.0)
    assert trial.fit.human.height == pytest.approx(1.68)
    assert not [w for w in trial.record.warnings if "mass" in w or "stature" in w]


def test_unknown_settings_are_refused():
    with pytest.raises(TypeError):
        fitting.fit_file("walk.trc", hight=1.7)


def test_a_recording_without_names_is_no_marker_recording(tmp_path):
    empty = Markers((), np.arange(5) / 100, np.zeros((5, 0, 3)))
    path = tmp_path / "empty.c3d"
    with pytest.raises(FitError, match="neither markers nor"):
        fitting.fit(fitting.Loaded(Recording(path, empty), None, (path,)), fitting.FitSettings())


def test_write_needs_no_markers(written):
    out = written[1]
    assert np.load(out / "motion.npz").get("recorded_markers") is None

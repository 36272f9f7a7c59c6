"""The path from file to folder as a library: what is read with what, and what is written."""

import dataclasses
import json
from pathlib import Path
from unittest.mock import patch

import numpy as np
import pytest

from plantigrade.errors import FitError, ParameterError
from plantigrade.io import length
from plantigrade.motion import Markers, Recording, Subject
from plantigrade.pages.run_pages import pages
from plantigrade.record import Run
from plantigrade.workflows import fit as fitting
from plantigrade.workflows.save import save
from plantigrade.workflows.settings import FitSettings
from tests.analyze.plated_walk import analyse, plated_walk
from tests.io.test_companions import coordinates, forces, standing, walking


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The walk with plates, analysed and written: its trial, the run, the run read back."""
    folder = tmp_path_factory.mktemp("run")
    source = folder / "walk.trc"
    walking(source)
    fit = plated_walk("two-segment").fit()
    recording = dataclasses.replace(fit.recording, source=source)
    fit = dataclasses.replace(fit, recording=recording)
    settings = FitSettings(static=Path("somewhere/static.c3d"), feet="two-segment")
    trial = analyse(fit, cutoff="usual", mass=settings.mass)
    command = "plantigrade fit walk.trc"
    run = fitting.run_of(recording, trial, settings, title="A walk", command=command, seed=3)
    run = save(run, folder / "out")
    return trial, run, Run.load(run.folder)


def test_record_comes_back_as_it_was(written):
    trial, _, read = written
    was, now = trial.record(), read.record
    assert_same(was.motion, now.motion)
    for field in dataclasses.fields(was):
        mine, theirs = getattr(was, field.name), getattr(now, field.name)
        if isinstance(mine, np.ndarray):
            np.testing.assert_array_equal(theirs, mine, err_msg=field.name)
    assert now.sites == was.sites and now.ground == was.ground and now.notes == was.notes
    assert now.human.xml == was.human.xml


def assert_same(was, now):
    """All fields are equal, arrays to the last digit."""
    for field in dataclasses.fields(was):
        mine, theirs = getattr(was, field.name), getattr(now, field.name)
        if isinstance(mine, np.ndarray):
            np.testing.assert_array_equal(theirs, mine, err_msg=field.name)
        else:
            assert theirs == mine, field.name


def test_a_run_read_back_gives_the_same_pages(written):
    _, run, read = written
    for name, text in pages(read).items():
        assert (run.folder / name).read_text(encoding="utf-8") == text, name


def test_a_run_shows_withheld_plates_with_the_estimate(written):
    """A plate reads half of what it should: the figures say so, nothing else has seen it."""
    trial, _, _ = written
    settings = FitSettings(without_plates=True, mass=71.0)
    alone = analyse(trial.fit, mass=71.0, without_plates=True)
    forces, moments = alone.withheld
    half = dataclasses.replace(forces, force=0.5 * forces.force)
    wrong = dataclasses.replace(alone, withheld=(half, moments))
    run, other = (fitting.run_of(trial.fit.recording, each, settings) for each in (alone, wrong))
    assert "estimated from the motion" in run.sentence and "measured ground" not in run.sentence
    for each in (run, other):
        assert each.record.signals["measured.force"].shape == (each.record.motion.n_frames, 2, 3)
    ours, theirs = run.figures, other.figures
    assert ours["vertical_force_rmse_bw"] < 0.2 < theirs["vertical_force_rmse_bw"]
    assert "knee_angle_moment_in_band_pct" in ours and "forced_root_residual_bw" not in ours
    same = {k: v for k, v in ours.items() if theirs[k] == v}
    assert {"mass_kg", "estimate_noise_factor", "stance_r_pct"} <= set(same)
    np.testing.assert_array_equal(run.record.qfrc_actuator, other.record.qfrc_actuator)


def test_plates_that_are_not_there_cannot_be_withheld(tmp_path):
    walking(tmp_path / "walk.trc")
    with pytest.raises(FitError, match="without_plates has no effect on walk.trc"):
        fitting.load(tmp_path / "walk.trc", FitSettings(without_plates=True))


def test_metrics_say_what_was_done(written):
    trial, run, _ = written
    metrics = json.loads((run.folder / "metrics.json").read_text())
    assert metrics["kind"] == "fit" and metrics["status"] == "ok"
    assert metrics["settings"]["static"] == "somewhere/static.c3d"
    assert set(metrics["settings"]) == {f.name for f in dataclasses.fields(FitSettings)}
    assert metrics["seed"] == 3 and metrics["mass_kg"] == 71.0
    assert metrics["command"] == "plantigrade fit walk.trc"
    assert metrics["notes"] == list(trial.record().notes)
    assert set(metrics["source_files"]) == {"walk.trc"}
    sentence = metrics["sentence"]
    for fact in ("walk.trc", f"{len(trial.fit.time)} frames", "71.0 kg", "two-segment", "moments"):
        assert fact in sentence, fact


def test_companions_are_noted_and_counted_as_sources(tmp_path):
    path = walking(tmp_path / "p1_walk1.trc")
    static = standing(tmp_path / "p1_static.trc")
    grf = forces(tmp_path / "p1_walk1_grf.mot")
    loaded = fitting.load(path, FitSettings())
    assert loaded.companions == (static, grf)
    assert len(loaded.plates) == 2
    said = " ".join(loaded.warnings)
    assert "p1_static.trc" in said and "p1_walk1_grf.mot" in said
    alone = fitting.load(path, FitSettings(companions=False))
    assert alone.static is None and not alone.plates and not alone.companions
    named = fitting.load(path, FitSettings(companions=False, static=static, forces=grf))
    assert named.companions == (static, grf) and not named.warnings
    files = fitting.provenance(named, FitSettings()).source_files
    assert set(files) == {path.name, static.name, grf.name}


@pytest.mark.parametrize("cutoff", [0.0, -6.0, 1e-308, 0.001, 1e9, float("nan"), float("inf")])
def test_a_cutoff_that_means_nothing_is_refused(cutoff):
    with pytest.raises(ParameterError, match="cutoff"):
        FitSettings(cutoff=cutoff)


def test_sides_are_exchanged_in_all_that_has_them(tmp_path):
    """Names of markers of the recording and of its standing trial."""
    path = walking(tmp_path / "p1_walk1.trc")
    standing(tmp_path / "p1_static.trc")
    forces(tmp_path / "p1_walk1_grf.mot")
    usual, swapped = (fitting.load(path, FitSettings(swap_sides=s)) for s in (False, True))
    other = {"L": "R", "R": "L"}
    for one, two in ((usual, swapped), (usual.static, swapped.static)):
        assert two.markers.names == tuple(other[n[0]] + n[1:] for n in one.markers.names)
        np.testing.assert_array_equal(two.markers.positions, one.markers.positions)
    assert any("left and right were swapped" in w for w in swapped.warnings)
    turned = fitting.load(path, FitSettings(mirror_axis=True))
    mirrored = usual.markers.positions * [1, -1, 1]
    np.testing.assert_array_equal(turned.markers.positions, mirrored)


def test_sides_of_no_marker_are_not_exchanged(tmp_path):
    angles = coordinates(tmp_path / "angles.mot")
    for option in ("swap_sides", "mirror_axis"):
        with pytest.raises(FitError, match=f"{option} has no effect"):
            fitting.load(angles, FitSettings(**{option: True}))
    with pytest.raises(ParameterError, match="together"):
        FitSettings(swap_sides=True, mirror_axis=True)


def test_files_that_are_not_what_they_were_named_for(tmp_path):
    path = walking(tmp_path / "walk.trc")
    other = coordinates(tmp_path / "angles.mot")
    with pytest.raises(FitError, match="not a standing trial"):
        fitting.load(path, FitSettings(static=other))
    with pytest.raises(FitError, match="no ground reactions"):
        fitting.load(path, FitSettings(forces=other))


def test_what_holds_no_motion_cannot_be_fitted(tmp_path):
    path = forces(tmp_path / "grf.mot")
    settings = FitSettings()
    with pytest.raises(FitError, match="ground reactions alone"):
        fitting.fit_recording(fitting.load(path, settings), settings)


def test_the_standing_trial_names_the_person():
    """Mass and stature of the standing trial alone are known, not guessed."""
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
    assert not [w for w in trial.record().notes if "mass" in w or "stature" in w]


def test_a_fit_that_would_swap_is_refused(tmp_path):
    path = tmp_path / "walk.trc"
    walking(path)
    with patch.object(length, "free_memory", lambda: 1e8):
        with pytest.raises(FitError, match="walk.trc has .* frames; their fit needs .* in parts"):
            fitting.fit(path)


def test_a_recording_without_names_is_no_marker_recording(tmp_path):
    empty = Markers((), np.arange(5) / 100, np.zeros((5, 0, 3)))
    path = tmp_path / "empty.c3d"
    with pytest.raises(FitError, match="neither markers nor"):
        fitting.fit_recording(Recording(path, empty), FitSettings())


def test_write_needs_no_markers(written):
    out = written[1].folder
    assert np.load(out / "motion.npz").get("recorded_markers") is None

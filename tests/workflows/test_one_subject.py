"""Trials of one subject: one body and one mass, whatever the order; other people stay apart."""

from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest

from plantigrade.commands import main as cli
from plantigrade.dynamics import plate_checks
from plantigrade.io import write
from plantigrade.motion import Recording, Subject
from plantigrade.workflows.fit import run_fit
from plantigrade.workflows.one_subject import by_subject, share
from plantigrade.workflows.settings import FitSettings
from tests.analyze.plated_walk import FAR, MASS, plated_walk
from tests.kinematics.test_fit import NAMES, markers_of, walker

SETTINGS = FitSettings(sex="female", companions=False)
OWN = {"thigh": 0.44, "shank": 0.38}


def trial(
    path, *, seed: int = 0, size: float = 1.0, subject: Subject | None = None, names=NAMES, n=110
):
    """Write a trial of a person whose markers are each somewhat beside their landmark."""
    human, time, qpos = walker(n, lengths=OWN)
    placed = markers_of(human, time, qpos, noise=0.0, shift=0.006, seed=7, names=NAMES)
    rng = np.random.default_rng(seed)
    noisy = size * placed.positions + 0.001 * rng.normal(size=placed.positions.shape)
    markers = replace(placed, positions=noisy).select(names)
    write(Recording(path, markers, subject=subject or Subject()), path)
    return path


def test_trials_of_one_subject_have_one_body_in_any_order(tmp_path):
    one = trial(tmp_path / "walk1.trc", seed=1)
    few = [n for n in NAMES if n not in ("LTIB", "RTHI")]
    two = trial(tmp_path / "walk2.trc", seed=2, names=few, n=80)
    assert by_subject([two, one]) == [(1, 0)]
    shared = share([two, one], SETTINGS)
    again = share([one, two], SETTINGS)
    assert shared is not None and again is not None
    assert shared.body.human.xml == again.body.human.xml and shared.files == again.files
    np.testing.assert_array_equal(
        [p.position for p in shared.body.places], [p.position for p in again.body.places]
    )
    runs = [run_fit(path, SETTINGS, shared=shared) for path in (one, two)]
    lengths = [{k: v for k, v in r.figures.items() if k.startswith("length_")} for r in runs]
    assert lengths[0] == lengths[1]
    assert runs[0].figures["mass_kg"] == runs[1].figures["mass_kg"]
    for name, value in OWN.items():
        assert lengths[0][f"length_{name}_m"] == pytest.approx(value, rel=0.03)
    for run, other in zip(runs, ("walk2.trc", "walk1.trc"), strict=True):
        assert run.figures["marker_rms_mean_mm"] < 3.0
        assert any("share lengths" in note and other in note for note in run.record.notes)
        assert other in run.provenance.source_files


def test_others_stay_apart(tmp_path):
    a = trial(tmp_path / "P1.trc")
    trial(tmp_path / "P2.trc", size=1.04)  # people by number, not trials
    b = trial(tmp_path / "P3.trc", seed=3)
    (tmp_path / "day2").mkdir()
    c = trial(tmp_path / "day2" / "P4.trc")
    files = [a, tmp_path / "P2.trc", b, c, tmp_path / "nothing.trc"]
    assert by_subject(files) == [(0, 2)]


def test_the_subject_in_the_file_comes_before_its_name(tmp_path):
    anna, berta = Subject(name="anna"), Subject(name="berta")
    walk = trial(tmp_path / "walk1.c3d", subject=anna)
    run = trial(tmp_path / "run.c3d", subject=anna)
    other = trial(tmp_path / "walk2.c3d", subject=berta)
    assert by_subject([walk, other, run]) == [(2, 0)]


def test_one_trial_on_plates_weighs_all(tmp_path):
    plated = plated_walk()
    walk = plated.walk
    markers = markers_of(walk.human, walk.time, walk.qpos)
    for name in ("walk1", "walk2"):
        write(Recording(tmp_path / f"{name}.trc", markers), tmp_path / f"{name}.trc")
    write(Recording(tmp_path / "f.mot", plates=plated.plates), tmp_path / "walk2_grf.mot")
    paths = [tmp_path / "walk1.trc", tmp_path / "walk2.trc"]
    with patch.object(plate_checks, "MAX_SOLE_DISTANCE", FAR):
        shared = share(paths, FitSettings())
    assert shared is not None
    assert shared.subject.mass == pytest.approx(MASS, rel=0.02)
    run = run_fit(paths[0], FitSettings(), shared=shared)
    assert run.figures["mass_kg"] == shared.subject.mass == shared.body.human.mass
    assert any("force plates measured" in note for note in run.record.notes)
    assert not any("mass is unknown" in note for note in run.record.notes)


def test_two_statures_of_one_subject_are_refused(tmp_path, capsys):
    a = trial(tmp_path / "walk.c3d", subject=Subject(height=1.68), n=40)
    b = trial(tmp_path / "run.c3d", subject=Subject(height=1.50), n=40)
    assert by_subject([a, b]) == []
    out = tmp_path / "out"
    code = cli.main(["fit", str(a), str(b), "--subject", "one", "--out", str(out)])
    assert code == 2 and "--subject each" in capsys.readouterr().err and not out.exists()

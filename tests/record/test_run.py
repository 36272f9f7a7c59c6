"""A Run comes back from its folder as it was saved."""

import os
from dataclasses import fields, replace

import mujoco
import numpy as np
import pytest

import plantigrade
from plantigrade.errors import FileError, RunExists
from plantigrade.io.mot import read_mot
from plantigrade.record import Provenance, Run
from tests.record.test_npz import a_record, same

PROVENANCE = Provenance(
    "plantigrade fit walk.c3d --seed 3",
    {"cutoff_hz": 6.0, "static": None, "lengths": {"thigh": 0.4}},
    {"walk.c3d": "ab" * 32},
    3,
)


def a_run(**changes):
    return Run(
        **{
            "record": a_record(),
            "kind": "fit",
            "title": "Walking",
            "sentence": "A walk was fitted.",
            "status": "residual force is 12 % at 0.3 s",
            "figures": {"marker_error_mm": 4.25, "joints": ["hip"], "known": True},
            "seconds": {"fit": 1.5},
            "provenance": PROVENANCE,
            "others": {"forces": replace(a_record(), signals={}, clock=0.0)},
            **changes,
        }
    )


def test_every_field_comes_back(tmp_path):
    run = a_run()
    saved = run.save(tmp_path / "run", files={"report.html": "<p>"})
    loaded = Run.load(tmp_path / "run")
    assert saved.folder == loaded.folder == tmp_path / "run"
    for field in fields(Run):
        if field.name not in ("folder", "files", "name"):
            same(getattr(run, field.name), getattr(loaded, field.name))
    assert loaded.metrics == saved.metrics and loaded.metrics["version"] == plantigrade.__version__
    assert not loaded.ok


def test_the_folder_serves_other_programs(tmp_path):
    run = a_run().save(tmp_path / "run")
    model = mujoco.MjModel.from_xml_path(str(run.folder / "model.xml"))
    names = [model.joint(i).name for i in range(model.njnt)]
    assert tuple(names) == run.record.motion.joint_names
    table = read_mot(run.folder / "motion.mot").coordinates
    np.testing.assert_allclose(
        table["hip_flexion_l"], run.record.motion["hip_flexion_l"], atol=1e-9
    )


def test_equal_runs_give_equal_bytes(tmp_path):
    a, b = (a_run().save(tmp_path / name, files={"page.html": "x"}).folder for name in "ab")
    assert sorted(os.listdir(a)) == sorted(os.listdir(b))
    for name in os.listdir(a):
        assert (a / name).read_bytes() == (b / name).read_bytes(), name


def test_overwrite_replaces_only_runs(tmp_path):
    run = a_run().save(tmp_path / "run", files={"old.html": "x"})
    with pytest.raises(RunExists, match="--overwrite"):
        a_run().save(run.folder)
    a_run(title="Second").save(run.folder, overwrite=True)
    assert Run.load(run.folder).title == "Second" and not (run.folder / "old.html").exists()
    (run.folder / "notes.txt").write_text("mine")
    with pytest.raises(RunExists, match="also holds notes.txt"):
        a_run().save(run.folder, overwrite=True)


@pytest.mark.parametrize("name", ["model.xml", "motion.npz", "motion.mot", "forces.npz"])
def test_names_of_the_runs_own_files_are_taken(tmp_path, name):
    with pytest.raises(FileError, match="file of every run|not allowed"):
        a_run().save(tmp_path / "run", files={name: "x"})
    assert not (tmp_path / "run").exists()


def test_damaged_and_mislabelled_runs(tmp_path):
    folder = a_run().save(tmp_path / "run").folder
    whole = (folder / "metrics.json").read_text()
    for text, match in (
        (whole.replace('"format": 2', '"format": 1'), "format 1; this version reads format 2"),
        (whole.replace('"kind": "fit"', '"kind": 3'), "names no kind"),
        ("{}", "format 1"),
        ("{", "is not JSON"),
    ):
        (folder / "metrics.json").write_text(text)
        with pytest.raises(FileError, match=match):
            Run.load(folder)
    (folder / "metrics.json").write_text(whole)
    forces = (folder / "forces.npz").read_bytes()
    (folder / "forces.npz").write_bytes(b"x")
    with pytest.raises(FileError, match="forces.npz"):
        Run.load(folder)
    (folder / "forces.npz").write_bytes(forces)
    (folder / "motion.npz").unlink()
    with pytest.raises(FileError, match="motion.npz"):
        Run.load(folder)
    with pytest.raises(FileError, match="no such folder"):
        Run.load(tmp_path / "gone")

import hashlib
import json
import os

import numpy as np
import pytest

import plantigrade
from plantigrade.errors import FileError, RunExists
from plantigrade.io.mot import read_mot
from plantigrade.motion.recording import Table
from plantigrade.record import folder as run_folder
from plantigrade.record.folder import read_run, source_files, write_run
from tests.record.test_npz import a_record, same

MODEL = "<mujoco><worldbody/></mujoco>"
TABLE = Table(("pelvis_tx", "knee_angle_r"), np.array([0.0, 0.1]), np.array([[0, 0.5], [1, 1]]))


def write(out, **more):
    more = {"model_xml": MODEL, "record": a_record(), "metrics": {"speed_m_s": 1.2}, **more}
    return write_run(out, **more)


def test_round_trip(tmp_path):
    out = tmp_path / "deep" / "run"
    metrics = {
        "rms_mm": np.float64(3.5),
        "never": float("nan"),
        "huge": [float("inf"), 1],
        "counts": np.arange(3),
        "settings": {"feet": "rigid", "out": out},
        "seed": np.int64(4),
    }
    assert write(out, metrics=metrics, coordinates=TABLE, files={"report.html": "<p>ä", "b": b"1"})
    model_xml, record, read = read_run(out)
    assert model_xml == MODEL
    same(a_record().motion, record.motion)
    assert record.metrics == read
    assert read["status"] == "ok" and read["version"] == plantigrade.__version__
    assert read["never"] is None and read["huge"] == [None, 1] and read["counts"] == [0, 1, 2]
    assert read["rms_mm"] == 3.5 and read["settings"]["out"] == str(out) and read["seed"] == 4
    assert {"command", "source_files"} <= set(read)
    assert (out / "report.html").read_text(encoding="utf-8") == "<p>ä"
    np.testing.assert_allclose(
        read_mot(out / "motion.mot").coordinates.values, TABLE.values, atol=1e-9
    )
    assert os.listdir(tmp_path / "deep") == ["run"]
    json.loads((out / "metrics.json").read_text(), parse_constant=pytest.fail)


def test_existing_is_refused_or_replaced(tmp_path):
    out = write(tmp_path / "run", files={"old.txt": "x"})
    with pytest.raises(RunExists, match="--overwrite"):
        write(out)
    assert (out / "old.txt").exists()
    write(out, metrics={"speed_m_s": 2.0}, overwrite=True)
    assert not (out / "old.txt").exists()
    assert read_run(out)[2]["speed_m_s"] == 2.0
    assert os.listdir(tmp_path) == ["run"]


def test_other_folders_are_never_replaced(tmp_path):
    home = tmp_path / "home"
    home.mkdir()
    (home / "thesis.txt").write_text("x")
    with pytest.raises(RunExists, match="not a run folder"):
        write(home, overwrite=True)
    with pytest.raises(RunExists, match="not a folder"):
        write(home / "thesis.txt", overwrite=True)
    (tmp_path / "link").symlink_to(home)
    with pytest.raises(RunExists):
        write(tmp_path / "link", overwrite=True)
    assert (home / "thesis.txt").read_text() == "x"
    (tmp_path / "empty").mkdir()
    assert read_run(write(tmp_path / "empty", overwrite=True))


@pytest.mark.parametrize("fault", [OSError(28, "No space left on device"), KeyboardInterrupt()])
@pytest.mark.parametrize("overwrite", [False, True])
def test_interrupted_writing_leaves_nothing(tmp_path, monkeypatch, fault, overwrite):
    out = tmp_path / "run"
    if overwrite:
        write(out)

    def fail(*_):
        raise fault

    monkeypatch.setattr(run_folder, "write_npz", fail)
    with pytest.raises(FileError if isinstance(fault, OSError) else KeyboardInterrupt):
        write(out, overwrite=overwrite, metrics={"speed_m_s": 9.0})
    assert os.listdir(tmp_path) == (["run"] if overwrite else [])
    if overwrite:
        assert read_run(out)[2]["speed_m_s"] == 1.2


def test_failed_rename_brings_the_old_one_back(tmp_path, monkeypatch):
    out = write(tmp_path / "run")
    rename = run_folder.Path.rename

    def fail(self, target):
        if self.name.endswith(".part"):
            raise OSError(5, "Input/output error")
        return rename(self, target)

    monkeypatch.setattr(run_folder.Path, "rename", fail)
    with pytest.raises(FileError, match="Input/output error"):
        write(out, overwrite=True, metrics={"speed_m_s": 9.0})
    assert read_run(out)[2]["speed_m_s"] == 1.2
    assert os.listdir(tmp_path) == ["run"]


def test_unwritable_place(tmp_path):
    (tmp_path / "file").write_text("x")
    with pytest.raises(FileError, match=r"cannot be written.*--out"):
        write(tmp_path / "file" / "run")
    for name in ("../up.html", "metrics.json", ".hidden", "a/b"):
        with pytest.raises(FileError, match="not a name"):
            write(tmp_path / "run", files={name: "x"})


def test_read_says_what_is_wrong(tmp_path):
    with pytest.raises(FileError, match="no such folder"):
        read_run(tmp_path / "gone")
    with pytest.raises(FileError, match=r"not a run folder: model.xml, motion.npz, metrics.json"):
        read_run(tmp_path)
    out = write(tmp_path / "run")
    (out / "metrics.json").write_text('{"a": 1,\n"b": }')
    with pytest.raises(FileError, match=r"metrics.json: line 2: is not JSON"):
        read_run(out)
    (out / "metrics.json").write_text("[1]")
    with pytest.raises(FileError, match="no object"):
        read_run(out)
    (out / "motion.npz").write_bytes(b"x")
    (out / "metrics.json").write_text("{}")
    with pytest.raises(FileError, match="motion.npz"):
        read_run(out)


def test_source_files(tmp_path):
    for folder in "ab":
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "walk.c3d").write_bytes(folder.encode())
    (tmp_path / "static.c3d").write_bytes(b"")
    sums = source_files([tmp_path / "a/walk.c3d", tmp_path / "b/walk.c3d", tmp_path / "static.c3d"])
    assert sums["static.c3d"] == hashlib.sha256(b"").hexdigest()
    assert sums["a/walk.c3d"] == hashlib.sha256(b"a").hexdigest()
    assert len(sums) == 3
    with pytest.raises(FileError, match="cannot be read"):
        source_files([tmp_path / "gone.c3d"])

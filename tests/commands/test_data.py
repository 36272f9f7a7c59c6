"""``plantigrade data``: each recording is listed with what it holds, each fault with its reason."""

import json
import pickle

import numpy as np
import pytest

from plantigrade.commands.main import main
from plantigrade.io import write
from plantigrade.motion import Markers, Recording


@pytest.fixture
def folder(tmp_path):
    """A folder with a recording in a subfolder, a broken one and a text that is none."""
    (tmp_path / "day").mkdir()
    path = tmp_path / "day" / "walk.trc"
    markers = Markers(("HEEL", "HEAD"), np.arange(101) / 100, np.ones((101, 2, 3)))
    write(Recording(path, markers=markers), path)
    (tmp_path / "broken.c3d").write_bytes(b"\x02\x50" + b"\xff" * 1000)
    (tmp_path / "notes.md").write_text("# Monday")
    return tmp_path


def test_listing(folder, capsys):
    assert main(["data", str(folder)]) == 0
    first, second, last = capsys.readouterr().out.splitlines()
    assert first == "day/walk.trc  TRC  2 markers, 101 frames, 1.00 s"
    assert second.startswith("broken.c3d: cannot be read: ")
    assert last == f"{folder}: 1 recordings, 1 that cannot be read, 1 other files"


def test_a_folder_without_recordings_says_where_there_are_some(tmp_path, capsys):
    assert main(["data", "list", str(tmp_path)]) == 0
    assert capsys.readouterr().out.endswith("  public recordings    plantigrade data get\n")


def test_json(folder, capsys):
    assert main(["data", str(folder), "--json"]) == 0
    metrics = json.loads(capsys.readouterr().out)
    assert metrics["n_recordings"] == metrics["n_unreadable"] == metrics["n_other_files"] == 1
    (walk,) = metrics["recordings"]
    assert walk["n_markers"] == 2 and walk["duration_s"] == pytest.approx(1.0)


def test_one_file(folder, capsys):
    assert main(["data", str(folder / "day" / "walk.trc")]) == 0
    assert "2 markers" in capsys.readouterr().out


def test_no_such_folder(tmp_path, capsys):
    assert main(["data", str(tmp_path / "nowhere")]) == 2
    assert "does not exist" in capsys.readouterr().err


def test_motions_of_smpl_are_recognised_and_foreign_pickles_are_not(tmp_path, capsys):
    """Poses among policies and pickles of other programs, and one with a call in it."""
    arrays = {"poses": np.zeros((3, 72)), "trans": np.zeros((3, 3)), "mocap_framerate": 60.0}
    np.savez(tmp_path / "a.npz", **arrays)
    (tmp_path / "b.pkl").write_bytes(pickle.dumps(arrays))
    (tmp_path / "c.pkl").write_bytes(pickle.dumps({"weights": [1.0]}))
    (tmp_path / "d.pkl").write_bytes(pickle.dumps({"poses": print}))
    assert main(["data", str(tmp_path)]) == 0
    first, second, third, last = capsys.readouterr().out.splitlines()
    held = "SMPL  22 joints of another skeleton, 3 frames, 0.03 s"
    assert (first, second) == (f"a.npz  {held}", f"b.pkl  {held}")
    assert third.startswith("d.pkl: cannot be read: names builtins.print, and only arrays")
    assert last.endswith("2 recordings, 1 that cannot be read, 1 other files")
    assert main(["fit", str(tmp_path / "d.pkl")]) == 2
    assert capsys.readouterr().err.startswith(f"error: {tmp_path / 'd.pkl'}: names builtins.print")


@pytest.mark.parametrize(
    "part", ["c3d", "cmu_bvh", "opensim/rajagopal_walk", pytest.param(".", marks=pytest.mark.slow)]
)
def test_every_recording_of_the_collection(data, capsys, part):
    assert main(["data", str(data / part), "--json"]) == 0
    metrics = json.loads(capsys.readouterr().out)
    listed = {entry["file"] for entry in metrics["recordings"]}
    kinds = {"c3d", "trc", "amc", "bvh"}
    on_disk = {
        str(path.relative_to(data / part)) for k in kinds for path in (data / part).rglob(f"*.{k}")
    }
    assert on_disk and on_disk <= listed

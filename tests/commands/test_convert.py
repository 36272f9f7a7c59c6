"""``plantigrade convert``: what is written, what is refused, what is left behind."""

import json
from pathlib import Path

import numpy as np
import pytest

from plantigrade.commands.main import main
from plantigrade.io import read, write
from plantigrade.models import Human
from plantigrade.motion import ForcePlate, Markers, Motion, Recording
from plantigrade.record import Record, Run


@pytest.fixture
def walk(tmp_path) -> Path:
    """A C3D file of two markers that move forward and a plate that carries 700 N."""
    time = np.arange(50) / 100
    forward = np.zeros((50, 2, 3))
    forward[:, :, 0] = 0.1 + 1.2 * time[:, None]  # 1.2 m/s
    forward[:, 1, 2] = 1.0
    plate = ForcePlate(
        name="1",
        time=time,
        force=np.tile([0.0, 0.0, 700.0], (50, 1)),
        cop=np.tile([0.1, 0.0, 0.0], (50, 1)),
        free_moment=np.zeros(50),
        corners=np.array([[0.3, 0.2, 0], [0.3, -0.2, 0], [-0.3, -0.2, 0], [-0.3, 0.2, 0.0]]),
    )
    path = tmp_path / "walk.c3d"
    write(Recording(path, markers=Markers(("HEEL", "HEAD"), time, forward), plates=(plate,)), path)
    return path


def test_markers_and_forces_survive(walk, tmp_path, capsys):
    target = tmp_path / "walk.trc"
    assert main(["convert", str(walk), str(target)]) == 0
    out, err = capsys.readouterr()
    assert out == f"wrote {target} and {tmp_path / 'walk_grf.mot'}\n"
    assert "walk_grf.mot" in err
    markers = read(target).markers
    speed = np.gradient(markers.positions[:, 0, 0], markers.time)
    np.testing.assert_allclose(speed, 1.2, atol=1e-3)
    (plate,) = read(tmp_path / "walk_grf.mot").plates
    np.testing.assert_allclose(plate.force[:, 2], 700, rtol=1e-3)


def test_nothing_existing_is_replaced(walk, tmp_path, capsys):
    forces = tmp_path / "walk_grf.mot"
    forces.write_text("mine")
    assert main(["convert", str(walk), str(tmp_path / "walk.trc")]) == 2
    assert "walk_grf.mot exists" in capsys.readouterr().err
    assert forces.read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["walk.c3d", "walk_grf.mot"]


def test_overwrite_replaces(walk, tmp_path):
    target = tmp_path / "walk.trc"
    target.write_text("old")
    assert main(["convert", str(walk), str(target), "--overwrite"]) == 0
    assert read(target).markers.names == ("HEEL", "HEAD")


@pytest.mark.parametrize(
    ("target", "sentence"),
    [
        ("walk.bvh", "BVH files store skeleton"),
        ("walk.docx", "'.docx' cannot be written"),
        ("no/such/walk.trc", "there is no folder"),
    ],
)
def test_what_cannot_be_written_leaves_nothing(walk, tmp_path, target, sentence, capsys):
    assert main(["convert", str(walk), str(tmp_path / target)]) == 2
    err = capsys.readouterr().err
    assert sentence in err and str(tmp_path / target) in err
    assert ".plantigrade-" not in err
    assert [path.name for path in tmp_path.iterdir()] == ["walk.c3d"]


def test_an_option_the_format_has_not_is_refused(walk, tmp_path, capsys):
    assert main(["convert", str(walk), str(tmp_path / "walk.trc"), "--rate", "120"]) == 2
    assert "no option 'rate'" in capsys.readouterr().err


def test_json(walk, tmp_path, capsys):
    assert main(["convert", str(walk), str(tmp_path / "walk.trc"), "--json"]) == 0
    metrics = json.loads(capsys.readouterr().out)
    assert metrics["status"] == "ok"
    assert metrics["target_files"] == [str(tmp_path / n) for n in ("walk.trc", "walk_grf.mot")]


def test_source_is_never_replaced(tmp_path):
    """A format keeps less than what was read, so a recording is not written over itself."""
    path = tmp_path / "walk.csv"
    path.write_text("time,a_x,a_y,a_z\n0,1,2,3\n0.01,1,2,3\n")
    before = path.read_bytes()
    (tmp_path / "link.csv").symlink_to(path)
    for target in (path, tmp_path / "link.csv"):
        assert main(["convert", str(path), str(target), "--overwrite"]) == 2
    assert path.read_bytes() == before


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    """The folder of a run: somebody who stands, hence without gait cycles."""
    human = Human.create()
    time = np.arange(5) / 100
    qpos = np.tile(human.standing(), (5, 1))
    motion = Motion(time, qpos, np.zeros((5, human.model.nv)), human.joint_names)
    made = Run(Record(human, motion), "simulate").save(tmp_path_factory.mktemp("run") / "stand")
    return made.folder


def test_a_run_becomes_a_file_of_another_program(run, tmp_path, capsys):
    target = tmp_path / "stand.csv"
    assert main(["convert", str(run), str(target)]) == 0
    assert capsys.readouterr().out == f"wrote {target}\n"
    assert target.read_text().startswith("time_s,pelvis_tilt_deg,")


@pytest.mark.parametrize(
    ("target", "options", "sentence"),
    [
        ("stand.docx", [], "extension '.docx' — use one of .csv"),
        ("stand.csv", ["--over", "mean"], "no complete gait cycle"),
        ("stand.csv", ["--rate", "100"], "the export to CSV has no option 'rate'"),
    ],
)
def test_what_a_run_cannot_become_leaves_nothing(run, tmp_path, target, options, sentence, capsys):
    assert main(["convert", str(run), str(tmp_path / target), *options]) == 2
    assert sentence in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("target", ["walk.glb", "walk.bvh"])
def test_a_source_that_is_not_there_is_named(tmp_path, monkeypatch, capsys, target):
    monkeypatch.chdir(tmp_path)
    assert main(["convert", "nowhere", target, "--overwrite"]) == 2
    assert "nowhere: there is no such file or run folder" in capsys.readouterr().err

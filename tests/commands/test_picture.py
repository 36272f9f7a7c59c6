"""``plantigrade picture``: a file beside the run or elsewhere, and what is refused."""

import json
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from plantigrade.commands import main as cli
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record, Run


@pytest.fixture
def run(tmp_path):
    """A run folder of a person who stands."""
    human = Human.create(1.7, 65.0, feet="multi-segment")
    qpos = np.tile(human.standing(), (40, 1))
    motion = Motion(np.arange(40) / 20, qpos, np.zeros((40, human.model.nv)), human.joint_names)
    return Run(Record(human, motion), "fit", figures={"frames": 40}).save(tmp_path / "run").folder


def test_it_lies_in_the_run_and_is_one_of_its_files(run, capsys):
    assert cli.main(["picture", str(run)]) == 0
    assert str(run / "picture.svg") in capsys.readouterr().out
    ET.parse(run / "picture.svg")
    assert "picture.svg" in json.loads((run / "metrics.json").read_text())["files"]
    assert cli.main(["picture", str(run)]) == 0  # its own picture may be drawn anew
    Run.load(run).save(run, overwrite=True)  # and the run may still be replaced


def test_equal_runs_give_equal_pictures(run, tmp_path):
    for name in ("a.svg", "b.svg"):
        assert cli.main(["picture", str(run), "--out", str(tmp_path / name)]) == 0
    assert (tmp_path / "a.svg").read_bytes() == (tmp_path / "b.svg").read_bytes()


def test_json_says_what_was_drawn(run, capsys):
    assert cli.main(["picture", str(run), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["frames"] > 20 and facts["seconds"] > 1.0 and facts["loop"] is False


def test_a_strip_of_instants(run, capsys):
    assert cli.main(["picture", str(run), "--still", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["frames"] == 8
    text = (run / "picture.svg").read_text(encoding="utf-8")
    assert "animate" not in text and text.count('<g transform="translate(') == 8
    for words in (["--view", "front"], ["--start", "0", "--stop", "0.5"]):
        assert cli.main(["picture", str(run), "--still", *words]) == 0
        assert (run / "picture.svg").read_text(encoding="utf-8") != text


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (["--out", "picture.png"], "ending in .svg"),
        (["--out", "picture"], "ending in .svg"),
        (["--out", "nowhere/picture.svg"], "no folder"),
        (["--still", "--foot", "left"], "--foot has no effect with --still"),
        (["--still", "--start", "9", "--stop", "8"], "not within this motion"),
        (["--still", "--speed", "0.5"], "--speed has no effect with --still"),
        (["--start", "0"], ""),
        (["--start", "5"], "not within this motion"),
        (["--speed", "0"], "speed must be 0.05"),
        (["--height-px", "99999999"], "height_px"),
        (["--still", "--height-px", "-3"], "height_px"),
    ],
)
def test_bad_input_ends_in_one_sentence(run, words, complaint, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    before = {p.name: p.read_bytes() for p in run.iterdir()}
    code = cli.main(["picture", str(run), *words])
    if not complaint:
        assert code == 0
        return
    error = capsys.readouterr().err
    assert code == 2 and complaint in error and len(error.splitlines()) == 1
    assert {p.name: p.read_bytes() for p in run.iterdir()} == before
    assert [p.name for p in tmp_path.iterdir()] == ["run"]


def test_a_file_is_not_replaced_by_default(run, tmp_path, capsys):
    other = tmp_path / "mine.svg"
    other.write_text("mine")
    assert cli.main(["picture", str(run), "--out", str(other)]) == 2
    assert "--overwrite" in capsys.readouterr().err and other.read_text() == "mine"
    assert cli.main(["picture", str(run), "--out", str(other), "--overwrite"]) == 0
    assert other.read_text().startswith("<svg")


def test_what_is_no_run_is_refused(tmp_path, capsys):
    assert cli.main(["picture", str(tmp_path)]) == 2
    assert "not a run folder" in capsys.readouterr().err

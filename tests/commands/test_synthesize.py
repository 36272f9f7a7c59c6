"""``plantigrade synthesize`` as a user calls it: what it prints, writes and refuses."""

import json
import signal

import pytest

from plantigrade.commands import main as cli
from plantigrade.commands.progress import Progress
from plantigrade.commands.synthesize import Command, Watch, told_words
from plantigrade.errors import ParameterError
from tests.conftest import QUICK_WALK

FILES = {
    "model.xml", "motion.npz", "motion.mot", "metrics.json", "report.html", "viewer.html",
    "synthesis.npz",
}  # fmt: skip
PERSON = ["--height", "1.7", "--mass", "65", "--joints", "42", "--basis", "polynomial"]


def test_a_warm_start_writes_its_folder(synthesized, tmp_path, capsys):
    warm, out = str(synthesized[1]), tmp_path / "walk"
    task = tmp_path / "mine.toml"
    task.write_text(QUICK_WALK)
    words = [
        str(task),
        "--periodic",
        "--speed",
        "1",
        *PERSON,
        "--nodes-per-second",
        "28",
        "--warm",
        warm,
    ]
    code = cli.main(["synthesize", *words, "--strides", "1", "--out", str(out), "--json"])
    printed = capsys.readouterr()
    assert code == 0, printed.err
    metrics = json.loads(printed.out)
    assert metrics == json.loads((out / "metrics.json").read_text())
    assert metrics["status"] == "ok" and metrics["settings"]["warm"] == warm
    assert set(metrics["source_files"]) == {"mine.toml"}
    assert metrics["iterations"] < synthesized[0].metrics["iterations"]
    assert metrics["objective"] == pytest.approx(synthesized[0].metrics["objective"], rel=1e-3)
    assert {p.name for p in out.iterdir()} == FILES
    half = synthesized[0].metrics["duration_s"] / 2
    assert metrics["duration_s"] == pytest.approx(half)
    assert "iterations, " in printed.err and "passed the check" in printed.err
    assert cli.main(["synthesize", *words, "--out", str(out)]) == 2  # it is there
    assert "--overwrite" in capsys.readouterr().err


def test_an_interrupted_run_is_checked_and_written(synthesized, tmp_path, capsys, monkeypatch):
    """The first guess, which nobody should take for a walk."""
    ask = lambda self, stage, iterate: True  # noqa: E731
    monkeypatch.setattr(Watch, "__call__", ask)
    out = tmp_path / "guess"
    words = ["walk", "--periodic", *PERSON, "--strides", "1", "--nodes-per-second", "15"]
    assert cli.main(["synthesize", *words, "--out", str(out)]) == 3
    printed = capsys.readouterr()
    assert "DID NOT PASS" in printed.out
    assert "the solver was stopped" in printed.err and "of body weight" in printed.err
    assert {p.name for p in out.iterdir()} == FILES
    metrics = json.loads((out / "metrics.json").read_text())
    assert metrics["status"] != "ok" and metrics["broken_rows"]
    page = (out / "report.html").read_text("utf-8")
    assert "What the checker found" in page and "What the solver could not keep" in page


@pytest.mark.parametrize(
    ("words", "match"),
    [
        (["hop"], "no task 'hop'"),
        (["walk", "--jump-height", "0.3"], "--jump-height means nothing to walk"),
        (["squat", "--speed", "1"], "--speed means nothing to squat; it knows --duration, --depth"),
        (["walk", "--speed", "9"], "9"),
        (["walk", "--tries", "0"], "tries=0"),
        (["walk", "--steps", "0"], "steps=0"),
        (["walk", "--speed", "0"], "speed=0"),
        (["walk", "--start", "1"], "--start belongs to the task track alone"),
        (["track"], "track needs --recording FILE"),
        (["track", "--recording", "none.c3d", "--speed", "1"], "--speed means nothing to track"),
        (["squat", "--free-timing"], "only a periodic walk chooses its own times"),
        (["walk", "--nodes-per-second", "1"], "nodes_per_second=1"),
        (["walk", "--warm", "nowhere"], "synthesize"),
        (["none.toml"], "none.toml"),
        (["walk", "--tell", "speed"], "NAME=VALUE"),
        (["walk", "--solver", "snopt"], "snopt"),
    ],
)
def test_what_makes_no_sense_is_refused(words, match, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["synthesize", *words]) == 2
    assert match in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_task_file_and_options_over_it(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('[task]\nbase = "jump"\n[parameters]\nheight = 0.2\ndepth = 0.3\n')
    settings, name = Command(task=str(path), mass=50.0, jump_height=0.1).settings()
    assert (name, settings.task, settings.mass) == ("mine", "jump", 50.0)
    assert settings.parameters == {"height": 0.1} and "depth = 0.3" in settings.file
    turning, _ = Command(task="walk", turn=90.0).settings()
    assert turning.parameters == {"turn": pytest.approx(1.5707963)}


def test_words_for_anything_else_a_task_may_be_told():
    assert told_words(("side=l", "target=[0.5, 0, 1.2]")) == {"side": "l", "target": [0.5, 0, 1.2]}
    with pytest.raises(ParameterError, match="NAME=VALUE"):
        told_words(("=3",))


def test_the_first_interrupt_stops_with_the_best_the_second_gives_up(synthesized, capsys):
    before = signal.getsignal(signal.SIGINT)
    iterate = synthesized[2][0][1]
    watch = Watch(Progress())
    with watch.listening():
        assert watch("first try", iterate) is False
        signal.raise_signal(signal.SIGINT)
        assert watch("first try", iterate) is True
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before
    assert "best so far" in capsys.readouterr().err

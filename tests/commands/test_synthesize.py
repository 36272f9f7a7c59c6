"""``plantigrade synthesize`` as a user calls it: what it prints, writes and refuses."""

import json
import signal
from pathlib import Path

import numpy as np
import pytest

from plantigrade.commands import main as cli
from plantigrade.commands.progress import Progress, SolverProgress
from plantigrade.commands.synthesize import SUBCOMMANDS, parse
from tests.conftest import QUICK_WALK

FILES = {
    "model.xml", "motion.npz", "motion.mot", "metrics.json", "report.html", "viewer.html",
}  # fmt: skip
PERSON = ["--height", "1.7", "--mass", "65", "--joints", "42", "--basis", "polynomial"]


@pytest.mark.slow
def test_a_warm_start_writes_its_folder(synthesized, tmp_path, capsys):
    warm, out = str(synthesized.run.folder), tmp_path / "walk"
    task = tmp_path / "mine.toml"
    task.write_text(QUICK_WALK)
    words = [str(task), "--periodic", "--speed", "1", *PERSON, "--nodes-per-second", "28"]
    words += ["--warm", warm]
    code = cli.main(["synthesize", *words, "--strides", "1", "--out", str(out), "--json"])
    printed = capsys.readouterr()
    assert code == 0, printed.err
    metrics, cold = json.loads(printed.out), synthesized.run.figures
    written = json.loads((out / "metrics.json").read_text())
    assert metrics == written
    assert metrics["status"] == "ok" and metrics["settings"]["warm"] == warm
    assert set(metrics["source_files"]) == {"mine.toml"}
    assert metrics["iterations"] < cold["iterations"]
    assert metrics["objective"] == pytest.approx(cold["objective"], rel=1e-3)
    assert FILES <= {p.name for p in out.iterdir()} and not (out / "synthesis.npz").exists()
    assert metrics["duration_s"] == pytest.approx(cold["duration_s"] / 2)
    assert "iterations, " in printed.err and "check passed" in printed.err
    assert cli.main(["synthesize", *words, "--out", str(out)]) == 2  # it is there
    assert "--overwrite" in capsys.readouterr().err


def test_an_interrupted_run_is_checked_and_written(tmp_path, capsys, monkeypatch):
    """The first guess, which nobody should take for a walk."""
    ask = lambda self, stage, iterate: True  # noqa: E731
    monkeypatch.setattr(SolverProgress, "__call__", ask)
    out = tmp_path / "guess"
    words = ["walk", "--periodic", *PERSON, "--strides", "1", "--nodes-per-second", "15"]
    assert cli.main(["synthesize", *words, "--out", str(out)]) == 3
    printed = capsys.readouterr()
    assert "CHECK FAILED" in printed.out
    assert "The solver was stopped" in printed.err and "of body weight" in printed.err
    assert FILES <= {p.name for p in out.iterdir()}
    metrics = json.loads((out / "metrics.json").read_text())
    assert metrics["status"] != "ok" and metrics["violations"]


@pytest.mark.parametrize(
    ("words", "match"),
    [
        (["dance"], "no task 'dance'"),
        (["walk", "--jump-height", "0.3"], "--jump-height"),
        (["squat", "--speed", "1"], "--speed"),
        (["walk", "--speed", "9"], "speed must be 0.3–2.2 m/s for walking, not 9"),
        (["walk", "--slope", "30"], "slope must be -20–20 degrees for walking, not 30"),
        (["walk", "--restarts", "0"], "restarts must be"),
        (["walk", "--steps", "0"], "steps must be"),
        (["walk", "--start", "1"], "--start"),
        (["track"], "--recording"),
        (["track", "none.c3d"], "none.c3d: there is no such file"),
        (["track", "a.c3d", "--recording", "b.c3d"], "'a.c3d' stands before --recording"),
        (["walk", "none.c3d"], "walk takes options only, not 'none.c3d'"),
        (["track", "--recording", "none.c3d", "--speed", "1"], "--speed"),
        (["squat", "--optimise-timing"], "--optimise-timing"),
        (["walk", "--seed", "3"], "seed has no effect without restarts"),
        (["walk", "--seed", "-1", "--restarts", "2"], "seed must be a whole number from 0"),
        (["track", "--recording", "none.c3d", "--seed", "1"], "--seed"),
        (["zhakatayev2023", "--seed", "1"], "--seed"),
        (["walk", "--periodic", "--optimise-timing", "--restarts", "2"], "restarts has no effect"),
        (["walk", "--periodic", "--optimise-timing", "--warm", "."], "warm has no effect"),
        (["walk", "--optimise-timing"], "optimise_timing needs periodic"),
        (["squat", "--free-time", "depth=0.1:0.3"], "no time 'depth'"),
        (["squat", "--free-time", "duration"], "write NAME=LEAST:MOST"),
        (["squat", "--free-time", "duration=2"], "write NAME=LEAST:MOST"),
        (["squat", "--free-time", "duration=3:2"], "leave no room"),
        (["squat", "--free-time", "duration=3:4"], "guess 2.5 must lie from 3 to 4"),
        (["squat", "--free-time", "duration=0:4"], "duration must be 0.6–20 s"),
        (["squat", *2 * ("--free-time", "duration=1:4")], "given twice"),
        (["squat", "--free-time", "duration=1:4", "--solver", "ipopt"], "solver has no effect"),
        (["walk", "--nodes-per-second", "1"], "nodes_per_second must be"),
        (["walk", "--warm", "nowhere"], "nowhere"),
        (["none.toml"], "none.toml"),
        (["walk", "--solver", "snopt"], "snopt"),
        (["zhakatayev2023", "--motion", "squat"], "squat"),
        (["zhakatayev2023", "--warm", "x"], "--warm"),
        (["--speed", "1"], "must come after the task"),
    ],
)
def test_what_makes_no_sense_is_refused(words, match, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["synthesize", *words]) == 2
    said = " ".join(line.strip("│ ") for line in capsys.readouterr().err.splitlines())
    assert match in said
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("task", SUBCOMMANDS)
def test_help_of_a_task_has_its_own_options_and_no_others(task, capsys):
    assert cli.main(["synthesize", task, "--help"]) == 0
    shown = capsys.readouterr().out
    assert f"usage: plantigrade synthesize {task}" in shown
    owner = {
        "--speed": {"walk", "walk-backward", "walk-sideways", "run"}, "--hop-height": {"hop"},
        "--jump-height": {"jump"}, "--recording": {"track"},
        "--seat-off": {"sit-to-stand", "stand-to-sit"}, "--motion": {"zhakatayev2023"},
        "--target": {"reach"}, "--clearance": {"side-step"},
    }  # fmt: skip
    for option, tasks in owner.items():
        assert (f"{option} " in shown) == (task in tasks), option
    for option in ("--height", "--out", "--json", "--quiet"):
        assert option in shown


def test_a_task_file_and_options_over_it(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('[task]\nbase = "jump"\n[parameters]\njump_height = 0.2\ndepth = 0.3\n')
    command = parse([str(path), "--mass", "50", "--jump-height", "0.25"])
    assert (command.name, command.mass, command.file) == ("mine", 50.0, path)
    assert (command.jump_height, command.depth) == (0.25, 0.3)  # 0.25 is the default, and asked for
    turning = parse(["walk", "--turn", "90"])
    assert turning.turn == pytest.approx(np.pi / 2)


def test_recordings_to_track_need_no_option():
    command = parse(["track", "a.c3d", "b.c3d", "--mass", "70"])
    assert command.recording == (Path("a.c3d"), Path("b.c3d")) and command.mass == 70.0


def test_a_folder_that_has_the_name_of_a_task_does_not_hide_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("lift").mkdir()
    assert parse(["lift", "-o", "lifted"]).out == Path("lifted")


def test_the_first_interrupt_stops_with_the_best_the_second_gives_up(synthesized, capsys):
    before = signal.getsignal(signal.SIGINT)
    iterate = synthesized.iterations[0][1]
    watch = SolverProgress(Progress())
    with watch.listening():
        assert watch("first try", iterate) is False
        signal.raise_signal(signal.SIGINT)
        assert watch("first try", iterate) is True
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is before
    assert "best solution so far" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words, complaint",
    [
        (["walk", "--port", "8081"], "need --live"),
        (["walk", "--no-open"], "need --live"),
        (["walk", "--live", "--vary", "speed", "1", "1.2"], "batch"),
        (["walk", "--live", "--restarts", "2"], "too long"),
        (["walk", "--live", "--periodic", "--optimise-timing"], "too long"),
        (["squat", "--live", "--free-time", "duration=1:4"], "too long"),
        (["walk", "--live", "--port", "0"], "port"),
        (["track", "--live"], "live"),
    ],
)
def test_what_does_not_go_with_a_live_page(capsys, words, complaint):
    assert cli.main(["synthesize", *words]) == 2
    assert complaint in capsys.readouterr().err

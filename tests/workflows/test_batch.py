"""Many simulations: every combination once, one table, taken up where it was left."""

import csv
import io
import json
import shutil

import pytest

import plantigrade as pg
from plantigrade.commands import main as cli
from plantigrade.errors import ParameterError, PlantigradeError, RunExists
from plantigrade.record.jobs import run_jobs
from plantigrade.world import StablePD

SMALL = {"duration": 0.05, "rate": 300.0, "joints": "42", "feet": "rigid"}
WORDS = ["--duration", "0.05", "--rate", "300", "--joints", "42", "--feet", "rigid"]
PUSHES = [None, "300,0.02,0,0"]


def still(state):
    """Hold on."""
    return StablePD(state.angles)


def faulty(state):
    """Break in the middle."""
    if state.time > 0.02:
        raise RuntimeError("out of breath")
    return None


def test_every_combination_is_simulated_and_one_that_breaks_does_not_end_the_others():
    said = []
    batch = pg.simulate_many(
        vary={"push": PUSHES, "controller": ["posture", still, faulty]}, say=said.append, **SMALL
    )
    varied = [(one.varied["push"], one.varied["controller"]) for one in batch.members]
    words = ("none", "300,0.02,0,0")
    assert varied == [(p, c) for p in words for c in ("posture", "still", "faulty")]
    broken = [one for one in batch.members if one.problem]
    assert {one.varied["controller"] for one in broken} == {"faulty"} and len(broken) == 2
    assert "out of breath" in broken[0].problem and broken[0].run is None
    assert batch.status == "2 of 6 simulations failed or diverged" and batch.on_feet == 4
    assert len(said) == 6 and said[-1].startswith("6 of 6: ")
    pushed = batch.members[3].run
    assert pushed.record.signals["world.push"].any()
    assert "world.push" not in batch.members[0].run.record.signals


def test_a_batch_goes_on_where_it_was_left(tmp_path):
    out, said = tmp_path / "batch", []
    how = {"vary": {"push": PUSHES}, "seeds": 2, "out": out, "say": said.append, **SMALL}
    first = pg.simulate_many(**how)
    names = [one.name for one in first.members]
    assert names[3] == "3-push-300-0.02-0-0-seed-1" and first.members[3].metrics["seed"] == 1
    table = (out / "batch.csv").read_text("utf-8")
    rows = list(csv.DictReader(io.StringIO(table)))
    assert [row["name"] for row in rows] == names and rows[0]["on_feet"] == "True"
    assert (out / "batch.html").read_text("utf-8").count("300,0.02,0,0") >= 2
    assert pg.load_run(out / names[2]).record.signals["world.push"].any()

    (out / "batch.csv").unlink()
    shutil.rmtree(out / names[1])
    before = (out / names[0] / "metrics.json").stat().st_mtime_ns
    said.clear()
    pg.simulate_many(**how).finish()
    assert said == ["3 of 4 were there", f"4 of 4: {names[1]}: on the feet"]
    assert (out / names[0] / "metrics.json").stat().st_mtime_ns == before
    again = list(csv.DictReader(io.StringIO((out / "batch.csv").read_text("utf-8"))))
    for row in (*rows, *again):
        row.pop("seconds")
    assert again == rows

    with pytest.raises(RunExists, match="another batch"):
        pg.simulate_many(**{**how, "seeds": 1}).finish()
    assert len(pg.simulate_many(**{**how, "seeds": 1, "overwrite": True}).members) == 2
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "letter.txt").write_text("dear")
    with pytest.raises(RunExists):
        pg.simulate_many(**{**how, "out": tmp_path / "mine", "overwrite": True})
    assert (tmp_path / "mine" / "letter.txt").read_text() == "dear"


def test_a_batch_is_not_replaced_where_somebody_put_files_into_it(tmp_path):
    """Into the folder of the batch, hidden ones too; into a member; or as a folder of results."""
    out = tmp_path / "batch"
    how = {"vary": {"push": PUSHES}, "out": out, **SMALL}
    names = [one.name for one in pg.simulate_many(**how).members]
    for place in (out / ".git", out / names[0] / "notes", out / "figures"):
        place.mkdir()
        (place / "letter.txt").write_text("dear")
        if place.name == "figures":
            (place / "metrics.json").write_text('{"format": 2, "files": ["letter.txt"]}')
        with pytest.raises(RunExists, match="letter.txt"):
            pg.simulate_many(**{**how, "seeds": 2, "overwrite": True})
        assert (place / "letter.txt").read_text() == "dear"
        shutil.rmtree(place)
    assert len(pg.simulate_many(**{**how, "seeds": 2, "overwrite": True}).members) == 4


def test_a_batch_whose_metrics_were_cut_off_is_taken_up(tmp_path):
    out = tmp_path / "batch"
    how = {"vary": {"push": PUSHES}, "out": out, **SMALL}
    whole = pg.simulate_many(**how)
    whole.finish()
    text = (out / "metrics.json").read_text("utf-8")
    (out / "metrics.json").write_text(text[: len(text) // 2])
    said = []
    again = pg.simulate_many(**how, say=said.append)
    assert [one.row() for one in again.members] == [one.row() for one in whole.members]
    assert said == ["2 of 2 were there"]
    assert json.loads((out / "metrics.json").read_text("utf-8")) == json.loads(text)
    (out / "metrics.json").write_text(text[: len(text) // 2])
    with pytest.raises(RunExists, match=r"duration 0.05, not 0.06"):
        pg.simulate_many(**{**how, "duration": 0.06})


def test_on_the_command_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["simulate", *WORDS, "--vary", "ground", "flat", "slope:5", "--vary", "stiffness", "1",
             "2", "--json"]  # fmt: skip
    assert cli.main(words) == 0
    out, err = capsys.readouterr()
    metrics = json.loads(out)
    assert metrics["simulations_count"] == 4 and metrics["on_feet_count"] == 4
    assert "4 of 4: 3-slope-5-stiffness-2.0: on the feet" in err
    folder = tmp_path / "runs" / "simulations-standing"
    assert len([p for p in folder.iterdir() if p.is_dir()]) == 4
    assert pg.load_run(folder / "3-slope-5-stiffness-2.0").record.ground.slope > 0.08


def test_warnings_are_counted_once_with_the_number_of_simulations(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["simulate", *WORDS, "--quiet", "--vary", "push", "none", "300,0.02,0,r25",
             "300,0.02,0,r45"]  # fmt: skip
    assert cli.main([*words, "--out", "phases", "--json"]) == 0
    out, err = capsys.readouterr()
    (warning,) = json.loads(out)["warnings"]
    names = "1-push-300-0.02-0-r25, 2-push-300-0.02-0-r45"
    assert warning.startswith(f"2 of 3 simulations ({names}): ") and "… %" in warning
    assert [line for line in err.splitlines() if "warning" in line] == [f"warning: {warning}"]
    page = (tmp_path / "phases" / "batch.html").read_text("utf-8")
    assert page.count(warning.partition(": ")[2][:20]) == 1 and "2 of 3" in page


def test_seeds_without_randomness_give_a_note(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["simulate", *WORDS, "--seeds", "2", "--quiet"]
    for more, alike in (([], True), (["--start-noise", "0.05"], False)):
        assert cli.main([*words, *more, "--out", "noisy" if more else "same"]) == 0
        assert ("all seeds gave the same" in capsys.readouterr().err) == alike
    assert not pg.simulate_many(seeds=1, vary={"push": PUSHES}, **SMALL).seeds_alike


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--vary", "hill", "a"], "a batch has no option 'hill'"),
        (["--vary", "ground"], "give each option once"),
        (["--vary", "ground", "hill"], "no ground 'hill'"),
        (
            ["--vary", "stiffness", "much"],
            "stiffness must be a finite number, such as 1, not 'much'",
        ),
        (["--vary", "controller", "hope"], "hope"),
        (["--vary", "push", "1,2"], "NEWTON,SECONDS"),
        (["--seeds", "0"], "seeds"),
        (["--seeds", "2", "--live"], "cannot be --live"),
        (["--jobs", "2"], "add --seeds or --vary"),
        (["--keep", "pages"], "--keep is for a batch"),
    ],
)
def test_bad_input_is_said_before_anything_is_written(tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["simulate", *WORDS, *words]) == 2
    assert said in capsys.readouterr().err and not list(tmp_path.iterdir())


def test_a_run_has_its_own_person(tmp_path):
    run = pg.simulate(**SMALL)
    batch = pg.simulate_many(run, duration=0.05, rate=300.0, seeds=2)
    assert {one.run.record.human.joints for one in batch.members} == {"42"}
    with pytest.raises(ParameterError, match="no option 'height'"):
        pg.simulate_many(run, vary={"height": [1.6, 1.8]})


def test_a_backend_that_is_not_installed_is_named():
    """ray where it is missing; where it is there, other tests use it."""
    try:
        import ray  # noqa: F401
    except ImportError:
        with pytest.raises(PlantigradeError, match=r"ray is required .*\[ray\]"):
            list(run_jobs(abs, [1], backend="ray"))

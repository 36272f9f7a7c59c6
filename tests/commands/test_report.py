"""``plantigrade report`` writes the pages of a run anew, from what the folder holds alone."""

import json
import shutil

import numpy as np
import pytest

from plantigrade.commands import main as cli
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.record import Record, Run
from plantigrade.record.metrics import read_metrics


@pytest.fixture
def run(tmp_path):
    """A run folder of a person who stands, without pages."""
    human = Human.create(1.7, 65.0)
    n = 20
    qpos = np.tile(human.standing(), (n, 1))
    motion = Motion(np.arange(n) / 50, qpos, np.zeros((n, human.model.nv)), human.joint_names)
    run = Run(Record(human, motion), "fit", figures={"frames": n})
    return run.save(tmp_path / "run").folder


def test_pages_are_written_and_named(run, capsys):
    assert cli.main(["report", str(run)]) == 0
    out = capsys.readouterr().out.split()
    assert out == [str(run / "report.html"), str(run / "viewer.html")]
    assert "<title>run</title>" in (run / "report.html").read_text(encoding="utf-8")
    assert not list(run.glob(".*")), "a half-written page was left"


def test_title_and_sentence_come_from_the_run(run):
    metrics = json.loads((run / "metrics.json").read_text())
    metrics |= {"title": "Standing < still", "sentence": "A person stood."}
    (run / "metrics.json").write_text(json.dumps(metrics))
    assert cli.main(["report", str(run), "--quiet"]) == 0
    text = (run / "report.html").read_text(encoding="utf-8")
    assert "Standing &lt; still" in text and "A person stood." in text


def test_old_pages_are_replaced_and_numbers_left_alone(run):
    before = {p.name: p.read_bytes() for p in run.iterdir()}
    (run / "report.html").write_text("old")
    assert cli.main(["report", str(run)]) == 0
    assert (run / "report.html").read_text(encoding="utf-8").startswith("<!")
    numbers = {"model.xml", "motion.mot", "motion.npz"}
    assert {n: (run / n).read_bytes() for n in numbers} == {n: before[n] for n in numbers}


def test_a_run_with_new_pages_may_still_be_overwritten(run):
    assert cli.main(["report", str(run)]) == 0
    assert {"report.html", "viewer.html"} <= set(read_metrics(run)["files"])
    Run.load(run).save(run, overwrite=True)
    assert not (run / "report.html").exists()


def test_json_is_the_metrics(run, capsys):
    assert cli.main(["report", str(run), "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == json.loads((run / "metrics.json").read_text())


@pytest.mark.parametrize(
    ("harm", "sentence"),
    [
        (lambda run: shutil.rmtree(run), "no such folder"),
        (lambda run: (run / "motion.npz").unlink(), "motion.npz missing"),
        (lambda run: (run / "motion.npz").write_bytes(b"PK nonsense"), "motion.npz"),
        (lambda run: (run / "model.xml").unlink(), "model.xml missing"),
        (lambda run: (run / "metrics.json").write_text("{"), "metrics.json"),
        (lambda run: (run / "forces.npz").write_bytes(b"PK nonsense"), "forces.npz"),
    ],
)
def test_a_broken_run_is_bad_input(run, capsys, harm, sentence):
    harm(run)
    assert cli.main(["report", str(run)]) == 2
    out, err = capsys.readouterr()
    assert sentence in err and "Traceback" not in err and not out

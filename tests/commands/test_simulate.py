"""``plantigrade simulate`` as a user calls it: standing, falling, a run, and what it refuses."""

import json

import pytest

import plantigrade as pg
from plantigrade.commands import main as cli
from plantigrade.errors import ParameterError

SMALL = ("--joints", "42", "--feet", "rigid", "--rate", "300")


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.slow
def test_a_person_stands_falls_and_is_taken_from_a_run(folder, capsys):
    assert cli.main(["simulate", *SMALL, "--duration", "0.3", "--json"]) == 0
    metrics = json.loads(capsys.readouterr().out)
    stood = folder / "runs" / "simulate-standing"
    assert metrics == json.loads((stood / "metrics.json").read_text("utf-8"))
    assert metrics["status"] == "ok" and metrics["on_feet"]
    assert metrics["vertical_force_mean_bw"] == pytest.approx(1.0, abs=0.02)
    assert {p.name for p in stood.iterdir()} >= {"model.xml", "report.html", "viewer.html"}
    verdict = pg.check(pg.load_run(stood))
    assert verdict.measures["root_force"].value < 0.1 and not verdict.measures["slip"].bad

    words = ["--controller", "passive", "--duration", "0.8", "--rate", "300", "--quiet"]
    assert cli.main(["simulate", str(stood), *words, "--push", "50,0.1,0,0.1"]) == 3
    fell = pg.load_run(folder / "runs" / "simulate-simulate-standing")
    out, err = capsys.readouterr()
    assert fell.status.startswith("the person fell at 0.") and fell.status in out + err
    assert fell.figures["fell_at_s"] < 0.8 and "metrics.json" in fell.provenance.source_files
    assert fell.record.signals["world.push"].any()


def test_a_controller_of_ones_own(folder):
    def still(state):
        return pg.world.StablePD(state.angles, signals={"time": state.time})

    import plantigrade.world  # noqa: F401

    run = pg.simulate(controller=still, duration=0.1, rate=300.0, joints="42", feet="rigid")
    assert run.figures["controller"] == "still" and "controller.time" in run.record.signals
    follows = pg.simulate(run, duration=0.1, rate=300.0)
    assert follows.figures["tracking_error_rms_deg"] < 1.0 and "motion" in follows.record.references


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--push", "1,2"], "NEWTON,SECONDS,DIRECTION_DEG,AT_S"),
        (["--rope", "1,2"], "NEWTON,X,Y,Z,AT_S"),
        (["--box", "1,1,0,0"], "must be 0 (dropped) or from 2 to 50"),
        (["--shift", "1"], "METRES,SECONDS,DIRECTION_DEG,AT_S"),
        (["--shift", "0.1,0.2,0,1", "--ground", "stones"], "only a flat floor shifts"),
        (["--ground", "hill"], "there are flat, slope:DEG"),
        (["--controller", "stable-pd"], "follows a motion"),
        (["--rate", "1000", "--control-rate", "300"], "whole multiple"),
        (["--duration", "0"], "duration must be"),
        (["nothing.c3d"], "there is no such file"),
    ],
)
def test_bad_input_is_said_before_anything_is_written(folder, capsys, words, said):
    assert cli.main(["simulate", *words]) == 2
    assert said in capsys.readouterr().err and not list(folder.iterdir())


def test_what_else_acts_is_said_and_felt(folder):
    small = {"duration": 0.1, "rate": 300.0, "joints": "42", "feet": "rigid"}
    pulled = pg.simulate(rope=("50,0,2,1,0",), shift="0.05,0.05,0,0", **small)
    assert pulled.record.signals["world.push"][:-1, 1].min() > 40.0
    assert pulled.record.signals["ground.place"][-1, 0] == pytest.approx(0.05, abs=1e-3)
    assert ", pulled once, on a floor that shifts:" in pulled.sentence


def test_a_run_has_its_own_person(folder):
    run = pg.simulate(duration=0.05, rate=300.0, joints="42", feet="rigid")
    with pytest.raises(ParameterError, match="own person: leave out height"):
        pg.simulate(run, height=1.8)


def test_what_is_for_a_live_page_needs_one(folder, capsys):
    for words in (["--port", "8123"], ["--no-open"]):
        assert cli.main(["simulate", *words]) == 2
        assert "--port and --no-open are for --live" in capsys.readouterr().err
    assert cli.main(["simulate", "--live", "--controller", "hill"]) == 2
    assert "there are passive, posture" in capsys.readouterr().err and not list(folder.iterdir())

"""``plantigrade simulate`` as a user calls it: standing, falling, a run, and what it refuses."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import plantigrade as pg
from plantigrade.commands import main as cli
from plantigrade.contact.limb_sites import limb_site
from plantigrade.control.balance import BalanceSettings
from plantigrade.errors import ParameterError
from plantigrade.record import Record, Run
from plantigrade.workflows.live import prepare
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.world import Controller, Summary, Torque

STORED = Path(__file__).parents[1] / "stored"
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
    for what in ("trunk_lean_mean", "neck_lean_mean", "trunk_sideways_rms", "neck_sideways_rms"):
        lean, pending = (follows.figures[f"{what}{of}_deg"] for of in ("", "_followed"))
        assert lean == pytest.approx(pending, abs=1.0)


@pytest.mark.parametrize("lift", [-0.05, 0.05])
def test_a_motion_off_its_ground_is_put_on_it(lift):
    stood = pg.simulate(controller="balance", duration=0.5, rate=300.0, joints="42", feet="rigid")
    qpos = stood.record.motion.qpos + lift * (np.arange(stood.record.motion.qpos.shape[1]) == 2)
    off = replace(stood.record, motion=replace(stood.record.motion, qpos=qpos))
    run = pg.simulate(replace(stood, record=off), controller="replay", rate=300.0)
    assert run.ok and run.figures["tracking_error_rms_deg"] < 2.0
    assert run.figures["vertical_force_max_bw"] < 2.0
    way = "down" if lift > 0.0 else "up"
    assert any(f"was moved {way} by up to" in note for note in run.record.notes)


@pytest.mark.parametrize(("degrees", "warns"), [(5.0, False), (15.0, True)])
def test_a_person_who_moves_otherwise_than_the_motion_is_reported(degrees, warns):
    def still(state):
        off = {"tracking_error": np.deg2rad(degrees)}
        return pg.world.StablePD(state.angles, signals=off)

    run = pg.simulate(controller=still, duration=0.1, rate=300.0, joints="42", feet="rigid")
    assert run.ok
    assert warns == any("joints are 15° off the motion" in note for note in run.record.notes)


def test_what_a_controller_says_of_itself_ends_with_a_fall():
    class Counts(Controller):
        ticks = 0

        def __call__(self, state):
            self.ticks += 1
            still = np.zeros(len(state.angles))
            return Torque(still, signals={"tracking_error": state.time})

        def summary(self):
            return Summary((f"It had {self.ticks} ticks.",), {"ticks": self.ticks})

    options = {"rate": 300.0, "joints": "42", "feet": "rigid", "push": ("80,0.2,0,0",)}
    run = pg.simulate(controller=Counts(), duration=1.2, **options)
    ticks = round(100 * run.figures["fell_at_s"])
    assert ticks < 100 and run.figures["ticks"] == ticks
    assert f"It had {ticks} ticks." in run.record.notes
    off = np.deg2rad(run.figures["tracking_error_rms_deg"])
    assert off == pytest.approx(run.figures["fell_at_s"] / np.sqrt(3.0), abs=0.02)


def test_the_help_of_a_controller_has_its_own_options_and_every_setting(capsys):
    assert cli.main(["simulate", "--controller", "balance", "--help"]) == 0
    text = capsys.readouterr().out
    assert "--stepping" in text and "--stoop" not in text and "--stiffness" not in text
    assert "recovery.step.n_steps=3" in text and "Number of steps the planner looks ahead" in text
    assert cli.main(["simulate", "--help"]) == 0
    text = capsys.readouterr().out
    assert "--stepping" not in text and "simulate --controller NAME --help" in text


def test_every_number_of_a_controller_can_be_set_and_is_found_in_the_run(folder, capsys):
    small = ["--rate", "300", "--joints", "42", "--feet", "rigid", "--duration", "0.1"]
    words = ["simulate", *small, "--controller", "balance", "--set", "com_gain=60", "--out", "run"]
    assert cli.main([*words, "--set", "recovery.step.swing_durations=.2,.3,.4,.5"]) == 0
    settings = Run.load(folder / "run").metrics["settings"]
    assert settings["com_gain"] == 60.0 and "pelvis_weight" not in settings
    numbers = settings["controller_settings"]
    assert numbers["com_gain"] == 60.0 and numbers["pelvis_weight"] > 0.0
    assert numbers["recovery.step.swing_durations"] == [0.2, 0.3, 0.4, 0.5]
    given = {"controller": "pendulum", "own": (("tick", "0.015"),)}
    assert SimulateSettings(**given).values == {"tick": 0.015}
    options = {"rate": 300.0, "joints": "42", "feet": "rigid", "duration": 0.1}
    how = replace(BalanceSettings(), recovery=replace(BalanceSettings().recovery, crouch=0.05))
    run = pg.simulate(controller="balance", controller_settings=how, **options)
    assert run.provenance.settings["recovery.crouch"] == 0.05
    for given, said in (
        ("com_gain=much", "com_gain must be a finite number, such as 50"),
        ("com_gain=nan", "com_gain must be a finite number"),
        ("com_gain=-1", "com_gain must be 0 to 5000, not -1"),
        ("recovery.step.n_steps=1000000", "n_steps must be 0 to 30, not"),
        ("com_gian=60", "no controller has a setting 'com_gian'; did you mean 'com_gain'?"),
        ("com_gain", "give each setting once, as NAME=VALUE"),
        ("swing.clearance=0.1", "swing.clearance has no effect without controller=pendulum"),
        ("recovery.step.swing_durations=.2,.3", "must be as many numbers, such as (0.22"),
    ):
        assert cli.main(["simulate", "--controller", "balance", "--set", given]) == 2
        assert said in capsys.readouterr().err


def test_settings_that_lead_to_no_command_are_an_error_of_our_own():
    small = {"rate": 300.0, "joints": "42", "feet": "rigid", "duration": 0.1}
    with pytest.raises(ParameterError, match="momentum_weight=0 the controller hybrid finds no"):
        pg.simulate(controller="hybrid", momentum_weight=0.0, **small)


def test_an_option_its_usual_controller_ignores_is_refused():
    run = Run.load(STORED / "side-step")  # is replayed where no controller is named
    with pytest.raises(ParameterError, match="stiffness has no effect"):
        pg.simulate(run, stiffness=2.0)
    with pytest.raises(ParameterError, match="cutoff has no effect"):
        pg.simulate(run, cutoff=8.0)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--push", "1,2"], "NEWTON,SECONDS,DIRECTION_DEG,AT_S"),
        (["--rope", "1,2"], "NEWTON,X,Y,Z,AT_S"),
        (["--rope", "50,1e9,2,1,0"], "anchor must be"),
        (["--rope", "50,0,2,1,-1"], "time must be"),
        (["--box", "1e9,5,0,0"], "mass must be"),
        (["--box", "1,1,0,0"], "must be 0 (dropped) or from 2 to 50"),
        (["--shift", "1"], "METRES,SECONDS,DIRECTION_DEG,AT_S"),
        (["--shift", "1e9,0.2,0,0"], "distance must be"),
        (["--vary", "motion", "hill"], "no motion 'hill'"),
        (["--vary", "ground", "flat", "flat"], "a value is given twice"),
        (["--mass-error-pct", "nan"], "mass_error_pct must be"),
        (["--delay", "1"], "delay must be"),
        (["--shift", "0.1,0.2,0,1", "--ground", "stones"], "shift needs a flat floor"),
        (["--ground", "hill"], "there are flat, slope:DEG"),
        (["--controller", "stable-pd"], "needs a motion"),
        (["--rate", "1000", "--control-rate", "300"], "whole multiple"),
        (
            ["--controller", "balance", "--stiffness", "2"],
            "stiffness has no effect without controller=posture or stable-pd",
        ),
        (["--motion", "tiptoe", "--feet", "multi-segment", "--stiffness", "2"], "no effect"),
        (["--controller", "passive", "--torque-rise", "0.1"], "drives no joint"),
        (["--speed", "1.2"], "speed has no effect without controller=pendulum"),
        (["--stepping"], "stepping has no effect without controller=balance"),
        (
            ["--static", __file__, "--cutoff", "8"],
            "static and cutoff have no effect without a recording to fit",
        ),
        (["--duration", "0"], "duration must be"),
        (["nothing.c3d"], "there is no such file"),
    ],
)
def test_bad_input_is_said_before_anything_is_written(folder, capsys, words, said):
    assert cli.main(["simulate", *words]) == 2
    assert said in capsys.readouterr().err and not list(folder.iterdir())


def test_disturbances_act_and_are_noted(folder):
    small = {"duration": 0.1, "rate": 300.0, "joints": "42", "feet": "rigid"}
    pulled = pg.simulate(rope=("50,0,2,1,0",), shift="0.05,0.05,0,0", **small)
    assert pulled.record.signals["world.push"][:-1, 1].min() > 40.0
    assert pulled.record.signals["ground.place"][-1, 0] == pytest.approx(0.05, abs=1e-3)
    assert ", pulled once, on a shifting floor." in pulled.sentence


def test_model_mismatch_acts_and_is_noted():
    run = Run.load(STORED / "side-step")
    small = {"duration": 0.05, "controller": "stable-pd", "rate": 600.0, "seed": 3}
    plain, heavy = (pg.simulate(run, mass_error_pct=x, **small) for x in (0.0, 20.0))
    assert heavy.record.human.mass == pytest.approx(1.2 * run.record.human.mass)
    assert ", 20 % heavier than planned." in heavy.sentence
    verdict = pg.check(heavy.record)  # the equations of motion of who really moved
    assert max(verdict.measures[f"root_{q}"].value for q in ("force", "moment")) < 0.05
    other = {"delay": 0.01, "sensor_noise_deg": 0.2, "start_noise": 0.05, "friction": 0.1}
    found = {name: pg.simulate(run, **{name: x}, **small) for name, x in other.items()}
    assert found["friction"].record.ground.friction == 0.1
    start = {name: each.record.motion.qvel[0] for name, each in found.items()}
    assert 0.03 < np.std(start.pop("start_noise") - plain.record.motion.qvel[0]) < 0.07
    assert all((v == plain.record.motion.qvel[0]).all() for v in start.values())
    ends = {each.record.motion.qpos[-1].tobytes() for each in (plain, heavy, *found.values())}
    assert len(ends) >= 5  # nobody slips in so short a time
    noisy = pg.simulate(run, sensor_noise_deg=0.2, **small)
    assert noisy.record.motion.qpos[-1].tobytes() in ends


def test_a_motion_from_standing_starts_with_its_soles_on_another_ground():
    run = Run.load(STORED / "side-step")
    started = pg.simulate(run, ground="slope:10", duration=0.02)
    ankles = [started.record.motion[f"ankle_angle_{side}"][0] for side in "rl"]
    planned = [run.record.motion[f"ankle_angle_{side}"][0] for side in "rl"]
    np.testing.assert_allclose(np.subtract(ankles, planned), np.deg2rad(10.0), atol=0.03)


def test_a_live_session_knows_the_model_mismatch():
    made = prepare(Run.load(STORED / "side-step"), mass_error_pct=10.0, delay=0.01, friction=0.6)
    session, own = made.session, made.stage.begin.human.mass
    mine = slice(1, 1 + len(session.world.human.body_names))
    assert session.world.model.body_mass[mine].sum() == pytest.approx(1.1 * own)
    assert session.friction == 0.6 and session.choice.controller == "replay"
    session.step()
    session.restart()
    session.step()
    assert made.run().record.human.mass == pytest.approx(1.1 * own)


def test_who_starts_deep_below_the_ground_is_refused():
    run = Run.load(STORED / "side-step")
    qpos = run.record.motion.qpos - 5.0 * np.eye(run.record.motion.qpos.shape[1])[2]
    record = replace(run.record, motion=replace(run.record.motion, qpos=qpos))
    with pytest.raises(ParameterError, match="starts 5.00 m below its ground"):
        pg.simulate(replace(run, record=record))


def test_a_motion_that_rests_on_a_knee_is_refused():
    run = Run.load(STORED / "side-step")
    knee = limb_site(run.record.human, "knee_l")
    kneels = Record(run.record.human, run.record.motion, sites=(knee,))
    with pytest.raises(ParameterError, match="rests on knee_l"):
        pg.simulate(replace(run, record=kneels))


def test_a_run_has_its_own_person(folder):
    run = pg.simulate(duration=0.05, rate=300.0, joints="42", feet="rigid")
    with pytest.raises(ParameterError, match="own person: leave out height"):
        pg.simulate(run, height=1.8)


def test_what_is_for_a_live_page_needs_one(folder, capsys):
    for words in (["--port", "8123"], ["--no-open"]):
        assert cli.main(["simulate", *words]) == 2
        assert "--port and --no-open need --live" in capsys.readouterr().err
    assert cli.main(["simulate", "--live", "--controller", "hill"]) == 2
    assert "no controller 'hill'; there are" in capsys.readouterr().err
    assert not list(folder.iterdir())


def test_a_live_simulation_without_out_is_saved_where_the_button_is_pressed(
    folder, monkeypatch, capsys
):
    run = pg.simulate(duration=0.05, rate=300.0, joints="42", feet="rigid")

    def pressed(times):
        def live(*_, save, **__):
            for _ in range(times):
                save(run)
            return run

        monkeypatch.setattr("plantigrade.workflows.live.live", live)
        assert cli.main(["simulate", "--live"]) == 0
        return capsys.readouterr()

    assert "not saved: press Save" in pressed(0).err and not (folder / "runs").exists()
    assert "simulate-standing" in pressed(2).out
    assert [path.name for path in (folder / "runs").iterdir()] == ["simulate-standing"]

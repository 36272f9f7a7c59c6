"""Tasks where gravity is not the earth's: one source for model, flights, check and files."""

import mujoco
import numpy as np
import pytest

import plantigrade as pg
from plantigrade.commands.synthesize import parse
from plantigrade.constants import GRAVITY
from plantigrade.errors import FileError, ParameterError
from plantigrade.models import Human
from plantigrade.trajopt import make_task, parse_task_file
from plantigrade.trajopt.tasks.gait_parameters import gait_parameters

HUMAN = Human.create(joints="43")
MOON = HUMAN.with_gravity(0.165 * GRAVITY)


def test_gravity_belongs_to_the_model_and_survives_description():
    assert MOON.gravity == pytest.approx(1.619, abs=1e-3)
    again = Human.from_dict(MOON.with_loads({"back": 10.0}).to_dict())
    assert again.gravity == pytest.approx(MOON.gravity, rel=1e-12)
    assert mujoco.MjModel.from_xml_string(again.xml).opt.gravity[2] == -again.gravity
    assert "gravity" not in HUMAN.to_dict()
    assert HUMAN.on_earth and not MOON.on_earth


def test_flights_last_longer_where_gravity_is_small():
    hop = {"hop_height": 0.02, "hops_per_minute": 60.0}
    air = [
        (plan := make_task("hop", human, hop).plan).duration - plan.stances[0].toe_off
        for human in (HUMAN, MOON)
    ]
    assert air[1] / air[0] == pytest.approx(np.sqrt(1 / 0.165))
    with pytest.raises(ParameterError, match="for the contact"):
        make_task("hop", MOON, {"hop_height": 0.2, "hops_per_minute": 60.0})
    jump = [make_task("jump", human, {"push": 1.6}).plan.stances for human in (HUMAN, MOON)]
    up = [max(s.heel_strike for s in stances) - min(s.toe_off for s in stances) for stances in jump]
    assert up[1] / up[0] == pytest.approx(np.sqrt(1 / 0.165))


@pytest.mark.parametrize("gravity", [0.165, 0.5, 1.3])
def test_runners_leave_the_ground_with_a_speed_as_the_root_of_gravity(gravity):
    """The contact lasts as long [Polet2018]_ [Cavagna2005]_; a cadence that is given is kept."""
    there = HUMAN.with_gravity(gravity * GRAVITY)
    earth, other = (make_task("run", human, {"speed": 2.5}).plan for human in (HUMAN, there))
    contact = [plan.stances[0].toe_off for plan in (earth, other)]
    rise = [
        0.5 * human.gravity * (plan.duration - plan.stances[0].toe_off)
        for human, plan in ((HUMAN, earth), (there, other))
    ]
    assert contact[0] == pytest.approx(contact[1])
    assert rise[1] / rise[0] == pytest.approx(np.sqrt(gravity))
    asked = make_task("run", there, {"speed": 2.5, "cadence": 160.0}).plan
    assert 60.0 / asked.duration == pytest.approx(160.0)


def test_steps_of_light_people_are_those_measured():
    """At a quarter of gravity 16 % shorter at one speed [Donelan1997]_."""
    earth, light = (
        gait_parameters(human, 1.0) for human in (HUMAN, HUMAN.with_gravity(GRAVITY / 4))
    )
    assert light.step_length / earth.step_length == pytest.approx(0.84, abs=0.005)
    same = gait_parameters(HUMAN.with_gravity(GRAVITY / 4), 0.5)  # the Froude number of 1.0 m/s
    assert same.stance_fraction == pytest.approx(earth.stance_fraction)


def test_mechanics_refuses_what_gravity_does_not_allow():
    with pytest.raises(ParameterError, match="above 1.4 a body leaves the ground"):
        make_task("walk", MOON, {"speed": 1.6})
    make_task("walk", MOON, {"speed": 1.3})
    with pytest.raises(ParameterError, match="at most"):
        make_task("jump", HUMAN.with_gravity(1.5 * GRAVITY), {"jump_height": 0.6, "depth": 0.2})


def test_gravity_of_files_and_words_is_one():
    file = parse_task_file('[task]\nbase = "squat"\ngravity = 0.5\n')
    assert parse_task_file(file.toml()) == file
    assert file.options == {"gravity": 0.5}
    assert parse(["walk", "--gravity", "0.38"]).gravity == 0.38
    with pytest.raises(FileError, match="gravity"):
        parse_task_file('[task]\nbase = "squat"\ngravity = "none"\n')
    for words in (["--gravity", "3"], ["--gravity", "0.5", "--replay"]):
        with pytest.raises(SystemExit):
            parse(["walk", *words])


@pytest.mark.slow
@pytest.mark.parametrize(("gravity", "speed"), [(0.16, 0.7), (0.16, 1.3), (1.5, 1.3)])
def test_a_walk_elsewhere_passes_the_check_and_ground_carries_its_weight(gravity, speed, tmp_path):
    run = pg.synthesize("walk", periodic=True, gravity=gravity, speed=speed)
    assert run.status == "ok", run.status
    record = run.record
    up = sum(record.foot(side).force[:, 2] for side in "rl")
    steps = np.diff(record.motion.time)
    mean = float(((up[1:] + up[:-1]) / 2 * steps).sum() / steps.sum())
    assert mean == pytest.approx(record.human.mass * gravity * GRAVITY, rel=1e-3)
    folder = tmp_path / "walk"
    run.save(folder)
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    assert model.opt.gravity[2] == pytest.approx(-gravity * GRAVITY)
    assert pg.Run.load(folder).record.weight == pytest.approx(record.weight)
    with pytest.raises(ParameterError, match="controllers are made for the earth"):
        pg.simulate(folder, controller="replay")


@pytest.mark.slow
def test_a_jump_on_the_moon_stays_longer_in_the_air():
    run = pg.synthesize("jump", jump_height=0.3, push=1.6, gravity=0.165)
    assert run.status == "ok", run.status

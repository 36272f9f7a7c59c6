"""The table of controllers, and what a controller may offer."""

import re
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from plantigrade.contact.ground import Ground
from plantigrade.control import CONTROLLERS, Posture, Situation, controller_named
from plantigrade.control.choices import having, usual
from plantigrade.control.gait.person import world_sites
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.options import LEARNED
from plantigrade.record import Record
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.world import Rates, Summary, Target, World, controller_from, standing_on

PAGE = Path(__file__).parents[2] / "docs" / "commands" / "simulate.md"


@pytest.fixture(scope="module")
def situation():
    """A person who has a motion of two frames."""
    human = Human.create(1.7, 65.0, "female", "42", "rigid")
    standing = standing_on(human, Ground())
    qpos, qvel = np.tile(standing, (2, 1)), np.zeros((2, human.model.nv))
    motion = Motion(np.array([0.0, 1.0]), qpos, qvel, human.joint_names)
    record = Record(human, motion)
    return Situation(human=human, ground=Ground(), motion=motion, standing=standing, record=record)


def test_every_controller_of_the_table_moves_a_person_and_is_in_the_manual(situation):
    world = World(situation.human, rate=300.0, recording=False)
    table = PAGE.read_text("utf-8").split("| `--controller` |")[1].split("\n\n")[0]
    names = re.findall(r"^\| `([a-z-]+)` \|", table, re.M)
    assert names == [*CONTROLLERS, LEARNED]
    for name in CONTROLLERS:
        assert world.step(controller_named(name, situation)(world.reset())).time > 0.0


def test_who_stands_holds_a_posture_and_another_name_is_refused(situation):
    still = Situation(human=situation.human, ground=Ground())
    assert isinstance(controller_named(None, still), Posture)
    assert usual(situation.motion, situation.record) == "replay"
    assert usual(situation.motion) == "stable-pd"
    with pytest.raises(ParameterError, match="no controller 'pd'; there are .*passive, posture"):
        controller_named("pd", still)
    with pytest.raises(ParameterError, match="stable-pd needs a motion"):
        controller_named("stable-pd", still)


def test_a_recorded_walk_is_walked_by_a_pendulum_and_any_other_motion_is_replayed(walk):
    assert usual(walk.motion, walk) == "pendulum"
    sites = world_sites(walk)
    force = np.zeros((walk.motion.n_frames, len(sites), 3))
    planned = replace(walk, sites=sites, contact_force=force, contact_point=force)
    assert usual(planned.motion, planned) == "replay"
    qpos = walk.motion.qpos.copy()
    qpos[:, 2] += 0.1 * np.sin(np.pi * np.arange(len(qpos)) / (len(qpos) - 1)) ** 2
    flying = replace(walk, motion=replace(walk.motion, qpos=qpos))
    assert usual(flying.motion, flying) == "replay"
    uphill = replace(walk, ground=replace(walk.ground, slope=0.1))
    assert usual(uphill.motion, uphill) == "replay"


def on_one_foot(lasts: float, moves: float = 0.0) -> Record:
    """A person who lifts the left foot for a time [s], and slides along while on the right [m]."""
    human = Human.create(1.7, 65.0, "female", "42", "rigid")
    time = np.linspace(0.0, 3.0, 151)
    qpos = np.tile(standing_on(human, Ground()), (len(time), 1))
    up = (time >= 0.5) & (time < 0.5 + lasts)
    for name, angle in (("hip_flexion_l", 0.8), ("knee_angle_l", 1.4)):
        qpos[up, 7 + human.hinge(name)] = angle
    qpos[:, 0] += moves * time / time[-1]
    return Record(
        human, Motion(time, qpos, np.zeros((len(time), human.model.nv)), human.joint_names)
    )


def test_a_person_on_one_foot_balances_there():
    still = on_one_foot(2.0)
    assert usual(still.motion, still) == "balance"
    for other in (on_one_foot(1.0), on_one_foot(2.0, moves=0.3)):
        assert usual(other.motion, other) == "replay"


def test_a_target_keeps_to_its_range():
    lean = Target("lean", -5.0, 5.0, 0.0, "deg")
    lean.set(4.0)
    for value in (6.0, float("nan")):
        with pytest.raises(ParameterError, match="lean must be -5–5 deg"):
            lean.set(value)
    assert lean.value == 4.0
    with pytest.raises(ParameterError, match="is not a range"):
        Target("lean", 1.0, 1.0, 1.0)


def test_a_plain_function_is_a_controller_with_every_default(situation):
    state = World(situation.human, rate=300.0, recording=False).reset()
    control = controller_from(lambda state: None)
    assert control(state) is None and control.name == "<lambda>"
    assert tuple(control.targets) == tuple(control.drawings(state)) == ()
    assert control.summary() == Summary() and not control.follow(np.zeros((1, 2)))
    assert control.rates == Rates(1800.0, 100.0) and controller_from(control) is control
    for wrong in (3, Posture):
        with pytest.raises(ParameterError, match="a controller is a Controller or a function"):
            controller_from(wrong)


def test_rates_that_a_user_sets_fit_each_other():
    rates = Rates(600.0, 200.0, 100.0)
    assert rates.changed() is rates
    assert rates.changed(physics=1000.0) == Rates(1000.0, 200.0)
    assert rates.changed(physics=500.0) == Rates(500.0, 500.0 / 3)
    assert rates.changed(control=50.0) == Rates(600.0, 50.0)


def test_no_setting_of_a_controller_has_the_name_of_an_option_of_a_simulation():
    taken = {each.name for each in fields(SimulateSettings)}
    assert not [name for name in taken if having(name)]

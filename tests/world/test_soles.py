"""Soles yield as springs and dampers, whatever the rate of the physics."""

import mujoco
import numpy as np
import pytest

from plantigrade.constants import GRAVITY
from plantigrade.contact.ground import Ground
from plantigrade.contact.site import contact_sites
from plantigrade.contact.sole import SoleSettings, soften
from plantigrade.control import Posture
from plantigrade.models import Human
from plantigrade.world import World, standing_on

RATES = (600.0, 2400.0)


def landed(human: Human, rate: float, height: float, seconds: float) -> tuple[World, float]:
    """Return the world after a fall from a height, and the greatest force [body weights]."""
    qpos = standing_on(human, Ground())
    qpos[2] += height
    world = World(human, rate=rate, control_rate=200.0, recording=False, qpos=qpos)
    control, state, most = Posture(), world.reset(), 0.0
    while world.time < seconds:
        state = world.step(control(state))
        most = max(most, float(state.contact_force[:, 2].sum()))
    assert world.fall is None
    return world, most / (human.mass * GRAVITY)


@pytest.mark.parametrize("feet", ["rigid", "two-segment", "multi-segment"])
def test_soles_are_pressed_in_by_their_stiffness(feet):
    human = Human.create(1.7, 65.0, feet=feet)
    world, _ = landed(human, 400.0, 0.0, 1.0)
    sites = contact_sites(human)
    depth = [s.radius - float(world.data.geom(f"contact_{s.name}").xpos[2]) for s in sites]
    per_metre = SoleSettings().stiffness / (len(sites) / 2)
    assert per_metre * np.maximum(depth, 0.0).sum() == pytest.approx(1.0, abs=0.01)


def test_a_fall_on_straight_legs_strikes_alike_at_every_rate():
    """Springs that follow the time step would strike harder, the shorter it is."""
    human = Human.create(1.7, 65.0)
    coarse, fine = (landed(human, rate, 0.01, 0.1)[1] for rate in RATES)
    assert coarse == pytest.approx(fine, rel=0.1)
    assert 2.0 < fine < 6.0


def test_a_softened_site_sinks_in_by_its_load():
    """A ball of 10 kg on a cushion of 5 kN/m."""
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><geom type='plane' size='1 1 1'/><body pos='0 0 .05'><freejoint/>"
        "<geom name='contact_ball' size='.05' mass='10'/></body></worldbody></mujoco>"
    )
    model.opt.timestep = 0.002
    soften(model, "ball", 5000.0, 0.01)
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 1000)
    assert 0.05 - data.qpos[2] == pytest.approx(10.0 * GRAVITY / 5000.0, rel=0.01)

"""Scripts of foot motions: read, refused, posed; and carried out by balance."""

import re

import numpy as np
import pytest

from plantigrade.contact.site import contact_sites
from plantigrade.control.balance import MOTIONS, Balance, script_named, scripted
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.world import World

HUMAN = Human.create(height=1.5, mass=48.5, joints="66")
SHORT = """
title = "up and down"
[[frame]]
time = 0.3
[[frame]]
time = 1.0
both = { ankle = [0.0, 0.0, 0.04], presses = ["medial_phalanges", "lateral_phalanges"] }
[[frame]]
time = 1.6
"""


@pytest.fixture(scope="module")
def short(tmp_path_factory):
    path = tmp_path_factory.mktemp("script") / "short.toml"
    path.write_text(SHORT, "utf-8")
    return scripted(HUMAN, script_named(str(path)))


@pytest.mark.parametrize("name", MOTIONS)
def test_every_motion_of_the_package_is_read(name):
    script = script_named(name)
    assert script.duration > 3.0
    times = [frame.time for frame in script.frames]
    assert times == sorted(times) and times[0] == 0.0
    assert script.frames[0].presses[:, :4].all()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("title = 3", "no [[frame]]"),
        ("[[frame]]\ntime = -1", "after 0 s"),
        ("[[frame]]\ntime = 1\n[[frame]]\ntime = 1", "after 1 s"),
        ("[[frame]]\ntime = 1\nankle = [0, 0, 0]", "says ankle"),
        ("[[frame]]\ntime = 1\nleft = { presses = ['thumb'] }", "thumb"),
        ("[[frame]]\ntime = 1\nleft = { presses = 'heel' }", "list"),
        ("[[frame]]\ntime = 1\nboth = { ankle = [0, 0] }", "three numbers"),
        ("[[frame]]\ntime = 1\nbody = [0, 0, 9]", "three numbers"),
        ("speed = 1", "says speed"),
        ("[[frame]]\ntime = 0.004", "0.04 s at least"),
        ("[[frame]]\ntime = nan", "nan"),
        ("[[frame]]\ntime = true", "True"),
        ("[[frame]]\ntime = 1\nboth = { toward = [0, 2] }", "two numbers"),
    ],
)
def test_what_is_no_script_is_refused(text, message, tmp_path):
    path = tmp_path / "wrong.toml"
    path.write_text(text, "utf-8")
    with pytest.raises(ParameterError, match=re.escape(message)):
        script_named(str(path))


def test_no_script_and_no_segments_are_refused():
    with pytest.raises(ParameterError, match="tiptoe"):
        script_named("handstand")
    with pytest.raises(ParameterError, match="multi-segment"):
        scripted(Human.create(), script_named("tiptoe"))


def test_on_tiptoe_only_toes_press_and_the_body_is_over_them(short):
    end = short.at(1.6)
    sites = contact_sites(HUMAN)
    toes = np.array(["phalanges" in site.name for site in sites])
    assert (end.contact == toes).all()
    low = end.spheres[:, 2] - np.array([site.radius for site in sites])
    assert np.abs(low[toes]).max() < 0.002
    assert low[~toes].min() > 0.005
    x = end.spheres[toes, 0]
    assert x.min() < end.com[0] < x.max()
    assert np.allclose(end.qvel, 0.0)
    rise = end.spheres[~toes, 2].mean() - short.at(0.0).spheres[~toes, 2].mean()
    assert 0.01 < rise < 0.05


def test_balance_follows_a_script_onto_the_toes(short):
    world = World(HUMAN, rate=1000.0, recording=False, qpos=short.motion.qpos[0])
    balance, state = Balance(short), world.reset()
    while world.time < 1.6:
        command = balance(state)
        state = world.step(command)
    assert world.fall is None
    assert command.signals["contacts"] >= 10.0  # all 20 once it is at rest
    assert np.linalg.norm((state.body.com - balance.goal)[:2]) < 0.02

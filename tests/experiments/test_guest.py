"""Guests of the push benchmark: models with controllers of their own."""

from pathlib import Path

import mujoco
import numpy as np
import pytest

from experiments.guest import Guest, GuestWalk, PushedGuest, gait_of
from experiments.tour import guest_tour
from experiments.walkers import guest_named, make_named
from plantigrade.errors import ParameterError

SLED = """
<mujoco>
  <option timestep="0.002"/>
  <worldbody>
    <geom type="plane" size="0 0 1" friction="0"/>
    <body name="trunk" pos="0 0 1">
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="y" type="slide" axis="0 1 0" damping="40"/>
      <geom type="box" size=".1 .2 .3" mass="40"/>
      <body name="right" pos="0 -.1 -.9">
        <joint name="r" type="slide" axis="0 0 1" damping="20"/>
        <geom name="right" type="sphere" size=".05" mass="1" friction="0"/>
      </body>
      <body name="left" pos="0 .1 -.9">
        <joint name="l" type="slide" axis="0 0 1" damping="20"/>
        <geom name="left" type="sphere" size=".05" mass="1" friction="0"/>
      </body>
      <body name="hand" pos="0 .3 -.7">
        <joint name="hand" type="slide" axis="0 0 1" damping="20"/>
        <geom type="sphere" size=".05" mass="1"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <velocity joint="x" kv="100"/>
    <position joint="r" kp="2000"/>
    <position joint="l" kp="2000"/>
    <position joint="hand" kp="2000"/>
  </actuator>
</mujoco>
"""


class Sled(Guest):
    """A trunk on rails with two feet that stamp in turn, at 1 m/s; pushed aside it drops a hand."""

    trunk, feet, rate = "trunk", {"r": "right", "l": "left"}, 100.0

    def __init__(self):
        self.model = mujoco.MjModel.from_xml_string(SLED)

    def start(self, data):
        data.joint("x").qvel = 1.0

    def __call__(self, data):
        right = data.time % 1.0 < 0.5
        hand = -0.3 if data.joint("y").qvel[0] > 0.5 else 0.03
        return 1.0, -0.08 if right else 0.05, 0.05 if right else -0.08, hand


class Astray(Sled):
    """Names a body that is not there."""

    trunk = "chest"


class Uneven(Sled):
    """Asks for controls between the steps of its model."""

    rate = 130.0


class Mute(Sled):
    """Returns too few controls."""

    def __call__(self, data):
        return 1.0, 0.0


class Broken(Sled):
    """Fails in its own code."""

    def start(self, data):
        raise KeyError("no such pose")


class Nameless(Sled):
    """Has no model."""

    def __init__(self):
        pass


class Still(Sled):
    """Has no rate."""

    rate = 0.0


class Idle(Sled):
    """Does not step."""

    def __call__(self, data):
        return 0.0, -0.08, -0.08, 0.0


def test_the_gait_of_a_guest_is_measured():
    gait = gait_of(Sled)
    assert gait.speed == pytest.approx(1.0, abs=0.02)
    assert gait.axis == pytest.approx([1.0, 0.0], abs=1e-6)
    assert gait.period == pytest.approx(1.0, abs=0.02)
    assert gait.mass == pytest.approx(43.0)


def test_a_push_is_felt_at_the_trunk_and_ends_in_the_gait_or_in_a_fall():
    pushed = PushedGuest(Sled, 0.3)
    held = pushed(60.0, 0.0, 0.4, 6.0)
    assert held.withstood and held.pushed is not None
    assert 0.4 < held.peak < 20.0
    begin, end = held.pushed
    assert end - begin == pytest.approx(0.4)
    k = int(np.searchsorted(held.time, end))
    faster = (held.com[k, 0] - held.com[k - 2, 0]) / (held.time[k] - held.time[k - 2])
    # m v' = F - 100 (v - 1), for 0.4 s
    assert faster == pytest.approx(1.0 + 0.6 * (1.0 - np.exp(-0.4 * 100.0 / 43.0)), abs=0.03)
    fallen = pushed(100.0, np.pi / 2, 0.4, 6.0)
    assert not fallen.survived and "hand" in fallen.end
    assert fallen.com[-1, 1] > 0.05  # to the left


def test_a_guest_tours_straight_and_is_punched():
    found = guest_tour(Sled, seed=3, n=2)
    assert found.straight and found.punches
    assert found.reached == 2 or found.end


@pytest.mark.parametrize(
    ("guest", "word"),
    [
        (Astray, "chest"),
        (Uneven, "rate"),
        (Mute, "4 controls"),
        (Idle, "does not walk"),
        (Broken, "no such pose"),
        (Nameless, "model"),
        (Still, "Still failed"),
    ],
)
def test_a_guest_that_cannot_be_walked_is_refused(guest, word):
    with pytest.raises(ParameterError, match=word):
        gait_of(guest)


def test_an_overlap_of_the_legs_is_seen_even_if_they_cannot_collide():
    class Crossed(Sled):
        """Both feet in one place, which do not collide with each other."""

        def __init__(self):
            narrow = SLED.replace('pos="0 -.1 -.9"', 'pos="0 .05 -.9"')
            apart = '<contact><exclude body1="right" body2="left"/></contact></mujoco>'
            narrow = narrow.replace("</mujoco>", apart)
            self.model = mujoco.MjModel.from_xml_string(narrow)

    going = GuestWalk(Crossed)
    going.step()
    assert "through the other" in going.end


def test_a_guest_is_named_by_its_file_and_taken_by_the_benchmark_alone(tmp_path):
    file = tmp_path / "mine.py"
    file.write_text("from tests.experiments.test_guest import Sled\n")
    assert guest_named(f"{file}:Sled") is Sled
    assert guest_named("pendulum") is None and guest_named("pendulum:law=x") is None
    with pytest.raises(ParameterError, match="push-any-controller"):
        make_named(f"{file}:Sled")


@pytest.mark.slow
def test_the_humanoid_of_the_example_walks():
    pytest.importorskip("dm_control")
    word = str(Path(__file__).parents[2] / "experiments" / "guest_humanoid.py") + ":Humanoid"
    found = guest_named(word)
    assert found is not None
    gait = gait_of(found)
    assert 0.6 < gait.speed < 0.9 and 0.5 < gait.period < 0.8
    assert 40.0 < gait.mass < 42.0

"""Jumps of scripts: planned as falls, with forces people have, and clocked by what happens."""

import numpy as np
import pytest

from plantigrade.constants import GRAVITY
from plantigrade.control.balance import Balance, ScriptSettings, script_named, scripted
from plantigrade.control.balance.flight import FlightClock, FlightSettings
from plantigrade.control.balance.script_motion import com_height, through
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.world import World

HUMAN = Human.create(height=1.5, mass=48.5, joints="66")


@pytest.fixture(scope="module")
def jump():
    return scripted(HUMAN, script_named("jump"))


def test_the_body_falls_freely_and_never_pulls_at_the_ground(jump):
    ((begin, end),) = jump.flights
    inside = (jump.time > begin + 0.05) & (jump.time < end - 0.05)
    assert np.allclose(jump.com_acceleration[inside, 2], -GRAVITY, atol=0.8)
    force = 1 + jump.com_acceleration[:, 2] / GRAVITY
    assert -0.2 < force.min() and 1.8 < force.max() < 2.6
    fallen = GRAVITY * (end - begin) ** 2 / 8
    at_apex = jump.com[:, 2].max() - np.interp(begin, jump.time, jump.com[:, 2])
    assert at_apex == pytest.approx(fallen, abs=0.01)
    spin = [
        BodyState(HUMAN, q, v).angular_momentum
        for q, v in zip(jump.motion.qpos[::5], jump.motion.qvel[::5], strict=True)
    ]
    assert np.abs(spin).max() < 0.02 * HUMAN.mass


def test_what_passes_through_keeps_its_slope_and_what_turns_does_not():
    at, time = np.array([0.0, 1.0, 2.0, 3.0]), np.linspace(0, 3, 301)
    path = through(at, np.array([[0.0], [1.0], [2.0], [0.0]]), time)[:, 0]
    speed = np.gradient(path, time)
    assert path[[0, 100, 200, 300]] == pytest.approx([0, 1, 2, 0])
    assert speed[100] == pytest.approx(1.0, abs=0.01)
    assert abs(speed[200]) < 0.01 and path.max() == pytest.approx(2.0)


@pytest.mark.parametrize(("crouch", "long"), [(-0.25, 0.12), (-0.02, 0.34)])
def test_a_push_beyond_strength_is_refused(crouch, long):
    at = np.array([0.0, 1.0, 1 + long, 1.4 + long, 2.0 + long, 3.0 + long])
    with pytest.raises(ParameterError, match="body weights"):
        com_height(at, np.array([0, crouch, 0, 0, -0.2, 0.0]), [(2, 3)], at, ScriptSettings())


LANDED = "[[frame]]\ntime = 3\nboth = { presses = ['heel'] }\n[[frame]]\ntime = 6\n"


@pytest.mark.parametrize(("before", "after"), [("[[frame]]\ntime = 1\n", ""), ("", LANDED)])
def test_a_script_that_ends_or_begins_in_the_air_is_refused(before, after, tmp_path):
    path = tmp_path / "up.toml"
    path.write_text(f"{before}[[frame]]\ntime = 2\nboth = {{ presses = [] }}\n{after}", "utf-8")
    with pytest.raises(ParameterError, match="in the air"):
        scripted(HUMAN, script_named(str(path)))


def clocked(touches, falls):
    """Return the time of a reference that flies from 1.0 to 1.4 s, at 100 a second."""
    clock, times = FlightClock([(1.0, 1.4)]), np.arange(0.01, 2.5, 0.01)
    return times, np.array([clock.at(t, touches(t), falls(t)) for t in times.tolist()])


def test_a_clock_jumps_to_a_landing_that_comes_early_and_not_to_toes_that_drag():
    times, own = clocked(lambda t: t < 1.05 or t > 1.3, lambda t: t > 1.2)
    assert own[times < 1.295] == pytest.approx(times[times < 1.295])
    assert own[times > 1.31][0] == pytest.approx(1.41, abs=0.011)


def test_a_clock_waits_for_a_landing_that_comes_late_and_not_for_ever():
    times, own = clocked(lambda t: not 1.0 < t < 1.6, lambda t: t > 1.2)
    held = (times > 1.41) & (times < 1.595)
    assert np.all(own[held] < 1.4) and np.all(own[held] > 1.399)
    assert own[times > 1.61][0] == pytest.approx(1.41, abs=0.011)
    times, own = clocked(lambda t: t < 1.0, lambda t: t > 1.2)
    assert own[-1] == pytest.approx(times[-1] - FlightSettings().max_wait, abs=0.03)


def test_the_spine_of_a_planned_jump_stays_near_standing(jump):
    assert np.abs(np.rad2deg(jump.motion["lumbar_extension"])).max() < 40.0


def test_a_jump_rises_ten_centimetres_and_lands(jump):
    world = World(HUMAN, rate=900.0, control_rate=90.0, recording=False, qpos=jump.motion.qpos[0])
    balance, state = Balance(jump), world.reset()
    start, highest = state.body.com[2], 0.0
    while world.time < 3.4 and world.fall is None:
        state = world.step(balance(state))
        highest = max(highest, state.body.com[2])
    assert world.fall is None and highest > start + 0.1
    assert np.linalg.norm(state.body.com_velocity) < 0.5

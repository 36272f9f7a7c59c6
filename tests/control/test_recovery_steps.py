"""Tests of recovery steps of a pendulum: an unloaded foot is lifted, and the body is lowered."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.control.gait.phase import GaitState
from plantigrade.control.gait.reference import reference_of
from plantigrade.control.pendulum import Pendulum, PendulumSettings
from plantigrade.control.pendulum.push_memory import PushMemory, PushSettings
from plantigrade.control.pendulum.speed import SpeedControl, SpeedSettings

STEP = 0.005  # [s]


@pytest.mark.parametrize(
    ("behind", "recovers", "pushed", "lifted"),
    [(0.1, True, False, 3), (0.4, True, True, 10), (0.4, True, False, None)]
    + [(0.1, False, True, None)],
)
def test_the_rear_foot_is_lifted_in_a_recovery_step_at_once_if_it_bears_little(
    walk, behind, recovers, pushed, lifted
):
    reference = reference_of(walk)
    schedule, weight = reference.schedule, 600.0
    start = next(s.start for s in schedule.stances if s.side == "r") - schedule.first
    phase = start % walk.motion.duration + 0.01
    gait = GaitState(reference, weight, phase)
    assert [foot.side for foot in gait.stance_feet] == ["r", "l"]
    load = weight * np.array([1.0 - behind, behind])
    when = None
    for n in range(1, 12):
        still = np.zeros((2, 3)), np.eye(2)
        gait.update(n * STEP, STEP, load, *still, recovers=recovers, pushed=pushed)
        if when is None and not gait.feet[1].in_stance:
            when = n
    assert when == lifted
    assert gait.feet[0].in_stance
    if lifted:  # on to its next stance, from where the phase is
        assert gait.feet[1].lift_off == phase and gait.feet[1].touchdown > phase


@pytest.mark.parametrize("felt", [1.0, 0.0])
def test_the_body_is_lowered_from_the_decision_for_a_recovery_step_on(walk, world_of, felt):
    """As long as a push was felt not long ago: a walk over tiles is not lowered."""
    own = PendulumSettings()
    push = replace(own.push, recovery_time=felt)
    controller = Pendulum(walk, settings=replace(own, push=push))
    least = controller.settings.plan.recovery_lowering * controller.person.leg_length
    world = world_of(controller)
    state, trunk, lowered = world.reset(), walk.human.body("torso"), []
    while world.time < 0.5:
        if world.time > 0.3:
            world.push(trunk, np.array([0.0, 150.0, 0.0]))
        state = world.step(controller(state))
        lowered.append((world.time, controller.plan.recovery_share, controller.plan.lowering))
    before = [low for time, _, low in lowered if time < 0.3]
    after = [low for time, share, low in lowered if time > 0.32 and share >= 1.0]
    assert max(before) < 0.5 * least
    assert after[-1] > 0.8 * least if felt else after[10] < 0.1 * least


def test_legs_of_a_walk_are_ever_straight_and_of_a_crouch_never(walk):
    """It tells a crouched walk, which recovery steps do not lower, from others."""
    controller = Pendulum(walk)
    rows, person = controller.reference.recorded.rows, controller.person
    assert person.least_flexion(rows.q, rows.foot_position) < 0.02 * person.leg_length
    lower = rows.q.copy()
    lower[:, 2] -= 0.1
    assert person.least_flexion(lower, rows.foot_position) == pytest.approx(0.1, abs=0.03)


@pytest.mark.parametrize(("force", "pushed"), [(40.0, False), (250.0, True)])
def test_a_disturbance_is_a_push_if_it_changes_the_speed(walk, world_of, force, pushed):
    """The least change is 0.08 m/s. A force of 40 N changes that of 65 kg by 0.06 m/s in 0.1 s."""
    controller = Pendulum(walk)
    world = world_of(controller)
    state, trunk = world.reset(), walk.human.body("torso")
    while world.time < 0.5:
        if 0.3 < world.time < 0.4:
            world.push(trunk, np.array([0.0, force, 0.0]))
        state = world.step(controller(state))
    assert controller.plan.push.felt == pushed


def test_a_speed_that_a_push_has_left_is_not_corrected():
    """Half the speed for ten seconds: steps become longer, but not after a push."""
    found = []
    for displaced in (False, True):
        speed, step = SpeedControl(SpeedSettings(), 1.0, 1.2, 0.0), 0.05
        for n in range(200):
            scale = speed.update(1.2, 1.2, 0.6 * n * step, step, displaced=displaced)
        found.append(scale)
    assert found[0] > 1.2 and found[1] == 1.0


@pytest.mark.parametrize("force", [0.0, 300.0])
def test_a_walk_is_displaced_as_long_as_a_push_has_left_it_off_its_path(walk, world_of, force):
    controller = Pendulum(walk)
    world = world_of(controller)
    state, trunk, displaced = world.reset(), walk.human.body("torso"), []
    while world.time < 5.0:
        if 1.0 < world.time < 1.3:
            world.push(trunk, np.array([0.0, -force, 0.0]))
        state = world.step(controller(state))
        displaced.append((world.time, controller.plan.push.displaced))
    assert world.fall is None
    since = [time for time, whether in displaced if whether]
    assert bool(since) == bool(force)
    assert not since or (1.0 < since[0] < 2.0 and since[-1] - since[0] > 0.5)


@pytest.mark.parametrize("lasts", [0.4, 9.0])
def test_a_walk_that_stays_off_its_path_is_led_back_after_a_while(lasts):
    """After a push it comes back by itself; in wind that lasts, by the integral of the offset."""
    memory = PushMemory(0.9, STEP, 0.5, 0.3, PushSettings(max_return_time=6.0))
    aside, found, paths = np.array([0.0, 0.2]), [], []
    for n in range(round(9.0 / STEP)):
        memory.feel(np.array([0.0, 1.0 if n * STEP < lasts else 0.0]))
        paths.append(memory.path_offset(aside, turns=False)[1])
        found.append(memory.displaced)
    assert [found[round(t / STEP)] for t in (0.5, 5.9, 6.5)] == [True, True, False]
    first, then, last = (paths[round(t / STEP)] for t in (1.0, 5.9, 8.0))
    assert first == pytest.approx(then) and last < then - 0.1

"""Recovery steps: planned on a pendulum, and taken in the world."""

import numpy as np
import pytest

from plantigrade.control.balance import Balance
from plantigrade.control.balance.step import (
    BEYOND,
    Pendulum,
    Swing,
    plan_step,
    planned,
    within_reach,
)
from plantigrade.models import Human
from plantigrade.world import Push, World

LEG = 0.8
FEET = np.array([[0.0, -0.09], [0.0, 0.09]])


def pendulum(velocity, pushed=(0.0, 0.0), com=(0.0, 0.0)):
    return Pendulum(
        np.array(com),
        np.array(velocity),
        0.9,
        FEET,
        FEET,
        np.array([1.0, 0.0]),
        LEG,
        np.array(pushed),
    )


@pytest.mark.parametrize("velocity", [(0.4, 0.0), (-0.3, 0.0), (0.1, 0.3)])
@pytest.mark.parametrize("pushed", [(0.0, 0.0), (0.3, 0.0)])
def test_a_pendulum_that_steps_comes_to_rest_before_the_foot(velocity, pushed):
    """Integrated step by step, with the pressure on the standing foot and then on the other."""
    now = pendulum(velocity, pushed)
    step = plan_step(now)
    assert step.miss < 1e-9
    com, speed, dt = now.com.copy(), now.velocity.copy(), 1e-4
    for _ in range(round(step.duration / dt)):
        acceleration = now.omega**2 * (com - FEET[1 - step.side]) + now.pushed
        com, speed = com + dt * speed + 0.5 * dt**2 * acceleration, speed + dt * acceleration
    away = step.place - FEET[1 - step.side]
    away *= BEYOND * LEG / np.linalg.norm(away)
    assert np.allclose(com + speed / now.omega, step.place - away, atol=3e-3)


def test_feet_stay_on_their_own_side_and_within_reach():
    rng = np.random.default_rng(0)
    for velocity in rng.uniform(-3, 3, (50, 2)):
        step = plan_step(pendulum(velocity))
        off = step.place - FEET[1 - step.side]
        assert (-off[1] if step.side == 0 else off[1]) >= 0.1 * LEG
        assert np.linalg.norm(off) < 1.2 * LEG


def test_the_foot_on_the_side_of_a_fall_is_set_there():
    assert plan_step(pendulum((0.0, 0.6))).side == 1
    assert plan_step(pendulum((0.0, -0.6))).side == 0


def test_reach_turns_with_the_person():
    now = pendulum((0.0, 0.0))
    turned = Pendulum(
        now.com, now.velocity, 0.9, FEET[:, ::-1] * [-1, 1], FEET, np.array([0.0, 1.0]), LEG
    )
    assert np.allclose(within_reach(now, 1, np.array([0.2, -1.0]))[0], 0.2)
    assert np.allclose(within_reach(turned, 1, np.array([1.0, 0.2]))[1], 0.2)


def test_a_swing_arrives_where_it_is_planned():
    step = planned(pendulum((0.9, 0.0)), 0, 0.33)
    assert step is not None
    swing, dt = Swing(step, 1.0), 1e-3
    place, velocity, highest = np.array([*FEET[0], 0.0]), np.zeros(3), 0.0
    for k in range(330):
        asked = swing.asked(1.0 + k * dt, place, velocity, 0.0, LEG)
        velocity += dt * asked
        place = place + dt * velocity
        highest = max(highest, place[2])
    assert np.allclose(place[:2], step.place, atol=0.02)
    assert 0.02 < highest < 0.1
    assert abs(place[2]) < 0.01


@pytest.mark.slow
def test_who_is_pushed_too_hard_steps():
    human = Human.create(height=1.5, mass=48.5, joints="66")
    push = Push(force=100.0, duration=0.4, time=0.1)
    ends = []
    for stepping in (False, True):
        world = World(human, disturbances=(push,), rate=1000.0, recording=False)
        balance, state = Balance(stepping=stepping), world.reset()
        while world.time < 3.0 and world.fall is None:
            state = world.step(balance(state))
        ends.append(world.fall is None)
    assert ends == [False, True]
    assert np.linalg.norm(state.body.com_velocity) < 0.3

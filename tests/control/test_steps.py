"""Recovery steps: planned on a pendulum, and taken in the world."""

from dataclasses import replace

import numpy as np
import pytest

from plantigrade.control.balance.controller import kept_from_stops
from plantigrade.control.gait.step import (
    BEYOND,
    LANDS,
    UNDER,
    Pendulum,
    Swing,
    plan_step,
    planned,
    within_reach,
)
from plantigrade.control.gait.support import beyond, nearest
from plantigrade.experiments.standing import Standing, stands
from plantigrade.world import Push

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
    assert step.miss < 1e-9 and step.remains < 1e-9
    com, speed, dt = now.com.copy(), now.velocity.copy(), 1e-4
    for _ in range(round((step.duration + LANDS) / dt)):
        acceleration = now.omega**2 * (com - FEET[1 - step.side]) + now.pushed
        com, speed = com + dt * speed + 0.5 * dt**2 * acceleration, speed + dt * acceleration
    capture = com + speed / now.omega
    along = step.place - FEET[1 - step.side]
    part = (capture - FEET[1 - step.side]) @ along / (along @ along)
    beside = capture - FEET[1 - step.side] - part * along
    assert 0 < part < 1  # it is between the feet, with room left before the one that is set
    assert np.linalg.norm(beside) < UNDER + 3e-3
    assert (1 - part) * np.linalg.norm(along) > 0.5 * BEYOND * LEG


def test_what_one_step_leaves_the_next_ones_take_up():
    """Sideways a foot reaches only so far; from a middle speed on it takes more than one step."""
    slow, middle, fast = (plan_step(pendulum((0.0, v))) for v in (0.5, 0.8, 1.5))
    assert slow.miss < 1e-9
    assert middle.miss > 0.05 and middle.remains < 1e-9
    assert fast.remains > fast.miss > middle.miss  # not even three steps stop this one


def test_the_nearest_place_of_a_support_is_no_farther_than_any_other():
    rng = np.random.default_rng(1)
    points = rng.normal(size=(12, 2)) * [0.3, 0.1]
    inner = rng.dirichlet(np.ones(12), 4000) @ points
    for place in rng.normal(size=(20, 2)) * 0.6:
        found = nearest(points, place, 0.0)
        assert beyond(points, found) < 2e-3
        assert np.linalg.norm(found - place) < np.linalg.norm(inner - place, axis=1).min() + 2e-3


def test_feet_stay_on_their_own_side_and_within_reach():
    rng = np.random.default_rng(0)
    for velocity in rng.uniform(-3, 3, (50, 2)):
        step = plan_step(pendulum(velocity))
        off = step.place - FEET[1 - step.side]
        assert (-off[1] if step.side == 0 else off[1]) >= 0.1 * LEG
        assert np.linalg.norm(off) < 1.2 * LEG


def test_a_foot_is_set_no_farther_behind_the_other_than_told():
    far = np.array([[-2.0, FEET[1][1]]])
    for back in (0.72, 0.9):
        now = replace(pendulum((0.0, 0.0)), back=back)
        ((x, _),) = within_reach(now, 1, far)
        assert FEET[0][0] - x <= back * LEG + 1e-9
        assert FEET[0][0] - x > 0.9 * back * LEG


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


def test_joints_near_a_stop_are_slowed_and_not_led_away_from_it():
    stops, rates = np.array([[-1.0] * 5, [1.0] * 5]), np.array([0.0, 0.0, -2.0, 0.0, 2.0])
    angles = np.array([0.0, -0.95, -0.95, -1.05, 0.95])
    asked, weight = np.full(5, 3.0), np.full(5, 0.5)
    kept_from_stops(stops, angles, rates, asked, weight)
    assert (asked[0], weight[0]) == (3.0, 0.5)  # far from both
    assert asked[1] == 3.0 and weight[1] > 10.0  # at rest near one: as it was, but firmly
    assert asked[2] > 50.0  # on its way into one: slowed
    assert asked[3] == pytest.approx(20.0) and weight[3] == 100.0  # beyond one: led back
    assert asked[4] == pytest.approx(-60.0)


@pytest.mark.slow
@pytest.mark.parametrize("towards, force", [(0.0, 100.0), (90.0, 115.0), (180.0, 165.0)])
def test_who_is_pushed_too_hard_steps(towards, force):
    """Afterwards the person is at rest, and the feet hardly push against each other.

    From behind twice, from the front three times what is withstood in place. Some steps later the
    last bit of a processor's arithmetic can decide, so of three pushes that differ by 1 % one may
    fail.
    """
    withstood = 0
    for part in (0.99, 1.0, 1.01):
        push = Push(force=part * force, duration=0.4, time=0.1, direction=np.deg2rad(towards))
        world, balance = Standing(formulation="stepping")((push,))
        state, opposing = world.reset(), [0.0]
        while world.time < 5.5 and world.fall is None:  # as long as the table of pushes watches
            state = world.step(balance(state))
            if world.time > 4.5:
                opposing.append(abs(balance.recovery.opposing(state)))
        calm = max(opposing) < 0.15 * state.body.mass * 9.81
        said = balance.said()[0]
        assert "recovery step" in said
        if towards == 90.0:
            assert "to the left" in said
        if world.fall is None and stands(world) and calm:
            withstood += 1
            assert balance.recovery.steps == len(balance.recovery.taken)
    assert withstood >= 2


@pytest.mark.slow
def test_without_steps_such_a_push_is_too_hard():
    world, balance = Standing(formulation="torque")((Push(force=130.0, duration=0.4, time=0.1),))
    state = world.reset()
    while world.time < 3.0 and world.fall is None:
        state = world.step(balance(state))
    assert world.fall is not None and balance.said() == ()

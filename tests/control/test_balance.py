"""Balance: who stands, is pushed, stands on a ball; and the parts it is made of."""

import numpy as np
import pytest

from plantigrade.control.balance import Balance, BalanceSettings
from plantigrade.control.balance.controller import momentum_rows
from plantigrade.control.gait.support import inside
from plantigrade.kinematics.state import State as BodyState
from plantigrade.models import Human
from plantigrade.world import Push, World
from plantigrade.world.grounds import ground_named

HUMAN = Human.create(height=1.5, mass=48.5, joints="66")


def simulated(world, duration):
    """Return the state at the end, and whether every program was solved."""
    balance, state, solved = Balance(), world.reset(), []
    while world.time < duration:
        command = balance(state)
        solved.append(command.signals["solved"])
        state = world.step(command)
    return balance, state, all(solved)


def test_who_stands_keeps_standing():
    world = World(HUMAN, rate=500.0, recording=False)
    start = world.reset().body.com
    balance, state, solved = simulated(world, 0.8)
    assert solved
    assert np.abs(state.body.com - balance.goal).max() < 0.003
    forward = balance.goal - start  # towards the middle of the soles
    assert 0.0 < forward[0] < 0.02 and np.abs(forward[1:]).max() < 0.002
    assert np.abs(state.rates).max() < 0.15  # arms still come to rest
    assert np.isclose(state.contact_force[:, 2].sum(), 48.5 * 9.81, rtol=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("direction, force", [(180.0, 50.0), (90.0, 60.0), (0.0, 55.0)])
def test_who_is_pushed_stays_on_the_feet(direction, force):
    """Springs alone (``posture``) carry less than half of it."""
    push = Push(force=force, duration=0.4, direction=np.deg2rad(direction), time=0.1)
    world = World(HUMAN, disturbances=(push,), rate=500.0, recording=False)
    balance, state, solved = simulated(world, 2.5)
    assert solved
    assert world.fall is None
    assert np.linalg.norm(state.body.com_velocity) < 0.15
    assert np.linalg.norm((state.body.com - balance.goal)[:2]) < 0.05


def test_rows_of_the_angular_momentum_are_its_rate():
    rng = np.random.default_rng(0)
    qpos = HUMAN.standing()
    qpos[3:7] = np.array([0.9, 0.1, -0.3, 0.2]) / np.linalg.norm([0.9, 0.1, -0.3, 0.2])
    qpos[7:] += rng.uniform(-0.2, 0.2, len(qpos) - 7)
    qvel, qacc = rng.uniform(-1, 1, (2, HUMAN.model.nv))
    state = BodyState(HUMAN, qpos, qvel)
    settings = BalanceSettings()
    rows, h = momentum_rows(state, settings), 1e-5
    known = rows.right + settings.momentum_damping * state.angular_momentum / state.mass
    before, after = (state.integrated(qacc, t).angular_momentum for t in (-h, h))
    rate = (after - before) / (2 * h)  # with the velocity of the middle of the step
    assert np.allclose(state.mass * (rows.matrix @ qacc - known), rate, atol=2e-3)


def test_a_goal_is_drawn_inside_the_support():
    square = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.1], [0.0, 0.1]])
    within = np.array([0.1, 0.05])
    assert np.allclose(inside(square, within, 0.015), within)
    assert np.allclose(inside(square, np.array([0.3, 0.05]), 0.015), [0.185, 0.05])
    corner = inside(square, np.array([-1.0, 1.0]), 0.015)
    assert 0.015 <= corner[0] < 0.1 and 0.05 < corner[1] <= 0.085 + 1e-9
    assert np.allclose(
        inside(square[:2], within, 0.015), [0.1, 0.0], atol=1e-9
    )  # a line has only its middle
    narrow = square * [1.0, 0.1]
    assert 0.0 < inside(narrow, np.array([0.1, 0.5]), 0.015)[1] < 0.01


@pytest.mark.slow
def test_a_ball_is_stood_upon():
    """The multi-segment foot takes its shape; the normals are those of the simulator."""
    world = World(HUMAN, ground_named("sphere:1"), rate=500.0, recording=False)
    balance, state, _ = simulated(world, 2.0)
    assert world.fall is None
    assert state.world.data.ncon >= 16
    assert np.linalg.norm((state.body.com - balance.goal)[:2]) < 0.01

"""Balance: a person who stands, is pushed, stands on a ball; and the support it works with."""

import numpy as np
import pytest

from plantigrade.control.balance import Balance
from plantigrade.control.gait.support import beyond, inside, nearest
from plantigrade.models import Human
from plantigrade.world import Push, World
from plantigrade.world.grounds import ground_named

HUMAN = Human.create(height=1.5, mass=48.5, joints="66")


def simulated(world, duration):
    """Return the controller, and the state at the end; every program has a solution."""
    balance, state = Balance(), world.reset()
    while world.time < duration:
        command = balance(state)
        assert command.signals["solved"]
        state = world.step(command)
    return balance, state


def test_a_standing_person_keeps_standing():
    world = World(HUMAN, rate=500.0, recording=False)
    start = world.reset().body.com
    balance, state = simulated(world, 0.8)
    assert np.abs(state.body.com - balance.goal).max() < 0.003
    forward = balance.goal - start  # towards the middle of the soles
    assert 0.0 < forward[0] < 0.02 and np.abs(forward[1:]).max() < 0.002
    assert np.abs(state.rates).max() < 0.15  # arms still come to rest
    assert np.isclose(state.contact_force[:, 2].sum(), 48.5 * 9.81, rtol=0.01)


@pytest.mark.slow
@pytest.mark.parametrize("direction, force", [(180.0, 50.0), (90.0, 60.0), (0.0, 55.0)])
def test_a_pushed_person_stays_on_the_feet(direction, force):
    """Springs alone (``posture``) withstand less than half of it."""
    push = Push(force=force, duration=0.4, direction=np.deg2rad(direction), time=0.1)
    world = World(HUMAN, disturbances=(push,), rate=500.0, recording=False)
    balance, state = simulated(world, 2.5)
    assert world.fall is None
    assert np.linalg.norm(state.body.com_velocity) < 0.15
    assert np.linalg.norm((state.body.com - balance.goal)[:2]) < 0.05


@pytest.mark.slow
def test_a_person_stands_on_a_ball():
    """The multi-segment foot takes its shape; the normals are those of the simulator."""
    world = World(HUMAN, ground_named("sphere:1"), rate=500.0, recording=False)
    balance, state = simulated(world, 2.0)
    assert world.fall is None
    assert state.world.data.ncon >= 16
    assert np.linalg.norm((state.body.com - balance.goal)[:2]) < 0.01


def test_a_position_is_drawn_inside_the_support():
    square, margin = np.array([[0.0, 0.0], [0.2, 0.0], [0.2, 0.1], [0.0, 0.1]]), 0.015
    within = np.array([0.1, 0.05])
    assert np.allclose(inside(square, within, margin), within)
    assert np.allclose(inside(square, np.array([0.3, 0.05]), margin), [0.185, 0.05])
    corner = inside(square, np.array([-1.0, 1.0]), margin)
    assert margin <= corner[0] < 0.1 and 0.05 < corner[1] <= 0.1 - margin + 1e-9
    # A line has only its middle, and a narrow support keeps half its width.
    assert np.allclose(inside(square[:2], within, margin), [0.1, 0.0], atol=1e-9)
    assert 0.0 < inside(square * [1.0, 0.1], np.array([0.1, 0.5]), margin)[1] < 0.01


def test_no_position_of_the_support_is_nearer_than_the_nearest():
    rng = np.random.default_rng(1)
    points = rng.normal(size=(12, 2)) * [0.3, 0.1]
    inner = rng.dirichlet(np.ones(12), 4000) @ points
    for position in rng.normal(size=(20, 2)) * 0.6:
        found = nearest(points, position, 0.0)
        assert beyond(points, found) < 2e-3
        distance = np.linalg.norm(inner - position, axis=1).min()
        assert np.linalg.norm(found - position) < distance + 2e-3

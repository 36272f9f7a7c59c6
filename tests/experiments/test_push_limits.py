"""Limits of pushes: found where they are, said where they are not monotone, and what to expect."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from experiments.push_limits import (
    PushTest,
    predicted_limit,
    push_limit,
    push_map,
)
from plantigrade.constants import GRAVITY
from plantigrade.contact.ground import Ground
from plantigrade.control import Posture
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.world import World, standing_on
from plantigrade.world.disturbance import body_index

HUMAN = Human.create(1.7, 65.0, "female", "42", "rigid", full_sole=True)


def held(disturbances):
    """The person held in a posture by springs."""
    return World(HUMAN, disturbances=disturbances, rate=300.0, recording=False), Posture()


@pytest.mark.parametrize("limit", [3.0, 57.5, 60.0, 431.0])
def test_the_limit_is_the_last_force_of_the_grid_that_is_withstood(limit):
    found = push_limit(lambda force: force <= limit, step=2.5)
    assert found.force == 2.5 * (limit // 2.5) and not found.gaps and not found.open
    assert found.tried[found.force + 2.5] is False
    assert len(found.tried) < 20


def test_a_weaker_push_that_is_not_withstood_is_reported():
    found = push_limit(lambda force: force <= 100.0 and not 70.0 < force < 80.0, step=5.0)
    assert found.force == 100.0 and found.gaps == (75.0,)


def test_limits_beyond_what_is_tried_are_open_and_none_is_zero():
    assert push_limit(lambda _: True, most=200.0, step=5.0).open
    assert push_limit(lambda _: True, most=200.0, step=5.0).force == 200.0
    nothing = push_limit(lambda _: False, step=5.0)
    assert nothing.force == 0.0 and not nothing.open
    with pytest.raises(ParameterError, match="must be positive"):
        push_limit(lambda _: True, step=0.0)


def test_a_limit_in_a_world_is_the_same_twice():
    test = PushTest(situation=held, duration=0.2, time=0.1, watch_time=0.6)
    how = {"guess": 300.0, "step": 150.0, "most": 1200.0, "below": ()}
    first, again = ([d.result for d in push_map(test, (0.0,), **how)] for _ in range(2))
    assert first == again and first[0] is not None and 0 < first[0].force < 1200.0
    world = test.pushed(1000.0, 0.0)
    assert world.fall is not None and world.time < 0.8  # not watched any longer


def test_what_counts_as_withstood_is_the_callers():
    test = PushTest(situation=held, time=0.1, watch_time=0.1, withstood=lambda world: False)
    assert not test(1.0, 0.0)
    light = PushTest(situation=held, time=0.1, duration=0.1, watch_time=0.1)
    assert light(1.0, 0.0) and not light(5000.0, 0.0)


@pytest.mark.parametrize("direction", [0.0, 2.0])
def test_a_pendulum_pushed_by_the_predicted_force_can_just_be_stopped(direction):
    """Integrated step by step, the pressure at the edge from the beginning: no formula."""
    world = World(HUMAN, recording=False)
    state = world.reset()
    force = predicted_limit(world, direction, 0.4)
    way = np.array([np.cos(direction), np.sin(direction)])
    spheres = np.array([world.data.geom(f"contact_{s.name}").xpos for s in world.sites])
    com, mass = state.body.com, HUMAN.mass
    arm = world.data.xipos[body_index(HUMAN)][2] - com[2]
    if direction == 0.0:
        edge = spheres[:, 0].max() - com[0]
    else:  # where a line from under the centre of mass leaves the hull, by bisection on a polygon
        hull, low, high = Delaunay(spheres[:, :2]), 0.0, 1.0
        while high - low > 1e-9:
            middle = (low + high) / 2
            inside = hull.find_simplex(com[:2] + middle * way) >= 0
            low, high = (middle, high) if inside else (low, middle)
        edge = low
    ends = []
    omega = np.sqrt(GRAVITY / com[2])
    for factor in (0.98, 1.02):
        x = v = 0.0
        for _ in range(4000):
            a = omega**2 * (x - edge) + factor * force / mass * (1 + arm / com[2])
            x, v = x + v * 1e-4, v + a * 1e-4
        ends.append(x + v / omega)  # beyond the edge nothing brings it back
    assert ends[0] < edge < ends[1]


def test_the_stance_is_at_the_requested_place():
    human = Human.create(1.5, 48.5, "female", "66")
    qpos = standing_on(human, Ground(), com_along_sole=0.6, width=0.25)
    world = World(human, qpos=qpos, recording=False)
    body = world.reset().body
    apart = body.origin("foot_l") - body.origin("foot_r")
    np.testing.assert_allclose(apart, [0.0, 0.25, 0.0], atol=1e-3)
    soles = np.array([world.data.geom(f"contact_{s.name}").xpos for s in world.sites])
    assert np.ptp(soles[:, 2]) < 2e-3
    share = (body.com[0] - soles[:, 0].min()) / np.ptp(soles[:, 0])
    assert share == pytest.approx(0.6, abs=0.01)
    with pytest.raises(ParameterError, match="ankles 5 m apart"):
        standing_on(human, Ground(), width=5.0)
    with pytest.raises(ParameterError, match="must be from 0"):
        standing_on(human, Ground(), com_along_sole=1.5)

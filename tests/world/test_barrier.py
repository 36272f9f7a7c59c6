"""A bar across the way."""

import numpy as np
import pytest

from plantigrade.control import passive
from plantigrade.control.pendulum import Walker
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.workflows.simulate import spare, touched
from plantigrade.world import Barrier, World

HUMAN = Human.create(1.75, 70.0, "male", "42", "rigid")


def under(height: float) -> World:
    """Return a person who stands under a bar."""
    qpos = HUMAN.standing()
    qpos[0] = 1.0
    return World(HUMAN, None, (Barrier(ahead=1.0, height=height),), qpos=qpos)


def test_words_of_a_barrier():
    for word in ("5", "5,1,2", "5,high", "0.1,1.5", "5,0.1", "5,nan"):
        with pytest.raises(ParameterError):
            Barrier.parse(word)


@pytest.mark.parametrize("above", [0.1, -0.06])
def test_the_clearance_is_that_over_the_head_and_a_person_in_the_bar_is_pushed_out(above):
    record = under(HUMAN.height + above).simulate(passive, 0.05)
    assert record.signals["barrier.clearance"][0] == pytest.approx(above, abs=0.02)
    assert touched(record) == (above < 0.0)
    assert ("touch_head" in [s.name for s in record.sites]) == (above < 0.0)
    assert spare(record) <= record.signals["barrier.clearance"][0]


def test_who_is_far_from_a_bar_says_nothing_of_it():
    world = World(HUMAN, None, (Barrier(ahead=9.0, height=1.0),))
    assert "barrier.clearance" not in world.simulate(passive, 0.02).signals


def test_a_walker_stoops_before_a_bar_as_deep_as_it_is_low(walk_of_somebody):
    walk = walk_of_somebody
    spare = 4.0, 8.0  # [cm] a head passes under the bar by a few centimetres
    for ahead, below, stoops in ((0.7, 0.10, True), (9.0, 0.10, False), (0.7, -0.3, False)):
        walker = Walker(walk)
        bar = Barrier(ahead=ahead, height=walk.human.height - below)
        world = World(walk.human, walk.ground, (bar,), rate=600.0, control_rate=200.0)
        walker(world.reset())
        depth = walker.targets[2].value  # [cm]
        assert spare[0] < depth - 100.0 * below < spare[1] if stoops else depth == 0.0
    bar = Barrier(ahead=9.0, height=walk.human.height - 0.4)
    world = World(walk.human, walk.ground, (bar,), rate=600.0, control_rate=200.0)
    with pytest.raises(ParameterError, match="too low to walk under: somebody of 1.75 m stoops"):
        walker(world.reset())


@pytest.fixture(scope="module")
def walk_of_somebody():
    """A motion that repeats itself, at 1 m/s."""
    from plantigrade.motion import Motion
    from plantigrade.record import Record

    time = np.linspace(0.0, 1.0, 21)
    qpos = np.tile(HUMAN.standing(), (21, 1))
    qpos[:, 0] += time
    qvel = np.zeros((21, HUMAN.model.nv))
    qvel[:, 0] = 1.0
    return Record(HUMAN, Motion(time, qpos, qvel, HUMAN.joint_names))

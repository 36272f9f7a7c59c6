"""Random worlds hold: every number of them is one."""

import numpy as np
import pytest

from plantigrade.experiments.random_worlds import outcome, random_world, run


def test_a_handful_of_random_worlds_hold():
    found = [outcome(seed, 0.2) for seed in range(4)]
    assert not any(o.broken for o in found)
    assert len({o.speed for o in found}) == 4  # they are not all one


def test_a_seed_makes_the_same_world_again():
    first, second = (random_world(3) for _ in range(2))
    assert first[0].human.to_dict() == second[0].human.to_dict()
    assert first[0].ground == second[0].ground and first[0].disturbances == second[0].disturbances
    one, other = (world.simulate(controller, 0.1) for world, controller in (first, second))
    assert np.array_equal(one.motion.qpos, other.motion.qpos)


@pytest.mark.slow
def test_the_experiment_in_its_short_form():
    table = run(quick=True)
    assert table.metrics()["goals_met"] == 2, table.text()

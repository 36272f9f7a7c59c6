"""Steps in the ground lie between footprints of different height, close to the higher one."""

import numpy as np
import pytest

from plantigrade.contact.ground import ground, treads
from plantigrade.models import Human
from plantigrade.synthesize.tasks.gait_parameters import gait_parameters
from plantigrade.synthesize.tasks.walking_plan import walk_plan


def plan(heights):
    human = Human.create(height=1.7, mass=65.0)
    return walk_plan(human, gait_parameters(human, 1.0), steps=len(heights), heights=heights)


def test_level_ground_has_one_height():
    assert ground(plan([0.0, 0.0, 0.0])) == 0.0


@pytest.mark.parametrize("heights", [[0.0, 0.1, 0.1], [0.0, 0.0, -0.12, -0.12], [0.1, 0.2, 0.2]])
def test_every_footprint_lies_on_the_ground(heights):
    made = plan(heights)
    steps = treads(made)
    assert np.all(np.diff(steps.edges) > 0)
    for stance in made.stances:
        x, _, z = stance.footprint.position
        for reach in (-0.08, 0.0, 0.22):  # heel, ankle, toes
            assert steps.height(np.array([x + reach]))[0] == pytest.approx(z)


def test_a_margin_sees_the_higher_tread_early():
    steps = treads(plan([0.0, 0.15, 0.15]))
    (edge,) = steps.edges
    just_before = np.array([edge - 0.03])
    assert steps.height(just_before)[0] == 0.0
    assert steps.height(just_before, 0.06)[0] == pytest.approx(0.15)

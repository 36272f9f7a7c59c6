"""Soles: the same person on thicker shoes rests on the ground with the same joint angles."""

import numpy as np
import pytest

from plantigrade.kinematics.fitted_soles import MAX_SOLE_DISTANCE, on_own_soles
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import find_rests
from plantigrade.kinematics.textbook_recording import textbook_walk
from tests.models.presets import person

RATE = 100.0


BODIES = [("42", "two-segment"), ("66", "multi-segment")]


@pytest.fixture(scope="module", params=BODIES, ids="-".join)
def walk(request):
    return textbook_walk(person(*request.param), cycles=2)


def rested(human, qpos):
    """Median height of what rests, by region."""
    contact = sole_paths(human, qpos)
    heights = {"heel": [], "ball": [], "toes": []}
    for rest in find_rests(contact, RATE):
        quarter = (rest.stop - rest.start) // 4
        core = slice(rest.start + quarter, rest.stop - quarter)
        index = contact.of(rest.side, rest.region)
        heights[rest.region].append(np.median(contact.position[core][:, index, 2].min(axis=1)))
    return {region: float(np.median(h)) for region, h in heights.items() if h}


def put_on(human, qpos):
    contact = sole_paths(human, qpos)
    return on_own_soles(human, contact, find_rests(contact, RATE))


@pytest.mark.parametrize("lift", [0.02, -0.015, 0.0])
def test_feet_that_rest_off_the_ground_get_soles_that_touch_it(walk, lift):
    raised = walk.qpos.copy()
    raised[:, 2] += lift
    shod = put_on(walk.human, raised)
    for region, height in rested(shod, raised).items():
        assert abs(height) < 0.004, (region, height)


def test_only_the_soles_change(walk):
    raised = walk.qpos.copy()
    raised[:, 2] += 0.02
    shod = put_on(walk.human, raised)
    a, b = walk.human.model, shod.model
    np.testing.assert_array_equal(a.body_mass, b.body_mass)
    np.testing.assert_array_equal(a.body_inertia, b.body_inertia)
    np.testing.assert_array_equal(a.body_pos, b.body_pos)
    np.testing.assert_array_equal(a.jnt_range, b.jnt_range)
    assert shod.coordinates == walk.human.coordinates


def test_both_feet_of_an_even_walk_get_the_same_soles(walk):
    shod = put_on(walk.human, walk.qpos)
    height = {name: float(shod.model.geom(name).pos[2]) for name, _, _ in shod.contact_points}
    for name in height:
        if name.endswith("_r"):
            assert height[name] == pytest.approx(height[name[:-1] + "l"], abs=1e-3)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_feet_far_from_the_floor_stand_on_something_else(walk, way):
    raised = walk.qpos.copy()
    raised[:, 2] += way * (MAX_SOLE_DISTANCE + 0.05)
    shod = put_on(walk.human, raised)
    np.testing.assert_array_equal(shod.model.geom_pos, walk.human.model.geom_pos)

"""Loads on the back and in the hands: mass, place, and a description that is read again."""

import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human


def person(joints: str = "42") -> Human:
    return Human.create(1.75, 75.0, joints=joints)


def com(human: Human) -> np.ndarray:
    return BodyState(human, human.standing()).com


@pytest.mark.parametrize("joints", ["42", "43", "58", "66"])
def test_a_rucksack_adds_its_mass_behind_the_trunk(joints):
    bare, packed = person(joints), person(joints).with_loads({"back": 20.0})
    assert packed.model.body_mass.sum() == pytest.approx(95.0)
    assert packed.mass == 75.0
    # a load of 20 kg moves the centre of mass by 20/95 of its distance
    place = com(bare) + (com(packed) - com(bare)) * 95.0 / 20.0
    assert place[0] < com(bare)[0] - 0.1 and abs(place[1]) < 1e-6
    assert 1.15 < place[2] < 1.55


def test_a_load_in_one_hand_is_at_its_side():
    bare, right = person(), person().with_loads({"hand_r": 10.0})
    shift = com(right) - com(bare)
    assert shift[1] < -0.02 and shift[2] < 0.0
    left = person().with_loads({"hand_l": 10.0})
    np.testing.assert_allclose(com(left) * [1, -1, 1], com(right), atol=1e-9)


def test_a_description_holds_the_loads():
    packed = person().with_loads({"back": 5.0}).with_loads({"back": 7.0, "hand_l": 3.0})
    again = Human.from_dict(packed.to_dict())
    assert dict(again.loads) == {"back": 12.0, "hand_l": 3.0}
    np.testing.assert_allclose(again.model.body_mass, packed.model.body_mass, rtol=1e-9)
    np.testing.assert_allclose(com(again), com(packed), atol=2e-3)


def test_loads_that_nobody_carries_are_refused():
    with pytest.raises(ParameterError, match="no load on 'head'"):
        person().with_loads({"head": 5.0})
    with pytest.raises(ParameterError, match="0 to 60 kg, not 70"):
        person().with_loads({"back": 40.0}).with_loads({"back": 30.0})


@pytest.mark.parametrize("joints", ["42", "66"])
def test_loads_on_the_legs_are_where_they_are_named(joints):
    bare = person(joints)
    heights = []
    for place in ("waist", "thigh_r", "shank_r", "foot_r"):
        heavy = bare.with_loads({place: 5.0})
        shift = (com(heavy) - com(bare)) * 80.0 / 5.0
        at = com(bare) + shift
        assert heavy.model.body_mass.sum() == pytest.approx(80.0)
        assert abs(at[0]) < 0.15 and (at[1] < -0.04 or place == "waist")
        heights.append(at[2])
    assert heights == sorted(heights, reverse=True)
    assert 0.9 < heights[0] < 1.15 and heights[-1] < 0.12

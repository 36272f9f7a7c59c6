"""Demands of a task, as data."""

import json

import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.record import Condition


def test_bounds_are_linear_between_their_times():
    c = Condition("knee", "coordinate", (0.0, 1.0), (0.0, 0.5), (np.inf, np.inf), "knee_angle_r")
    low, high = c.bounds(np.array([0.0, 0.25, 1.0]))
    np.testing.assert_allclose(low, [0.0, 0.125, 0.5])
    assert np.isinf(high).all()


def test_frames_outside_are_not_judged():
    c = Condition("knee", "coordinate", (0.2, np.inf), (0.0, 0.0), (1.0, 1.0), "knee_angle_r")
    assert c.holds_at(np.array([0.1, 0.2, 5.0])).tolist() == [False, True, True]
    assert c.later(1.0).holds_at(np.array([1.1, 1.2])).tolist() == [False, True]


def test_a_condition_survives_json():
    c = Condition("hand", "point", (0.5,), (0.1,), (np.inf,), "hand_r", "x", (0.0, 0.0, -0.1))
    assert Condition.from_dict(json.loads(json.dumps(c.to_dict()))) == c


def test_units_are_si():
    def unit(quantity, of=""):
        return Condition("c", quantity, (0.0,), (0.0,), (0.0,), of).unit

    assert unit("coordinate", "knee_angle_r") == "rad"
    assert unit("coordinate", "pelvis_ty") == "m"
    assert unit("speed", "knee_angle_r") == "rad/s"
    assert unit("com speed") == "m/s"


@pytest.mark.parametrize(
    "change", [{"quantity": "smell"}, {"lower": ()}, {"time": (1.0, 0.0), "lower": (0.0, 0.0)}]
)
def test_what_cannot_be_judged_is_refused(change):
    description = Condition("c", "rest", (0.0,), (0.0,), (0.0,)).to_dict() | change
    with pytest.raises(ParameterError):
        Condition.from_dict(description)

"""The ground is where every footprint stands, and its steps lie close to the higher footprint."""

import numpy as np
import pytest

from plantigrade.constants import FRICTION
from plantigrade.contact.ground import Ground, Seat, Step
from plantigrade.contact.plan import ContactPlan, Footprint, Stance
from plantigrade.errors import ParameterError


def plan(heights, slope=0.0):
    """Return steps of 0.7 m, alternating feet, footprints at the given heights."""
    stances = tuple(
        Stance(Footprint("rl"[i % 2], (0.7 * i, 0.1 * (-1) ** (i + 1), z)), t, t, t + 0.5, t + 0.5,
               t + 0.6)
        for i, (z, t) in enumerate(zip(heights, np.arange(len(heights)) * 0.5, strict=True))
    )  # fmt: skip
    return ContactPlan(float(len(heights)), stances, slope=slope)


def test_level_ground_has_no_steps():
    ground = Ground.of_plan(plan([0.0, 0.0, 0.0]))
    assert ground == Ground() and ground.friction == FRICTION
    assert not ground.under(np.random.default_rng(0).normal(size=(4, 5, 3))).any()


@pytest.mark.parametrize("heights", [[0.0, 0.1, 0.1], [0.0, 0.0, -0.12, -0.12], [0.1, 0.2, 0.2]])
def test_every_footprint_lies_on_the_ground(heights):
    made = plan(heights)
    ground = Ground.of_plan(made)
    for stance in made.stances:
        x, _, z = stance.footprint.position
        for reach in (-0.08, 0.0, 0.22):  # heel, ankle, toes
            assert ground.along(np.array([x + reach]))[0] == pytest.approx(z)


def test_a_margin_sees_the_higher_tread_early():
    ground = Ground.of_plan(plan([0.0, 0.15, 0.15]))
    (step,) = ground.steps
    just_before = np.array([step.x - 0.03])
    assert ground.along(just_before)[0] == 0.0
    assert ground.along(just_before, 0.06)[0] == pytest.approx(0.15)


def test_a_slope_turns_the_normal_and_the_axes():
    ground = Ground(height=0.2, slope=0.3, steps=(Step(1.0, 0.5),))
    np.testing.assert_allclose(ground.to_world @ [0.0, 0.0, 1.0], ground.normal, atol=1e-15)
    assert np.linalg.norm(ground.normal) == pytest.approx(1.0)
    on = np.array([[0.5, 3.0, 0.2], [1.5, -2.0, 0.5]]) @ ground.to_world.T  # x uphill, y, height
    assert on[1, 2] - on[0, 2] > 0.3  # it rises along x
    np.testing.assert_allclose(ground.under(on), on @ ground.normal)


def test_it_comes_back_from_its_description():
    ground = Ground(0.1, 0.2, (Step(0.5, 0.3),), (Seat("seat", (0.0, 0.1, 0.45)),), 0.5)
    assert Ground.from_dict(ground.to_dict()) == ground
    assert Ground.from_dict({}) == Ground()


@pytest.mark.parametrize(
    "description",
    [
        {"friction": -0.1},
        {"friction": float("nan")},
        {"slope": 2.0},
        {"steps": [{"x": 1.0, "height": 0.1}, {"x": 0.0, "height": 0.2}]},
        {"steps": [{"x": 1.0}]},
        {"steps": 3},
        {"seats": [{"site": "seat", "position": ["a"]}]},
        {"height": "high"},
        {"colour": 1},
    ],
)
def test_what_is_not_a_ground_is_refused(description):
    with pytest.raises(ParameterError):
        Ground.from_dict(description)

"""Ground: level, sloped, with steps, bumps, relief and seats."""

import json

import numpy as np
import pytest

from plantigrade import ContactPlan, Ground
from plantigrade.constants import FRICTION
from plantigrade.contact.ground import GroundStep, Seat
from plantigrade.contact.plan import Footprint, PointSupport, Stance
from plantigrade.contact.relief import Bump, HeightField
from plantigrade.contact.site import ContactSite
from plantigrade.errors import ParameterError

LENGTH = 0.6


def plan(heights, **more) -> ContactPlan:
    """A walk whose footprints have these heights [m]."""
    stances = tuple(
        Stance(
            Footprint("rl"[i % 2], (LENGTH * i, 0.1 * (-1) ** (i + 1), z)),
            0.5 * i,
            0.5 * i + 0.1,
            0.5 * i + 0.4,
            0.5 * i + 0.5,
            0.5 * i + 0.6,
        )
        for i, z in enumerate(heights)
    )
    return ContactPlan(0.5 * len(heights), stances, **more)


def test_level_ground_has_one_height():
    assert Ground.of_plan(plan([0.0, 0.0, 0.0])) == Ground(friction=FRICTION)


@pytest.mark.parametrize("heights", [[0.0, 0.1, 0.1], [0.0, 0.0, -0.12, -0.12], [0.1, 0.2, 0.2]])
def test_every_footprint_lies_on_the_ground(heights):
    made = plan(heights)
    ground = Ground.of_plan(made)
    assert np.all(np.diff([step.x for step in ground.steps]) > 0)
    for stance in made.stances:
        x, y, z = stance.footprint.position
        for reach in (-0.08, 0.0, 0.22):  # heel, ankle, toes
            assert ground.under(np.array([x + reach, y, 5.0])) == pytest.approx(z)


def test_steps_on_a_slope_are_measured_along_and_across_it():
    ground = Ground(height=0.2, slope=0.3, steps=(GroundStep(1.0, 0.5),))
    on = np.array([[0.5, 3.0, 0.2], [1.5, -2.0, 0.5]]) @ ground.to_world.T
    assert on[1, 2] - on[0, 2] > 0.3  # it rises along x
    np.testing.assert_allclose(ground.under(on), on @ ground.normal)


def test_a_margin_includes_the_higher_tread():
    ground = Ground.of_plan(plan([0.0, 0.15, 0.15]))
    (edge,) = ground.steps
    just_before = np.array([edge.x - 0.03])
    assert ground.along(just_before)[0] == 0.0
    assert ground.along(just_before, 0.06)[0] == pytest.approx(0.15)


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_clearance_at_an_edge_is_above_its_higher_side(way):
    ground = Ground(steps=(GroundStep(1.0, 0.15),))
    x = np.array([0.7, 0.9, 1.1, 1.3])[:: int(way)]
    z = np.array([0.17, 0.14, 0.18, 0.17])[:: int(way)]
    path = np.stack([x, np.zeros(4), z], axis=1)[:, None]
    own = z - ground.along(x)
    height = ground.passed(path)[:, 0]
    assert height[1] == pytest.approx(0.16 - 0.15)  # half way between them, at the edge
    np.testing.assert_allclose(np.delete(height, 1), np.delete(own, 1), atol=1e-12)
    np.testing.assert_allclose(Ground().passed(path)[:, 0], z)


def test_a_point_of_a_slope_is_as_high_as_the_slope_says():
    slope = np.deg2rad(7.0)
    ground = Ground(slope=slope)
    x = np.array([[0.0, 0.0, 0.0], [1.0, 0.3, np.tan(slope)], [-2.0, 0.0, -2.0 * np.tan(slope)]])
    np.testing.assert_allclose(x @ ground.normal - ground.under(x), 0.0, atol=1e-12)
    np.testing.assert_allclose(ground.to_world[:, 2], ground.normal)
    np.testing.assert_allclose(ground.normal_at(x), np.tile(ground.normal, (3, 1)))


@pytest.mark.parametrize("slope", [0.0, 0.2])
def test_a_bump_is_a_cap_of_a_sphere(slope):
    ground = Ground(slope=slope, bumps=(Bump((0.3, 0.1, -0.4), 0.5),))
    inside = np.array([[0.3, 0.1, 0.1], [0.4, 0.1, -0.4 + np.sqrt(0.24)], [0.9, 0.1, 0.0]])
    world = inside @ ground.to_world.T
    np.testing.assert_allclose(ground.under(world), inside[:, 2], atol=1e-12)
    outward = (inside[:2] - [0.3, 0.1, -0.4]) / 0.5
    np.testing.assert_allclose(
        ground.normal_at(world),
        np.vstack([outward, [0.0, 0.0, 1.0]]) @ ground.to_world.T,
        atol=1e-6,
    )


def test_relief_is_bilinear_and_ends_at_its_edge():
    heights = ((0.0, 0.0, 0.0), (0.0, 0.02, 0.04))
    ground = Ground(height=0.1, field=HeightField((1.0, -1.0), (0.5, 2.0), heights))
    x = np.array([[1.5, 1.0, 0.0], [1.75, 0.0, 0.0], [0.9, 0.0, 0.0]])
    np.testing.assert_allclose(ground.under(x), [0.12, 0.115, 0.1])
    normal = ground.normal_at(x[1])
    np.testing.assert_allclose(normal[:2] / normal[2], [-0.02, -0.015], rtol=1e-4)


def test_a_ground_round_trips_through_json():
    seat = Seat("seat_r", (0.1, 0.0, 0.45))
    field = HeightField((0.0, 0.0), (0.1, 0.1), ((0.0, 0.01), (0.0, 0.02)))
    ground = Ground(
        0.1, 0.05, (GroundStep(0.4, 0.2),), (seat,), 0.6, (Bump((0, 0, 0), 0.02),), field
    )
    again = Ground.from_dict(json.loads(json.dumps(ground.to_dict())))
    assert again == ground and Ground.from_dict({}) == Ground()
    site = ContactSite(body="pelvis", name="seat_r", part="chair")
    sits = plan([0.0], supports=(PointSupport(site, (0.1, 0.0, 0.45), 0.0, 1.0),))
    assert Ground.of_plan(sits).seats == (seat,)


@pytest.mark.parametrize(
    "broken, match",
    [
        ({"friction": -0.1}, "friction"),
        ({"friction": float("nan")}, "friction"),
        ({"steps": [{"x": 1.0}]}, "height"),
        ({"steps": 3}, "not a description"),
        ({"seats": [{"site": "seat", "position": ["a"]}]}, "not a description"),
        ({"height": "high"}, "not a description"),
        ({"colour": 1}, "colour"),
        ({"slope": 2.0}, "right angle"),
        ({"steps": [{"x": 1.0, "height": 0.1}, {"x": 0.0, "height": 0.0}]}, "order"),
        ({"seats": [{"site": "a", "position": [0.0, 1.0]}]}, "2 numbers where 3"),
        ({"field": {"corner": [0, 0], "spacing": [1, 1], "heights": [[0.0]]}}, "two or more rows"),
        ({"bumps": [{"centre": [0, 0, 0]}]}, "radius"),
    ],
)
def test_an_invalid_ground_raises(broken, match):
    with pytest.raises(ParameterError, match=match):
        Ground.from_dict(broken)


def test_a_support_beside_a_slope_is_turned_with_it():
    site = ContactSite(body="hand_r", name="hand_r", part="hand")
    rail = PointSupport(site, (0.3, -0.4, 0.9), 0.0, 1.0)
    (seat,) = Ground.of_plan(plan([0.0], supports=(rail,), slope=0.2)).seats
    c, s = np.cos(0.2), np.sin(0.2)
    np.testing.assert_allclose(seat.normal, (-s, 0.0, c), atol=1e-12)  # 0.9 m over the surface
    np.testing.assert_allclose(seat.position, (0.3 * c - 0.9 * s, -0.4, 0.3 * s + 0.9 * c))

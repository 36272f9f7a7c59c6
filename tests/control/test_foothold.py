"""Where a sole can stand on uneven ground."""

import numpy as np
import pytest

from plantigrade.contact.ground import Ground, GroundStep
from plantigrade.contact.relief import HeightField
from plantigrade.control.gait.person import SoleShape
from plantigrade.control.gait.phase import Foot
from plantigrade.control.gait.swing import SwingOffsetSettings
from plantigrade.control.pendulum.ground import GroundSettings, SoleOnGround
from plantigrade.control.pendulum.plan import body_axes

LEG, SETTINGS = 0.9, GroundSettings()
SHAPE = SoleShape(heel=-0.063, heel_centre=-0.045, ball=0.153, toes=0.216, half_width=0.0405)
X = np.array([1.0, 0.0])


def edge(y: float, height: float = 0.05) -> Ground:
    """Return ground that is higher to the left of a line along x."""
    cells = np.arange(-1.0, 1.0, 0.02)
    row = np.where(cells > y, height, 0.0)
    heights = tuple((float(z), float(z)) for z in row)
    return Ground(field=HeightField((-2.0, -1.0), (4.0, 0.02), heights))


def spread(sole: SoleOnGround, ground: Ground, place) -> float:
    """Return by how much the ground differs from one side of the sole to the other [m]."""
    high = sole.heights(ground, np.array([place]), X)[0]
    return float(np.abs(high[:, 0] - high[:, 1]).max())


@pytest.mark.parametrize("y", (0.08, 0.1, 0.12))
def test_a_foot_that_would_land_half_on_an_edge_is_put_beside_it(y):
    sole, ground, place = SoleOnGround(LEG, SHAPE, 1.0), edge(y), np.array([0.3, 0.1])
    assert spread(sole, ground, place) == pytest.approx(0.05)
    shift = sole.shift(ground, place, np.array([0.0, -0.1]), np.eye(2), 0.3)
    assert spread(sole, ground, place + shift) < 0.005
    assert shift[0] == 0.0  # along the edge nothing is gained
    np.testing.assert_array_equal(  # just before it lands nothing is changed any more
        sole.shift(ground, place + 0.05, np.array([0.0, -0.1]), np.eye(2), 0.05), shift
    )


def test_on_a_plane_nothing_is_shifted_and_never_a_foot_onto_the_other():
    place, other = np.array([0.3, 0.1]), np.array([0.0, -0.1])
    level = SoleOnGround(LEG, SHAPE, 1.0).shift(
        Ground(steps=(GroundStep(5.0, 0.1),)), place, other, np.eye(2), 0.3
    )
    np.testing.assert_array_equal(level, [0.0, 0.0])
    ground = edge(0.1)
    near = np.array(
        [0.0, 0.1 - SwingOffsetSettings.min_foot_distance * LEG - 0.01]
    )  # a shift inward would be on this foot
    assert SoleOnGround(LEG, SHAPE, 1.0).shift(ground, place, near, np.eye(2), 0.3)[1] > 0.0


def test_a_sole_lies_on_heel_and_ball_and_is_kept_level_over_an_edge_along_it():
    sole = SoleOnGround(LEG, SHAPE, 1.0)
    over = sole.under(Ground(steps=(GroundStep(0.05, 0.05),)), np.zeros(2), X)
    rise = np.arctan(0.05 / (SHAPE.ball - SHAPE.heel_centre))
    np.testing.assert_allclose(np.arctan2(-over[0], over[2]), rise, atol=1e-9)
    assert over[1] == 0.0
    along = sole.under(edge(0.0), np.zeros(2), X)
    slope = 0.05 / (2 * SHAPE.half_width)
    assert np.arctan2(-along[1], along[2]) <= SETTINGS.max_tilt[0] < slope
    slanted = sole.under(edge(0.0, 0.005), np.zeros(2), np.array([0.0, 1.0]))
    assert slanted[0] == pytest.approx(0.0, abs=1e-12) and slanted[1] < 0.0


def test_a_heel_whose_end_is_beyond_an_edge_stands_on_what_is_under_its_middle():
    sole, edge = SoleOnGround(LEG, SHAPE, 1.0), 0.5 * (SHAPE.heel + SHAPE.heel_centre)
    ground = Ground(steps=(GroundStep(edge, 0.03),))
    np.testing.assert_allclose(sole.under(ground, np.zeros(2), X), [0.0, 0.0, 1.0], atol=1e-12)


def test_a_foot_on_its_way_turns_from_how_it_stood_to_how_it_lands():
    sole, ground = SoleOnGround(LEG, SHAPE, 1.0), Ground(steps=(GroundStep(0.5, 0.1),))
    foot, at = Foot("l", 1, True), np.zeros(2)
    stood = sole.normal(ground, foot, 0.0, at, X, None, X)
    foot.in_stance, foot.lift_off, foot.touchdown = False, 1.0, 1.5
    goal = np.array([0.45, 0.0])  # heel before the step, ball on it
    lies = sole.under(ground, goal, X)
    assert stood[0] == 0.0 > lies[0]
    ways = [sole.normal(ground, foot, t, at, X, goal, X)[0] for t in (1.0, 1.25, 1.5)]
    np.testing.assert_allclose(ways[::2], [0.0, lies[0]], atol=1e-12)
    assert ways[0] > ways[1] > ways[2]
    np.testing.assert_array_equal(sole.normal(ground, foot, 1.4, at, X, None, X), stood)


@pytest.mark.parametrize(
    ("degrees", "ahead"),
    [(0, (1, 0)), (40, (1, 0)), (-100, (0, -1)), (90, (0, 1)), (170, (-1, 0)), (-150, (-1, 0))],
)
def test_a_foot_passes_the_other_along_the_body_wherever_the_walk_leads(degrees, ahead):
    half = 0.5 * np.radians(degrees)
    axes = body_axes(np.array([np.cos(half), 0.0, 0.0, np.sin(half)]))
    np.testing.assert_array_equal(axes[:, 0], ahead)
    np.testing.assert_array_equal(axes[:, 1], [-ahead[1], ahead[0]])

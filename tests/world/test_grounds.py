"""Grounds by name: what they are, and that a person stands on them."""

import numpy as np
import pytest

from plantigrade.contact.ground import Ground
from plantigrade.contact.site import GEOM_PREFIX, contact_sites
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.world import World, fit_soles, on_ground, standing_on
from plantigrade.world.grounds import ground_named
from plantigrade.world.standing import at_placement

HUMAN = Human.create(joints="42", feet="rigid")


def height(ground: Ground, x: float, y: float = 0.0) -> float:
    return float(ground.under(np.array([x, y, 0.0])))


def test_every_ground_is_what_its_name_says():
    assert ground_named("flat") == Ground()
    assert ground_named("slope:5").slope == pytest.approx(np.deg2rad(5.0))
    for word, sign in (("ramp:5", 1.0), ("ramp:-5", -1.0)):
        ramp = ground_named(word)
        assert height(ramp, 3.9) == pytest.approx(0.0, abs=1e-12)
        assert height(ramp, 14.0) == pytest.approx(sign * 10.0 * np.tan(np.deg2rad(5.0)))
        normal = ramp.normal_at(np.array([9.1, 0.3, 0.0]))
        assert np.arctan2(-normal[0], normal[2]) == pytest.approx(sign * np.deg2rad(5.0))
    assert height(ground_named("sphere:1"), 0.05) == pytest.approx(0.0)
    assert height(ground_named("sphere:1"), 0.65) == pytest.approx(-0.2)
    assert height(ground_named("dome:2"), 0.05, 0.09) == pytest.approx(0.02)
    assert height(ground_named("dome:2"), 1.0) == 0.0
    assert [height(ground_named("steps:10"), x) for x in (0.4, 0.6, 1.2)] == pytest.approx(
        [0.0, 0.1, 0.2]
    )
    bumps = ground_named("bumps:3", seed=1)
    z = np.array([height(bumps, x) for x in np.arange(0.0, 5.0, 0.05)])
    assert 0.005 < np.ptp(z) and np.abs(z).max() <= 0.03 + 1e-9
    assert bumps == ground_named("bumps:3", seed=1) != ground_named("bumps:3", seed=2)
    trench = ground_named("stones")
    z = [height(trench, x, y) for x in np.arange(2, 4, 0.05) for y in (-0.1, 0.1)]
    assert set(np.round(z, 6)) >= {0.0, -0.2}


@pytest.mark.parametrize(
    "word", ["hill", "slope", "slope:x", "slope:80", "slope:nan", "flat:3", "sphere:0.01", ""]
)
def test_what_is_no_ground_is_refused(word):
    with pytest.raises(ParameterError, match="ground|needs a number|takes no number"):
        ground_named(word)


def gaps(ground: Ground, qpos) -> np.ndarray:
    """Distances of the contact spheres from a ground, along its normal there."""
    radius = np.array([[s.radius] for s in contact_sites(HUMAN)])
    centre = BodyState(HUMAN, qpos).position(PointSet.of(HUMAN, contact_sites(HUMAN)))
    low = centre - radius * ground.normal_at(centre)
    return low @ ground.normal - ground.under(low)


@pytest.mark.parametrize("word", ["slope:12", "bumps:3"])
@pytest.mark.parametrize("turn", [0.5 * np.pi, np.pi])
def test_who_stands_elsewhere_and_turned_has_the_soles_on_the_ground_there(word, turn):
    ground, place = ground_named(word, seed=3), (1.0, -0.5, turn)
    qpos, level = standing_on(HUMAN, ground, placement=place), standing_on(HUMAN, Ground())
    lifted = on_ground(HUMAN, ground, at_placement(level, place))
    found, expected = BodyState(HUMAN, qpos), BodyState(HUMAN, lifted)
    np.testing.assert_allclose(found.com[:2], expected.com[:2], atol=0.01)
    for foot in ("foot_r", "foot_l"):
        i = HUMAN.body(foot)
        np.testing.assert_allclose(found.origins[i, :2], expected.origins[i, :2], atol=0.03)
        assert found.rotation(foot)[:, 0] @ expected.rotation(foot)[:, 0] > 0.97
    assert np.ptp(gaps(ground, qpos)) < 0.6 * np.ptp(gaps(ground, lifted))
    if "slope" in word:
        assert np.ptp(gaps(ground, qpos)) < 4e-3


def test_a_posture_is_laid_on_other_ground():
    flat, slope = standing_on(HUMAN, Ground()), ground_named("slope:10")
    assert np.ptp(gaps(slope, on_ground(HUMAN, slope, flat))) > 0.03
    there = fit_soles(HUMAN, slope, flat)
    assert np.ptp(gaps(slope, there)) < 2e-3
    np.testing.assert_allclose(
        BodyState(HUMAN, there).com[:2], BodyState(HUMAN, flat).com[:2], atol=0.01
    )


@pytest.mark.parametrize("word", ["flat", "slope:8", "sphere:1", "dome:1", "stones"])
def test_a_person_starts_on_the_ground_over_the_feet(word):
    ground = ground_named(word)
    qpos = standing_on(HUMAN, ground)
    world = World(HUMAN, ground, rate=300.0, qpos=qpos, recording=False)
    state = world.reset()
    sites = contact_sites(HUMAN)
    x = [world.data.geom(GEOM_PREFIX + s.name).xpos[0] for s in sites]
    assert min(x) + 0.05 < state.body.com[0] < max(x) - 0.05
    low = [
        world.data.geom(GEOM_PREFIX + s.name).xpos
        - s.radius * ground.normal_at(world.data.geom(GEOM_PREFIX + s.name).xpos)
        for s in sites
    ]
    gap = np.array(low) @ ground.normal - ground.under(np.array(low))
    assert abs(gap.min()) < 2e-3
    np.testing.assert_allclose(on_ground(HUMAN, ground, qpos), qpos, atol=2e-3)


def test_tiles_are_level_each_and_the_first_lies_lowest():
    ground = ground_named("tiles:5", seed=1)
    along = np.zeros((400, 3))
    along[:, 0] = np.linspace(-0.45, 14.0, 400)
    height = ground.under(along)
    assert 0.0 <= height.min() and 0.03 < height.max() <= 0.05
    assert (height[along[:, 0] < 0.45] == 0.0).all()
    level = np.isclose(np.diff(height), 0.0)
    assert 0.75 < level.mean() < 0.99  # the edges are 2.5 cm of 40
    assert not np.allclose(height, ground_named("tiles:5", seed=2).under(along))

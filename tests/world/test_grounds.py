"""Grounds by name: what they are, and that a person stands on them."""

import numpy as np
import pytest

from plantigrade.contact.ground import Ground
from plantigrade.contact.site import GEOM, contact_sites
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.world import World, on_ground, standing_on
from plantigrade.world.grounds import ground_named

HUMAN = Human.create(joints="42", feet="rigid")


def height(ground: Ground, x: float, y: float = 0.0) -> float:
    return float(ground.under(np.array([x, y, 0.0])))


def test_every_ground_is_what_its_name_says():
    assert ground_named("flat") == Ground()
    assert ground_named("slope:5").slope == pytest.approx(np.deg2rad(5.0))
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


@pytest.mark.parametrize("word", ["flat", "slope:8", "sphere:1", "dome:1", "stones"])
def test_a_person_starts_on_the_ground_over_the_feet(word):
    ground = ground_named(word)
    qpos = standing_on(HUMAN, ground)
    world = World(HUMAN, ground, rate=300.0, qpos=qpos, recording=False)
    state = world.reset()
    sites = contact_sites(HUMAN)
    x = [world.data.geom(GEOM + s.name).xpos[0] for s in sites]
    assert min(x) + 0.05 < state.body.com[0] < max(x) - 0.05
    low = [
        world.data.geom(GEOM + s.name).xpos
        - s.radius * ground.normal_at(world.data.geom(GEOM + s.name).xpos)
        for s in sites
    ]
    gap = np.array(low) @ ground.normal - ground.under(np.array(low))
    assert abs(gap.min()) < 2e-3
    np.testing.assert_allclose(on_ground(HUMAN, ground, qpos), qpos, atol=2e-3)

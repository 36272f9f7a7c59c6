"""Feet and the ground: planted feet neither slide nor sink, and a path follows from them."""

import numpy as np
import pytest

from plantigrade.kinematics.coordinate_fit import forward_path
from plantigrade.kinematics.ground_level import level
from plantigrade.kinematics.planting import plant_feet
from plantigrade.kinematics.sole_paths import lowest, sole_paths
from plantigrade.kinematics.sole_rests import ContactFrames, drift_of, find_rests
from plantigrade.models import Human

RATE = 100.0


@pytest.fixture(scope="module", params=["42", "66"])
def human(request) -> Human:
    """Return a person with feet of two segments, and one with feet of sixteen bones."""
    return Human.create(1.75, 70, joints=request.param)


@pytest.fixture(scope="module")
def standing(human) -> np.ndarray:
    """Return a second of quiet standing."""
    return np.tile(human.standing(), (100, 1))


def test_standing_feet_touch_the_ground_and_rest(human, standing):
    assert np.abs(lowest(human, standing)).max() < 1e-9
    rests = find_rests(sole_paths(human, standing), RATE)
    assert {(r.side, r.region) for r in rests} == {
        (s, r) for s in ("r", "l") for r in ("heel", "ball", "toes")
    }
    assert all((r.start, r.stop) == (0, 100) for r in rests)


@pytest.mark.parametrize("offset", [-0.3, 0.08])
def test_levelling_undoes_a_shift(human, standing, offset):
    shifted = standing.copy()
    shifted[:, 2] += offset
    levelled, rise = level(human, shifted, RATE)
    np.testing.assert_allclose(levelled, standing, atol=1e-9)
    np.testing.assert_allclose(rise, -offset, atol=1e-9)


def test_a_raised_foot_does_not_move_the_ground(human, standing):
    q = standing.copy()
    q[:, 7 + human.hinge("knee_angle_r")] = 1.2
    q[:, 2] += 0.05
    levelled, _ = level(human, q, RATE)
    left = sole_paths(human, levelled)
    assert abs(left.position[:, left.of("l"), 2].min()) < 1e-6


def test_planting_leaves_a_good_motion_alone(human, standing):
    q = plant_feet(human, standing, rate=RATE)
    assert np.abs(q - standing).max() < 1e-3


def test_planted_feet_neither_slide_nor_sink(human, standing):
    """A body that glides by 4 cm and sinks by 1 cm is held by its feet."""
    q = standing.copy()
    s = np.linspace(0, 1, len(q))
    q[:, 0] += 0.04 * s
    q[:, 2] -= 0.01 * s
    contact = sole_paths(human, q)
    rests = find_rests(contact, RATE)
    assert drift_of(contact, rests).max() > 0.015
    planted = plant_feet(human, q, rate=RATE)
    after = sole_paths(human, planted)
    assert drift_of(after, rests).max() < 0.003
    assert after.penetration.max() < 0.003
    low, high = human.limits
    assert (planted[:, 7:] >= low - 1e-9).all() and (planted[:, 7:] <= high + 1e-9).all()
    arms = [7 + i for i, c in enumerate(human.coordinates) if c.startswith(("arm", "elbow"))]
    np.testing.assert_allclose(planted[:, arms], q[:, arms], atol=1e-3)


def test_feet_on_a_belt_move_with_it(human, standing):
    belt = np.zeros((100, 3))
    belt[:, 0] = -1.2 * np.arange(100) / RATE
    q = standing.copy()
    q[:, :3] += belt
    rests = find_rests(sole_paths(human, q), RATE, way=belt)
    assert len(rests) == 6
    assert not find_rests(sole_paths(human, q), RATE)
    assert drift_of(sole_paths(human, q), rests, belt).max() < 1e-9


def test_path_is_that_of_a_body_swinging_over_its_foot(human):
    """Legs that swing by theta about a standing right foot carry the pelvis forward by it."""
    n = 60
    q = np.tile(human.standing(), (n, 1))
    angle = np.linspace(0.2, -0.2, n)
    q[:, 7 + human.hinge("hip_flexion_r")] = angle
    q[:, 7 + human.hinge("ankle_angle_r")] = -angle
    q[:, 7 + human.hinge("knee_angle_l")] = 1.0
    moved = forward_path(human, q, rate=RATE)
    d = human.dimensions
    expected = 2 * (d.thigh + d.shank) * np.sin(0.2)
    assert abs(moved[-1, 0] - moved[0, 0] - expected) < 0.04 * expected + 0.01
    contact = sole_paths(human, moved)
    rest = [ContactFrames("r", region, 0, n) for region in ("heel", "ball")]
    assert drift_of(contact, rest).max() < 0.02
    assert np.abs(contact.position[:, contact.of("r"), 2].min(axis=1)).max() < 1e-9


@pytest.mark.parametrize("direction", [1, -1], ids=["forward", "backward"])
def test_of_two_feet_as_low_the_one_that_falls_behind_stands(human, direction):
    """Straight legs that swing past one another: both soles pass the ground at one height."""
    n, swing = 200, 0.25
    phase = np.arange(n) / n * 2 * np.pi * 2  # four steps
    q = np.tile(human.standing(), (n, 1))
    for side, sign in (("r", 1), ("l", -1)):
        wave = sign * swing * np.cos(phase)
        q[:, 7 + human.hinge(f"hip_flexion_{side}")] = wave
        # the foot that swings in the direction of walking is a little higher
        bent = 0.15 * (np.gradient(wave) * direction > 0) * np.sin(phase) ** 2
        q[:, 7 + human.hinge(f"knee_angle_{side}")] = bent
        q[:, 7 + human.hinge(f"ankle_angle_{side}")] = bent - wave  # flat feet
    moved = forward_path(human, q, rate=RATE)
    d = human.dimensions
    step = 2 * (d.thigh + d.shank) * np.sin(swing)
    assert direction * (moved[-1, 0] - moved[0, 0]) == pytest.approx(4 * step, rel=0.1)

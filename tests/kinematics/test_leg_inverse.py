"""Legs that reach for their feet."""

import numpy as np
import pytest

from plantigrade.constants import SIDES
from plantigrade.kinematics.leg_inverse import LegInverse
from plantigrade.kinematics.state import BodyState, sweep
from plantigrade.models import Human


def feet(human, qpos):
    """Return places and turns of the feet in postures."""
    index = [human.body(f"foot_{side}") for side in SIDES]
    found = [(s.origins[index], s.rotations[index]) for s in sweep(human, qpos)]
    return np.array([p for p, _ in found]), np.array([t for _, t in found])


def postures(human, n, seed=0):
    """Return postures with legs anywhere in the middle of their ranges, on a pelvis anywhere."""
    rng = np.random.default_rng(seed)
    qpos = np.tile(human.standing(), (n, 1))
    low, high = human.limits
    qpos[:, 7:] = low + (0.2 + 0.6 * rng.random((n, len(low)))) * (high - low)
    for side in SIDES:
        knee = 7 + human.hinge(f"knee_angle_{side}")
        qpos[:, knee] = np.deg2rad(rng.uniform(3.0, 100.0, n))
    quat = rng.normal(size=(n, 4)) + [3.0, 0.0, 0.0, 0.0]
    qpos[:, 3:7] = quat / np.linalg.norm(quat, axis=1, keepdims=True)
    qpos[:, :3] += rng.normal(size=(n, 3))
    return qpos


@pytest.fixture(scope="module", params=[("42", "two-segment"), ("66", "multi-segment")])
def human(request):
    """One whose ankle has two hinges, and one whose ankle and knee have three."""
    joints, kind = request.param
    return Human.create(1.72, 68.0, joints=joints, feet=kind)


def test_the_recorded_place_of_a_foot_gives_the_recorded_angles(human):
    qpos = postures(human, 40)
    reached = LegInverse(human).reach(qpos, *feet(human, qpos))
    np.testing.assert_allclose(reached, qpos, atol=1e-9)


def test_a_foot_led_elsewhere_is_there_exactly(human):
    qpos = postures(human, 40, seed=1)
    there, turns = feet(human, qpos)
    there += np.random.default_rng(2).normal(0.0, 0.04, there.shape)
    reached = LegInverse(human).reach(qpos, there, turns)
    found, turned = feet(human, reached)
    off = np.linalg.norm(found - there, axis=2)
    assert (off < 1e-9).mean() > 0.8
    lag = np.arccos(np.clip((np.einsum("nkij,nkij->nk", turned, turns) - 1.0) / 2.0, -1.0, 1.0))
    if "ankle_rotation_r" in human.coordinates:  # any turn can be had
        assert (lag < 1e-6).mean() > 0.9
    else:  # the vertical of the foot can, not its heading
        near = np.einsum("nki,nki->nk", turned[..., 2], turns[..., 2]) > 1.0 - 1e-12
        assert near.mean() > 0.9
    others = [
        n for n in human.coordinates if not n.startswith(("hip", "knee_angle", "ankle", "sub"))
    ]
    kept = [7 + human.hinge(n) for n in others]
    np.testing.assert_array_equal(reached[:, kept], qpos[:, kept])


def test_a_foot_out_of_reach_is_pointed_to(human):
    qpos = human.standing()[None]
    here, turns = feet(human, qpos)
    state = BodyState(human, qpos[0])
    hips = np.array([state.origin(f"femur_{side}") for side in SIDES])
    ahead = np.array([0.6, 0.0, -0.8])
    asked = (hips + 1.4 * ahead)[None]
    reached = LegInverse(human).reach(qpos, asked, turns)
    found, _ = feet(human, reached)
    line = found[0] - hips
    np.testing.assert_allclose(line / np.linalg.norm(line, axis=1)[:, None], [ahead] * 2, atol=1e-9)
    assert np.linalg.norm(found - asked, axis=2).min() > 0.3 and np.isfinite(reached).all()

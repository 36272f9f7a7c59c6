"""Inertia of solids: closed forms against sums over many point masses."""

import numpy as np
import pytest

from plantigrade.models.parts import Inertia, block, combine, rod


def cloud(points, mass):
    """Inertia of equal point masses."""
    com = points.mean(axis=0)
    r = points - com
    each = mass / len(points)
    tensor = each * (np.einsum("ij,ij->", r, r) * np.eye(3) - r.T @ r)
    return Inertia(mass, com, tensor)


def test_a_block_is_a_cloud_of_points():
    rng = np.random.default_rng(0)
    half = np.array([0.1, 0.2, 0.3])
    points = rng.uniform(-half, half, size=(400_000, 3)) + [1, 2, 3]
    ours, theirs = block(5.0, np.array([1.0, 2.0, 3.0]), half), cloud(points, 5.0)
    np.testing.assert_allclose(ours.com, theirs.com, atol=1e-3)
    np.testing.assert_allclose(ours.tensor, theirs.tensor, atol=3e-3 * ours.tensor.max())


def test_a_rod_is_nearly_a_capsule_of_the_same_volume():
    rng = np.random.default_rng(1)
    a, b, radius = np.array([0.0, 0.1, 0.0]), np.array([0.3, 0.2, -0.4]), 0.05
    box = rng.uniform(np.minimum(a, b) - radius, np.maximum(a, b) + radius, size=(800_000, 3))
    along = np.clip((box - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    inside = box[np.linalg.norm(box - a - along[:, None] * (b - a), axis=1) < radius]
    ours, theirs = rod(2.0, a, b, radius), cloud(inside, 2.0)
    np.testing.assert_allclose(ours.com, theirs.com, atol=2e-3)
    np.testing.assert_allclose(ours.tensor, theirs.tensor, atol=0.02 * ours.tensor.max())


def test_halves_of_a_block_make_the_block():
    half = np.array([0.1, 0.1, 0.2])
    whole = block(4.0, np.zeros(3), half)
    pieces = [block(2.0, np.array([0, 0, z]), half * [1, 1, 0.5]) for z in (-0.1, 0.1)]
    both = combine(pieces)
    assert both.mass == pytest.approx(4.0)
    np.testing.assert_allclose(both.com, whole.com, atol=1e-15)
    np.testing.assert_allclose(both.tensor, whole.tensor, atol=1e-15)


def test_an_empty_combination_has_zero_mass():
    assert combine([]).mass == 0.0

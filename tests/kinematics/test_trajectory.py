"""Trajectories: exact where a polynomial is sampled, smooth everywhere, still beyond their ends."""

import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.kinematics.trajectory import Trajectory


@pytest.mark.parametrize(("samples", "degree"), [(2, 1), (3, 1), (4, 3), (5, 3), (6, 5), (40, 5)])
def test_a_polynomial_of_its_degree_is_exact(samples, degree):
    rng = np.random.default_rng(samples)
    curves = [np.polynomial.Polynomial(rng.normal(size=degree + 1)) for _ in range(2)]
    time = np.sort(rng.uniform(0, 2, samples)) if samples > 3 else np.linspace(0, 2, samples)
    trajectory = Trajectory(time, np.stack([c(time) for c in curves], axis=1))
    for t in np.linspace(time[0], time[-1], 57):
        expected = [[c(t), c.deriv()(t), c.deriv(2)(t)] for c in curves]
        np.testing.assert_allclose(trajectory(t), np.transpose(expected), atol=1e-6)


def test_rates_are_the_rates_of_the_values():
    time = np.linspace(0, 1, 30)
    trajectory = Trajectory(time, np.stack([np.sin(7 * time), np.exp(time)], axis=1))
    h = 1e-5
    for t in np.random.default_rng(0).uniform(0.01, 0.99, 40):
        before, here, after = (trajectory(float(t + d)) for d in (-h, 0, h))
        np.testing.assert_allclose(here[1], (after[0] - before[0]) / (2 * h), atol=1e-7)
        np.testing.assert_allclose(here[2], (after[1] - before[1]) / (2 * h), atol=1e-5)


def test_a_sampled_curve_is_followed_between_its_samples():
    time = np.linspace(0, 2, 101)
    trajectory = Trajectory(time, np.sin(2 * np.pi * time)[:, None])
    for t in (0.213, 0.5, 1.777):
        w = 2 * np.pi
        expected = [np.sin(w * t), w * np.cos(w * t), -(w**2) * np.sin(w * t)]
        np.testing.assert_allclose(trajectory(t)[:, 0], expected, rtol=1e-4, atol=1e-4)


def test_beyond_its_ends_it_rests_where_it_ended():
    trajectory = Trajectory(np.linspace(1, 2, 10), np.linspace(5, 7, 10)[:, None])
    np.testing.assert_allclose(trajectory(-3.0), [[5], [0], [0]], atol=1e-12)
    np.testing.assert_allclose(trajectory(9.0), [[7], [0], [0]], atol=1e-12)
    assert trajectory(1.0)[1, 0] == pytest.approx(2.0)
    assert trajectory(2.0)[0, 0] == pytest.approx(7.0)


def test_one_value_stays():
    trajectory = Trajectory.fixed(np.array([1.0, 2.0, 3.0]))
    for t in (-1.0, 0.0, 5.0):
        np.testing.assert_array_equal(trajectory(t), [[1, 2, 3], [0, 0, 0], [0, 0, 0]])


@pytest.mark.parametrize(
    ("time", "values", "message"),
    [
        ([], np.zeros((0, 1)), "0 times for 0 samples"),
        ([0.0, 0.0], [[1.0], [2.0]], "increasing times"),
        ([0.0, 1.0], [[1.0], [np.nan]], "finite samples"),
    ],
)
def test_bad_samples_are_refused(time, values, message):
    with pytest.raises(ParameterError, match=message):
        Trajectory(np.array(time), np.array(values))

"""Piecewise cubics, against SciPy's."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline, PchipInterpolator

from plantigrade.motion.cubic import hermite, monotone, smooth_slopes

TIMES = np.linspace(-0.2, 4.3, 301)


def samples(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return uneven knots and samples with a plateau, a turn and a straight line."""
    rng = np.random.default_rng(n)
    knots = np.cumsum(rng.uniform(0.2, 1.0, n)) - 0.2
    values = rng.normal(size=(n, 5))
    values[n // 2 :, 1] = values[n // 2, 1]
    values[:, 2] = 3.0 * knots
    return knots, values


@pytest.mark.parametrize("n", (2, 3, 4, 9))
def test_monotone_cubic_is_that_of_scipy(n):
    knots, values = samples(n)
    reference = PchipInterpolator(knots, values)(TIMES)
    assert monotone(knots, values, TIMES) == pytest.approx(reference, abs=1e-9)
    assert monotone(knots, values[:, 0], TIMES) == pytest.approx(reference[:, 0], abs=1e-9)


@pytest.mark.parametrize(
    ("n", "clamped"), [(2, True), (3, True), (4, True), (4, False), (9, False)]
)
def test_smooth_cubic_is_that_of_scipy(n, clamped):
    knots, values = samples(n)
    reference = CubicSpline(knots, values, bc_type="clamped" if clamped else "not-a-knot")
    slopes = smooth_slopes(knots, values, clamped=clamped)
    assert slopes == pytest.approx(reference(knots, 1), abs=1e-9)
    assert hermite(knots, values, slopes, TIMES) == pytest.approx(reference(TIMES), abs=1e-8)

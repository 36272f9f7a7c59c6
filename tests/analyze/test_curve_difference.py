"""Differences of curves: bands hold what they promise, and nothing where nothing can be said."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d

from plantigrade.analyze.curve_difference import curve_difference


def smooth(rng, n: int, scale: float = 1.0) -> np.ndarray:
    """Smooth random curves of equal spread, as strides about their mean."""
    noise = gaussian_filter1d(rng.normal(size=(n, 301)), 8.0, axis=1)[:, 100:201]
    return scale * noise / 0.19


@pytest.mark.parametrize(("n", "m", "scale"), [(3, 3, 1.0), (8, 8, 1.0), (4, 12, 3.0)])
def test_the_band_holds_the_whole_true_difference(n, m, scale):
    """In 95 of 100 pairs of sets from one population zero is never left out, at any instant."""
    rng = np.random.default_rng(0)
    held = [
        not curve_difference(smooth(rng, n), smooth(rng, m, scale)).beyond.any() for _ in range(200)
    ]
    assert 0.91 <= np.mean(held) <= 1.0


def test_a_bump_is_found_where_it_is():
    rng = np.random.default_rng(1)
    bump = np.where(abs(np.arange(101) - 70) < 8, 10.0, 0.0)
    found = curve_difference(smooth(rng, 8), smooth(rng, 8) + bump)
    assert found.beyond[65:76].all() and not found.beyond[:55].any()
    assert found.largest == pytest.approx(10.0, abs=2.0)


def test_the_sign_is_second_minus_first():
    low, high = np.zeros((4, 101)), np.ones((4, 101))
    assert curve_difference(low, high).largest == 1.0
    assert curve_difference(high, low).rms == 1.0


def test_few_cycles_have_no_band():
    rng = np.random.default_rng(2)
    found = curve_difference(smooth(rng, 2), smooth(rng, 9))
    assert found.half is None and not found.beyond.any()


def test_strides_that_were_made_do_not_scatter():
    """A single exact stride is held against the scatter of the others; of none there is no band."""
    rng = np.random.default_rng(3)
    measured, made = smooth(rng, 9), np.full((1, 101), 9.0)
    found = curve_difference(measured, made, exact=(False, True))
    assert found.half is not None and found.beyond.all()
    assert curve_difference(made, made, exact=(True, True)).half is None


def test_gaps_are_left_out():
    rng = np.random.default_rng(4)
    holed = smooth(rng, 5)
    holed[0, 10] = np.nan
    found = curve_difference(holed, smooth(rng, 5))
    assert np.isfinite(found.mean).all() and found.half is not None

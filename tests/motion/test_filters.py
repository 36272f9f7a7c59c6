import numpy as np
import pytest

from plantigrade.errors import ParameterError
from plantigrade.motion.filters import derivative, fill_gaps, lowpass, resample

TIME = np.arange(1000) / 100


def test_lowpass_has_half_power_at_the_cutoff_and_no_lag():
    wave = np.sin(2 * np.pi * 6.0 * TIME)
    middle = slice(200, 800)
    smooth = lowpass(TIME, wave, cutoff=6.0)
    # A least-squares fit of sine and cosine gives gain and phase.
    basis = np.stack([wave, np.cos(2 * np.pi * 6.0 * TIME)], axis=1)[middle]
    gain, lag = np.linalg.lstsq(basis, smooth[middle], rcond=None)[0]
    assert gain == pytest.approx(np.sqrt(0.5), rel=0.01)
    assert abs(lag) < 1e-3


def test_lowpass_keeps_lines_and_gaps():
    line = np.stack([3 * TIME + 1, -TIME], axis=1)
    line[300:320, 0] = np.nan
    smooth = lowpass(TIME, line, cutoff=6.0)
    np.testing.assert_array_equal(np.isnan(smooth), np.isnan(line))
    np.testing.assert_allclose(smooth, line, atol=1e-4)


def test_derivatives_of_a_sine():
    wave = np.sin(2 * np.pi * TIME)
    inner = slice(20, -20)
    first, second = derivative(TIME, wave), derivative(TIME, wave, order=2)
    np.testing.assert_allclose(first[inner], 2 * np.pi * np.cos(2 * np.pi * TIME)[inner], atol=1e-3)
    np.testing.assert_allclose(second[inner], -((2 * np.pi) ** 2) * wave[inner], atol=0.05)


def test_only_short_gaps_are_filled():
    wave = np.sin(2 * np.pi * TIME)
    holes = wave.copy()
    holes[100:105] = holes[300:360] = holes[:3] = np.nan
    filled = fill_gaps(TIME, holes, longest=0.1)
    np.testing.assert_allclose(filled[90:110], wave[90:110], atol=0.01)
    assert np.isnan(filled[300:360]).all() and np.isnan(filled[:3]).all()


def test_resample():
    wave = np.sin(2 * np.pi * TIME)
    new = np.linspace(-0.1, 5.0, 333)
    result = resample(TIME, wave, new)
    inside = new >= 0
    np.testing.assert_allclose(result[inside], np.sin(2 * np.pi * new[inside]), atol=1e-4)
    assert np.isnan(result[~inside]).all()


def test_bad_input():
    with pytest.raises(ParameterError, match="cutoff"):
        lowpass(TIME, TIME, cutoff=60.0)
    with pytest.raises(ParameterError, match="increase"):
        resample(TIME[::-1], TIME, TIME)

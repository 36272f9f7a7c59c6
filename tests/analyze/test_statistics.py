import numpy as np
import pytest

from plantigrade.analyze import compare_curves
from plantigrade.errors import ParameterError

PHASE = np.linspace(0, 2 * np.pi, 1000, endpoint=False)


def test_known_curves():
    a, b = np.sin(PHASE), np.sin(PHASE) + 0.5
    found = compare_curves(b, a)
    assert found.rmse == pytest.approx(0.5)
    assert found.mean_difference == pytest.approx(0.5)
    assert found.rmse_offset_removed == pytest.approx(0.0, abs=1e-12)
    assert found.correlation == pytest.approx(1.0)
    assert compare_curves(a, np.cos(PHASE)).correlation == pytest.approx(0.0, abs=1e-12)
    assert np.isnan(compare_curves(a, np.ones_like(a)).correlation)


def test_unknown_points_are_omitted():
    found = compare_curves(np.array([1.0, np.nan]), np.array([3.0, 9.0]))
    assert found.rmse == pytest.approx(2.0) and np.isnan(found.correlation)
    assert np.isnan(compare_curves(np.array([np.nan]), np.array([1.0])).rmse)
    with pytest.raises(ParameterError, match="compared"):
        compare_curves(np.zeros(3), np.zeros(4))

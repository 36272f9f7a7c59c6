import numpy as np
import pytest

from plantigrade.analyze import statistics as st
from plantigrade.errors import ParameterError

PHASE = np.linspace(0, 2 * np.pi, 1000, endpoint=False)


def test_known_curves():
    a, b = np.sin(PHASE), np.sin(PHASE) + 0.5
    assert st.rmse(a, b) == pytest.approx(0.5)
    assert st.mean_difference(b, a) == pytest.approx(0.5)
    assert st.rmse_offset_removed(a, b) == pytest.approx(0.0, abs=1e-12)
    assert st.correlation(a, b) == pytest.approx(1.0)
    assert st.correlation(a, np.cos(PHASE)) == pytest.approx(0.0, abs=1e-12)
    assert np.isnan(st.correlation(a, np.ones_like(a)))


def test_unknown_points_are_left_out():
    assert st.rmse(np.array([1.0, np.nan]), np.array([3.0, 9.0])) == pytest.approx(2.0)
    assert np.isnan(st.rmse(np.array([np.nan]), np.array([1.0])))
    with pytest.raises(ParameterError, match="compared"):
        st.rmse(np.zeros(3), np.zeros(4))

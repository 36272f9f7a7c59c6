"""The Gait Profile Score of gaits whose distance from the mean is known."""

import numpy as np
import pytest

from plantigrade.analyze.gait_profile import LEG, PELVIS, gait_profile
from plantigrade.analyze.norms import ADULTS, CHILDREN, norm
from plantigrade.errors import ParameterError

PERCENT = np.linspace(0, 100, 101)


def mean_gait() -> dict[str, np.ndarray]:
    """One cycle of every angle, exactly the mean of adults."""
    found = {}
    for name in (*PELVIS, *(f"{n}_{side}" for side in "rl" for n in LEG)):
        band = norm(name, population=ADULTS)
        found[name] = np.interp(PERCENT, band.percent, band.mean)[None]
    return found


def test_the_mean_gait_scores_zero():
    found = gait_profile(PERCENT, mean_gait())
    assert found.score() == pytest.approx(0, abs=1e-9)
    assert 3 < found.usual_score < 7  # adults differ by some degrees in every angle
    assert found.usual["pelvis_tilt"] == pytest.approx(5.6, abs=0.2)


def test_a_constant_difference_is_counted_as_the_paper_counts_it():
    """A knee that is 12° off weighs as one of nine angles of its side, one of fifteen of both."""
    gait = mean_gait()
    gait["knee_angle_l"] = np.concatenate([gait["knee_angle_l"] + 10, gait["knee_angle_l"] + 14])
    found = gait_profile(PERCENT, gait)
    assert found.difference["knee_angle_l"] == pytest.approx(12)
    assert found.score("l") == pytest.approx(12 / 3)
    assert found.score("r") == pytest.approx(0, abs=1e-9)
    assert found.score() == pytest.approx(12 / np.sqrt(15))


def test_what_is_missing_is_named():
    gait = mean_gait()
    gait["hip_rotation_r"] = np.empty((0, 101))
    with pytest.raises(ParameterError, match="hip_rotation_r"):
        gait_profile(PERCENT, gait)
    with pytest.raises(ParameterError, match="foot_progression"):
        gait_profile(PERCENT, mean_gait(), CHILDREN)

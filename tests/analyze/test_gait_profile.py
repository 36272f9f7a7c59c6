"""The Gait Profile Score of gaits whose distance from the mean is known, against any norms."""

import numpy as np
import pytest

from plantigrade.analyze import norm
from plantigrade.analyze.gait_profile import ANGLES, gait_profile
from plantigrade.analyze.norms import ADULTS, CHILDREN
from plantigrade.errors import ParameterError

PERCENT = np.linspace(0, 100, 101)


def mean_gait(population=ADULTS) -> dict[str, np.ndarray]:
    """One cycle of every angle, exactly the mean of a population."""
    found = {}
    for name in (f"{n}_{side}" for side in "rl" for n in ANGLES):
        band = norm(name, population=population)
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
    gait = mean_gait()
    gait["pelvis_tilt_l"] = np.full((2, 101), np.nan)
    with pytest.raises(ParameterError, match="pelvis_tilt_l"):
        gait_profile(PERCENT, gait)


def test_children_have_all_nine_angles_and_are_another_norm():
    found = gait_profile(PERCENT, mean_gait(CHILDREN), CHILDREN)
    assert found.score() == pytest.approx(0, abs=1e-9)
    assert 4 < found.usual_score < 7  # typically developing children: 5 to 6 degrees
    assert gait_profile(PERCENT, mean_gait(CHILDREN), ADULTS).score() > 2
    feet = norm("foot_progression", population=CHILDREN).mean
    assert -20 < feet.min() and feet.max() < 0  # feet point outward


def test_a_pelvis_counts_once_in_the_score_of_both_sides():
    """The right foot's is taken, as one of fifteen angles; a side's score has its own."""
    gait = mean_gait()
    gait["pelvis_tilt_r"] = gait["pelvis_tilt_r"] + 15
    gait["pelvis_tilt_l"] = gait["pelvis_tilt_l"] + 9
    found = gait_profile(PERCENT, gait)
    assert found.score("r") == pytest.approx(15 / 3)
    assert found.score("l") == pytest.approx(9 / 3)
    assert found.score() == pytest.approx(15 / np.sqrt(15))
    assert found.metrics()["gvs_pelvis_tilt_l_deg"] == pytest.approx(9)

"""Symmetry of gaits whose asymmetry is known."""

import numpy as np
import pytest

from plantigrade.analyze.symmetry import symmetry_figures

TURN = np.linspace(0, 2 * np.pi, 101)


def test_a_leg_that_moves_less_is_seen_in_the_range_and_not_in_the_shape():
    knee = 30 - 30 * np.cos(TURN)
    angles = {"knee_angle_r": knee[None], "knee_angle_l": 0.8 * knee[None] + 5}
    known = {"step_length_r_m": 0.66, "step_length_l_m": 0.60, "stance_r_pct": 62.0}
    found = symmetry_figures(known, angles)
    assert found["symmetry_index_knee_angle_range_pct"] == pytest.approx(200 * 0.2 / 1.8)
    assert found["trend_symmetry_knee_angle_pct"] == pytest.approx(0.0, abs=1e-9)
    assert found["symmetry_index_step_length_pct"] == pytest.approx(200 * 0.06 / 1.26)
    assert not any("stance" in key or "hip" in key for key in found), "what is unknown is left out"


def test_a_late_leg_is_seen_in_the_shape():
    angles = {"knee_angle_r": np.sin(TURN)[None], "knee_angle_l": np.sin(TURN - 0.5)[None]}
    found = symmetry_figures({}, angles)
    assert found["trend_symmetry_knee_angle_pct"] > 5
    assert abs(found["symmetry_index_knee_angle_range_pct"]) < 1

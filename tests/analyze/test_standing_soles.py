"""Warnings of soles that do not rest on the ground, and none for one or two frames."""

import numpy as np
import pytest

from plantigrade.analyze.standing_soles import sole_notes
from plantigrade.kinematics.fitted_soles import height_figures


@pytest.mark.parametrize(
    ("mean", "frames_away", "said"),
    [(0.002, 0, False), (-0.017, 0, True), (0.002, 2, False), (0.002, 12, True)],
)
def test_soles_away_from_the_ground_are_noted(mean, frames_away, said):
    soles = np.full((100, 2), np.nan)
    soles[:60] = mean
    soles[:frames_away, 0] = 0.045
    notes = sole_notes(soles)
    assert len(notes) == said
    if said:
        worst = height_figures(soles)["sole_in_stance_worst_mm"]
        assert f"{worst:+.0f} mm at most" in notes[0]


def test_nobody_who_stands_is_said_nothing_about():
    assert sole_notes(np.full((10, 2), np.nan)) == []
    assert height_figures(np.full((10, 2), np.nan)) == {}

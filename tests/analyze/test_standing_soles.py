"""Warnings of soles that do not rest on the ground, and none for one or two frames."""

from pathlib import Path

import numpy as np
import pytest

from plantigrade.analyze.standing_soles import sole_notes, standing_soles
from plantigrade.kinematics.fitted_soles import height_figures
from plantigrade.kinematics.result import Fit
from plantigrade.models import Human
from plantigrade.motion import GaitEvent, Recording


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


EVENTS = (GaitEvent(0.1, "l", "heel_strike"), GaitEvent(1.9, "l", "toe_off"))


@pytest.fixture
def stance():
    """A person, times, and a motion that stands at all of them."""
    human, time = Human.create(1.74, 71.0), np.arange(0.0, 2.0, 0.01)
    return human, time, np.tile(human.standing(), (len(time), 1))


def test_a_kick_between_two_steps_is_no_stance(stance):
    human, time, qpos = stance
    up = (time > 0.8) & (time < 1.2)
    qpos[up, 7 + human.hinge("knee_angle_l")] = np.deg2rad(80.0)
    fit = Fit(human, time, qpos, Recording(Path("kick.c3d")), "markers")
    left = standing_soles(fit, EVENTS, None)[:, 1]
    assert np.isnan(left[up]).all()
    assert np.isfinite(left[(time > 0.15) & (time < 0.75)]).all()
    assert np.isfinite(left[(time > 1.25) & (time < 1.85)]).all()


@pytest.mark.parametrize("speed", [-0.06, 0.06])
def test_a_foot_that_a_sloping_belt_lifts_or_lowers_stands(stance, speed):
    human, time, qpos = stance
    qpos[:, 2] += speed * time
    fit = Fit(human, time, qpos, Recording(Path("belt.c3d")), "markers")
    left = standing_soles(fit, EVENTS, None)[:, 1]
    stands = (time > 0.105) & (time < 1.895)
    assert np.isfinite(left[stands]).all() and np.ptp(left[stands]) > 0.1

"""The experiment on the foot pose: the ankle's path tells what a foot model measured."""

from pathlib import Path

import numpy as np
import pytest

from experiments.foot_pose import (
    MEAN_CURVE_FILES,
    PRESSURE_ANGLES,
    PUBLISHED,
    QUICK_TRIALS,
    angle_rows,
)
from plantigrade.analyze.foot_angles import FOOT_ANGLES
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import FitSettings


def test_what_a_pressing_pattern_can_tell_are_the_sagittal_angles():
    sagittal = {f"{pair}_{FOOT_ANGLES[pair][0]}" for pair in MEAN_CURVE_FILES}
    assert sagittal == set(PRESSURE_ANGLES)


@pytest.mark.slow
def test_hindfoot_and_forefoot_follow_from_the_ankle(data: Path):
    # One fit for both: of it the controller sees no more than of one on rigid feet.
    recording, boxed = fit_trial(data / QUICK_TRIALS[0], FitSettings(feet="multi-segment"))
    rows = list(angle_rows(QUICK_TRIALS[0], recording, boxed, boxed, data / PUBLISHED))
    found = {row.quantity: row.value for row in rows}
    for side in "rl":
        hindfoot = f"hindfoot_dorsiflexion_{side}, controller"
        assert found[f"{hindfoot}, r"] > 0.85
        assert found[f"{hindfoot}, RMSE without offset"] < 4
        assert found[f"forefoot_dorsiflexion_{side}, controller, RMSE without offset"] < 3
        assert found[f"hallux_dorsiflexion_{side}, controller against published mean, r"] > 0.8
        assert found[f"forefoot_adduction_{side}, controller, r"] is None
        assert found[f"hallux_by_markers_{side}, span"] > 30
        assert found[f"hallux_by_markers_{side}, controller, r"] > 0.85
    known = [row for row in rows if row.met is not None]
    assert len(known) == 2 * (len(PRESSURE_ANGLES) + 1) and all(
        np.isfinite(row.value) for row in known
    )

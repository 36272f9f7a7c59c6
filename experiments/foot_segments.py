"""Angles between foot segments against those of the Oxford Foot Model stored in the files.

Each recording is fitted, called with its file name alone. Compared are the frames within the gait
cycles of a side. The constant between the two is removed; it is stated on its own.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.stored_angles import on_clock
from experiments.table import ResultTable, Row, at_least, at_most, over_trials
from plantigrade.analyze.foot_angles import FOOT_ANGLES
from plantigrade.analyze.foot_segments import angles_of, foot_segment_signals
from plantigrade.analyze.statistics import compare_curves
from plantigrade.analyze.trial import SIDES
from plantigrade.kinematics.result import Fit
from plantigrade.motion import Recording
from plantigrade.motion.cycles import cut_cycles
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import FitSettings

WALKS = ("c3d/HC038A11.c3d", "c3d/HC038A27.c3d", "c3d/HC032A03.c3d")
QUICK_TRIALS = WALKS[-1:]
# Pair of segments → the Oxford Foot Model's name for its three angles.
STORED = {"hindfoot": "HFTBA", "forefoot": "FFHFA", "forefoot_to_tibia": "FFTBA", "hallux": "HXFFA"}
# What the same examiner finds again in the same person, stance angles taken as zero: largest
# standard error of measurement of hindfoot and forefoot in any plane [Wright2011]_ [deg].
REPEATABILITY = 2.45
MIN_CORRELATION = 0.8  # correlation over the gait cycle


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over the walking trials with Oxford Foot Model markers in a data folder."""
    note = (
        f"RMSE: offset removed, against {REPEATABILITY} deg, the largest standard error of the "
        "Oxford Foot Model itself between sessions, referenced to stance (Wright 2011)."
    )
    title = "Foot segments against the Oxford Foot Model"
    names = QUICK_TRIALS if quick else WALKS
    return over_trials(title, data, names, trial_rows, say=say, notes=[note])


def trial_rows(path: Path, name: str) -> list[Row]:
    """Return all rows of one trial."""
    recording, trial = fit_trial(path, FitSettings())
    fitted, feet = trial.fit, foot_segment_signals(recording, trial).figures
    rows = [
        at_most(name, "marker RMS, mean", fitted.metrics["marker_rms_mean_mm"], 10, "mm"),
        at_most(name, "marker RMS of the feet", feet["foot_segments_marker_rms_mm"], 5, "mm"),
    ]
    return [*rows, *angle_rows(name, fitted, recording, trial.motion.events)]


def angle_rows(name: str, fitted: Fit, recording: Recording, events) -> Iterator[Row]:
    """Hold every angle against the stored one over the gait cycles of its side."""
    assert recording.markers is not None
    clock = recording.markers.time
    ours = angles_of(fitted, recording.static)
    assert ours is not None
    for pair, key in STORED.items():
        for side in SIDES:
            stored = recording.outputs.get(side.upper() + key)
            if stored is None:
                continue
            walking = np.zeros(len(fitted.time), bool)
            for cycle in cut_cycles(events, side=side):
                walking |= (fitted.time >= cycle.start) & (fitted.time <= cycle.stop)
            for k, what in enumerate(FOOT_ANGLES[pair]):
                column = f"{pair}_{what}_{side}"
                mine = np.where(walking, np.rad2deg(ours[column]), np.nan)
                theirs = np.where(walking, on_clock(clock, stored[:, k], fitted.time), np.nan)
                span = np.nanmax(theirs) - np.nanmin(theirs)
                found = compare_curves(mine, theirs)
                note = f"spans {span:.0f} deg, offset {found.mean_difference:.0f}"
                rmse = found.rmse_offset_removed
                r = at_least(name, f"{column}, r", found.correlation, MIN_CORRELATION)
                yield replace(r, note=note)
                yield at_most(name, f"{column}, RMSE", rmse, REPEATABILITY, "deg")

"""Recorded walks tracked on true contact forces, beside what the force plates measured.

Each walk is fitted with its file name alone; its motion becomes a trajectory problem that withholds
the plates, and the ground reactions that come out are looked at afterwards.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from plantigrade.analyze.check import check
from plantigrade.errors import ReproduceError
from plantigrade.experiments.fit_accuracy import WALKS
from plantigrade.experiments.gait_forces import STANCES, force_rows
from plantigrade.experiments.table import ResultTable, Row, over_trials
from plantigrade.synthesize.tasks.tracking import Tracking
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import TrackSettings
from plantigrade.workflows.track import track_trial

QUICK = ("opensim/gait2392_subject01/subject01_walk1.trc",)
LONGEST = 5.0  # of a long recording, this much is tracked [s]
WEIGHTINGS: Mapping[str, Tracking] = {
    "default": Tracking(),
    "joints alone": replace(Tracking(), push=0.0, turning=0.0, acceleration=0.0),
    "ten times nearer": replace(Tracking(), weight=1000.0),
}
"""Weightings that are compared; all but the default on its first nodes, vertical forces alone."""

NOTES = (
    STANCES,
    "A foot that no plate saw loaded is left out.",
    "Measured forces are withheld, but where no file tells the body mass it is found from them.",
    "One set of weights serves all walks; it was settled with these walks in view.",
    f"Of recordings longer than {LONGEST:g} s the first {LONGEST:g} s are tracked.",
)


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over the walks on force plates in a data folder."""
    title = "Recorded walks tracked on contact forces"
    names = QUICK if quick else WALKS
    return over_trials(title, data, names, trial_rows, say=say, notes=NOTES)


def trial_rows(path: Path, name: str, weightings: Mapping[str, Tracking] = WEIGHTINGS) -> list[Row]:
    """Return all rows of one walk."""
    _, trial = fit_trial(path)
    if trial.forces is None:
        raise ReproduceError(f"{path} came without force plates; nothing to compare with")
    rows: list[Row] = []
    for words, tracking in weightings.items():
        walked = [e.time for e in trial.motion.events]
        stop = min(walked) + LONGEST if max(walked) - min(walked) > LONGEST else None
        settings = TrackSettings(stop=stop)
        tracked = track_trial(
            trial,
            settings if words == "default" else replace(settings, refinements=0),
            tracking=tracking,
        )
        c = tracked.against_plates()
        if words != "default":
            what = f"vertical force, RMSE, {words}"
            rows.append(Row(name, what, c.vertical_rmse, "BW"))
            continue
        angle, way = tracked.moved()
        solution, record = tracked.solution, tracked.record()
        verdict = check(record)
        duration = record.motion.duration
        faults = "" if verdict.ok else "; ".join(verdict.words()[:3])
        rows += [
            *force_rows(name, c),
            Row(name, "moved from the recording, RMS", float(np.rad2deg(angle)), "deg"),
            Row(name, "pelvis moved from the recording, RMS", 1e3 * way, "mm"),
            Row(name, "lifted onto its soles", 1e3 * tracked.lift, "mm"),
            Row(name, "passes the check", float(verdict.ok), note=faults),
            Row(name, "solved", float(solution.success), note=solution.status),
            Row(name, "iterations", float(solution.iterations)),
            Row(name, "time", tracked.seconds, "s", note=f"for {duration:.2f} s of motion"),
        ]
    return rows

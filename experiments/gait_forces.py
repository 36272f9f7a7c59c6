"""Ground reactions of gaits rebuilt by forces, beside those of the force plates.

Each walk is fitted with its file name alone and rebuilt from ordered tasks above the equations of
motion; the measured forces are only looked at afterwards.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.fit_accuracy import SETTLING_PEOPLE, WALKS
from experiments.table import ResultTable, Row, at_most, mean_rows, over_trials
from plantigrade.analyze.gait_forces import ForceComparison, compare_forces
from plantigrade.analyze.recorded_walk import RecordedWalk
from plantigrade.analyze.reproduction import ROTATIONS, compare
from plantigrade.analyze.reproduction_status import forces_status
from plantigrade.errors import ReproduceError
from plantigrade.ordered_tasks.reproduced_gait import rebuild
from plantigrade.workflows.fit import fit_trial

QUICK_TRIALS = ("c3d/HC032A03.c3d", "opensim/gait2392_subject01/subject01_walk1.trc")
MAX_VERTICAL_ERROR = 0.08
"""Goal of the vertical force's error [BW]."""
MAX_RESIDUAL = 1e-6
"""Goal of the residual of the equations of motion [1]."""
GOALS = {
    "forward force, r": (">=", 0.9),
    "centre of pressure, backward in a stance": ("<=", 20.0),
    "ankle_angle moment, r": (">=", 0.95),
    "knee_angle moment, r": (">=", 0.85),
    "hip_flexion moment, r": (">=", 0.9),
    "centre of mass, greatest error": ("<=", 15.0),
    "vertical force, RMSE": ("<=", MAX_VERTICAL_ERROR),
}
"""Quantity → what a gait rebuilt by forces is held against, in the unit of its row."""

STANCES = (
    "Each foot by itself, over the frames of stance (above a twentieth of body weight) in which "
    "its plate tells the force; the figures of a recording are means over its feet. Joint moments "
    "are held against inverse dynamics of the recorded motion and the measured forces."
)
NOTES = (
    STANCES,
    "A foot that no plate saw loaded is left out.",
    "No measured force enters a rebuilt gait: its forces follow those estimated from the recorded "
    "motion. Constants were settled on the people of the first mean alone.",
)


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over the walks on force plates in a data folder."""
    title = "Ground reactions of gaits rebuilt by forces"
    names = QUICK_TRIALS if quick else WALKS
    table = over_trials(title, data, names, trial_rows, say=say, notes=NOTES)
    settled = [row for row in table.rows if any(who in row.subject for who in SETTLING_PEOPLE)]
    rest = [row for row in table.rows if row not in settled]
    means = [*mean_rows("mean, settled", settled), *mean_rows("mean, other people", rest)]
    means = [judged(row) for row in means]
    return replace(table, rows=[*table.rows, *means])


def judged(row: Row) -> Row:
    """Return a row held against its goal, where there is one."""
    if row.quantity not in GOALS or row.value is None:
        return row
    kind, limit = GOALS[row.quantity]
    met = row.value >= limit if kind == ">=" else row.value <= limit
    return replace(row, goal=f"{kind} {limit:g}", met=bool(met))


def trial_rows(path: Path, name: str) -> list[Row]:
    """Return all rows of one walk."""
    trial = fit_trial(path)[1]
    if trial.forces is None:
        raise ReproduceError(f"{path} has no force plates to compare with")
    walk = RecordedWalk.of(trial)
    made = rebuild(walk.reference(), forces=True)
    motion, forced = made.motion, made.record()
    c = compare_forces(forced, trial.record(), ground=walk.ground)
    held = compare(forced)
    worst = max(abs(held.rom_error[name]) for _, name in ROTATIONS if name in held.rom)
    feet = " and ".join(c.sides) or "no"
    tick = 1e3 * float(np.median(motion.solver_time) + np.median(motion.kinematics_time))
    return [
        *map(judged, force_rows(name, c)),
        at_most(name, "root residual", c.residual, MAX_RESIDUAL, "BW"),
        judged(Row(name, "centre of mass, greatest error", 1e3 * held.com_error_max_m, "mm")),
        Row(name, "range of motion, worst error", worst, "deg"),
        Row(name, "inside all limits", float(forces_status(forced, held) == "ok")),
        Row(name, "one tick, median", tick, "ms", note=f"feet on plates: {feet}"),
    ]


def force_rows(name: str, c: ForceComparison) -> list[Row]:
    """Return forces, centres of pressure and moments of one walk against the measured ones."""
    forward, sideways = (1e3 * c.pressure_median_m[axis] for axis in (0, 1))
    moments = []
    for joint, value in c.moment_rmse.items():
        moments.append(Row(name, f"{joint} moment, RMSE", value, "N m/kg"))
        moments.append(Row(name, f"{joint} moment, r", c.moment_r[joint]))
    return [
        at_most(name, "vertical force, RMSE", c.vertical_rmse, MAX_VERTICAL_ERROR, "BW"),
        Row(name, "vertical force, r", c.vertical_r),
        Row(name, "forward force, RMSE", c.forward_rmse, "BW"),
        Row(name, "forward force, r", c.forward_r),
        Row(name, "sideways force, RMSE", c.sideways_rmse, "BW"),
        Row(name, "sideways force, r", c.sideways_r),
        Row(name, "centre of pressure x, median error", forward, "mm"),
        Row(name, "centre of pressure y, median error", sideways, "mm"),
        Row(name, "centre of pressure, backward in a stance", 1e3 * c.backward_m, "mm"),
        *moments,
    ]

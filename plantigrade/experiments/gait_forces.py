"""Ground reactions of gaits rebuilt by forces, beside those of the force plates.

Each walk is fitted with its file name alone and rebuilt from ordered tasks above the equations of
motion; the measured forces are only looked at afterwards.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from plantigrade.analyze.gait_forces import ForceComparison, compare_forces
from plantigrade.analyze.reproduction import compare
from plantigrade.errors import ReproduceError
from plantigrade.experiments.fit_accuracy import WALKS
from plantigrade.experiments.table import ResultTable, Row, at_least, at_most, over_trials
from plantigrade.reproduce.result import rebuild
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.walks import RecordedWalk

QUICK = ("c3d/HC032A03.c3d", "opensim/gait2392_subject01/subject01_walk1.trc")
# Goals.
VERTICAL, CORRELATION, RESIDUAL = 0.08, 0.95, 1e-6

STANCES = (
    "Each foot by itself, over the frames of stance (above a twentieth of body weight) in which "
    "its plate tells the force; the figures of a recording are means over its feet. Joint moments "
    "are held against inverse dynamics of the recorded motion and the measured forces."
)
NOTES = (
    STANCES,
    "A foot that no plate saw loaded is left out.",
    "No measured force enters a rebuilt gait, but gains and the limit of loading were settled on "
    "these recordings: they are no test on unseen people.",
)


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over the walks on force plates in a data folder."""
    title = "Ground reactions of gaits rebuilt by forces"
    names = QUICK if quick else WALKS
    return over_trials(title, data, names, trial_rows, say=say, notes=NOTES)


def trial_rows(path: Path, name: str) -> list[Row]:
    """Return all rows of one walk."""
    trial = fit_trial(path)[1]
    if trial.forces is None:
        raise ReproduceError(f"{path} came without force plates; nothing to compare with")
    walk = RecordedWalk.of(trial)
    made = rebuild(walk.reference(), forces=True)
    motion, forced = made.motion, made.record()
    c = compare_forces(forced, trial.record(), ground=walk.ground)
    feet = " and ".join(c.sides) or "no"
    rows = force_rows(name, c)
    rows[1] = at_least(name, "vertical force, r", c.vertical_r, CORRELATION)
    tick = 1e3 * float(np.median(motion.solver_time) + np.median(motion.kinematics_time))
    return [
        *rows,
        at_most(name, "root residual", c.residual, RESIDUAL, "BW"),
        Row(name, "centre of mass, greatest error", 1e3 * compare(forced).com_error_max_m, "mm"),
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
        at_most(name, "vertical force, RMSE", c.vertical_rmse, VERTICAL, "BW"),
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

"""Estimated forces where load goes over abruptly, as in patients, on recordings that were changed.

In every double support whose both feet were measured, the share of the rear foot gets another
course. The net force stays; the net moment changes by that of the forces at their centres of
pressure. The motion therefore requires just these forces, and the program has to find them.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from experiments.table import Row
from plantigrade.analyze.gait_forces import STANCE_LOAD
from plantigrade.analyze.statistics import compare_curves
from plantigrade.analyze.trial import Trial
from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.dynamics.force_scales import ForceScales
from plantigrade.dynamics.force_windows import solve_in_windows
from plantigrade.dynamics.loading import find_loading
from plantigrade.dynamics.required_forces import required_forces

COURSES: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "as measured": ((), ()),
    "in the last 40 %": ((0.0, 0.6, 1.0), (1.0, 1.0, 0.0)),
    "in the first 40 %": ((0.0, 0.4, 1.0), (1.0, 0.0, 0.0)),
    "two thirds on one leg for a third": (
        (0.0, 0.33, 0.34, 0.67, 1.0),
        (1.0, 0.68, 0.66, 0.66, 0.0),
    ),
    "plateau of 30 %": ((0.0, 0.35, 0.65, 1.0), (1.0, 0.5, 0.5, 0.0)),
}
"""Name of a transfer → phases of the double support and shares of the rear foot there."""
FIGURES = {"vertical force, r": "", "vertical force, RMSE": "BW", "double support, RMSE": "BW"}


def transfer_rows(trials: Mapping[str, Trial]) -> list[Row]:
    """Return the vertical error of each course of the load, means over the recordings.

    Args:
        trials: Walks, their plates withheld.
    """
    rows = []
    for course in COURSES:
        found = [values for trial in trials.values() if (values := errors(trial, course))]
        for i, (figure, unit) in enumerate(FIGURES.items()):
            value = float(np.nanmean([values[i] for values in found])) if found else None
            rows.append(Row(course, figure, value, unit))
    return rows


def errors(trial: Trial, course: str) -> tuple[float, float, float] | None:
    """Return r, RMSE [BW], and RMSE in double support [BW] of the vertical force of both feet.

    None without a double support that plates measured.
    """
    assert trial.withheld is not None
    human, motion, (forces, _) = trial.fit.human, trial.motion, trial.withheld
    assert motion.qacc is not None
    loading = find_loading(human, motion)
    needs = required_forces(human, motion, motion.qacc, loading.contacts)
    weight, known = needs.weight, np.asarray(forces.valid_side)
    force = np.where(known[..., None], forces.force, 0.0) / weight
    both = np.asarray(known.all(axis=1) & (force[..., 2] > STANCE_LOAD).all(axis=1))
    if not both.any():
        return None
    prescribed = force.copy()
    phases, shares = COURSES[course]
    for front in loading.contacts if phases else ():
        for rear in loading.contacts:
            if rear.side == front.side or not rear.start < front.start < rear.stop < front.stop:
                continue
            phase = (motion.time - front.start) / (rear.stop - front.start)
            here = both & (phase >= 0) & (phase <= 1)
            share = np.interp(phase[here], phases, shares)[:, None]
            k, total = SIDES.index(rear.side), force[here].sum(axis=1)
            prescribed[here, k], prescribed[here, 1 - k] = share * total, (1 - share) * total
    arm = np.nan_to_num(forces.point) - needs.com[:, None]
    more = np.cross(arm, prescribed - force).sum(axis=1)
    needs = replace(needs, moment=needs.moment + more)
    scales = ForceScales.of(walks=True)
    found = solve_in_windows(human, needs, loading.contacts, (), None, scales)
    up, true = found.wrench[:, :2, 2], prescribed[..., 2]
    return _figures(up, true, known & (np.maximum(true, force[..., 2]) > STANCE_LOAD), both)


def _figures(up: Array, true: Array, stance: Array, both: Array) -> tuple[float, float, float]:
    feet = [compare_curves(up[stance[:, k], k], true[stance[:, k], k]) for k in (0, 1)]
    off = (up - true)[both]
    r, error = (
        float(np.mean([getattr(f, name) for f in feet])) for name in ("correlation", "rmse")
    )
    return r, error, float(np.sqrt(np.mean(off**2)))

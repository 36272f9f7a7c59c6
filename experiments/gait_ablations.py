"""What each part of the order of tasks is for: the default, the paper's, and both with parts gone.

[Boukheddimi]_ tried a cycle of two phases (it reports an abnormal gait with a straight knee of the
swinging leg) and the centre of mass split into two tasks (it reports worse results), and names the
posture task a way to cope with redundancy. Each is tried here on one walk of each person, the first
by name.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from experiments.gait_walks import QUICK_PEOPLE, Walks, reproduce_walks
from experiments.table import ResultTable, Row, sheets_of

NOTES = (
    "",
    "The ROM difference is the mean over the twelve rotations (mean over people, without sign), "
    "then of the mean absolute one and of the largest; RMSE is the mean of the twelve curves'. The "
    "swing knee peak is the greatest flexion of the swinging knee, mean over "
    "people. The centre of mass is off by the largest distance in any walk, and by the median of "
    "that over walks.",
)
VARIANTS = {
    "default": "eight phases: swing in its three parts, postures passed at their recorded rates",
    "no-rates": "eight phases, rates of the smooth curve through the postures",
    "six-phases": "swing divided only where the leg is shortest, recorded rates",
    "paper": "four phases, rates of the smooth curve through the postures",
    "two-phases": "two phases: heel strike to heel strike",
    "split-com": "four phases, centre of mass horizontally above vertically",
    "no-posture": "four phases, no posture task",
}


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over one walk of each person in a data folder.

    Raises:
        ParameterError: If the folder holds none of the walks.
    """
    rows: list[Row] = []
    notes, left_out = [*NOTES], []
    people = QUICK_PEOPLE if quick else None
    made = reproduce_walks(data, tuple(VARIANTS), people=people, one_each=True, say=say)
    for tasks, walks in made.items():
        left_out = walks.left_out
        notes += [
            f"{tasks}: {name} could not be made: {why}." for name, why in walks.failed.items()
        ]
        figures = summary(walks)
        if figures:
            rows += [Row(tasks, name, value, unit) for name, (value, unit) in figures.items()]
    table = sheets_of("One walk of each person", rows)
    notes += [f"{tasks}: {what}." for tasks, what in VARIANTS.items()]
    return ResultTable("Ordered tasks with parts left out", rows, [*notes, *left_out], table)


def summary(walks: Walks) -> dict[str, tuple[float, str]]:
    """Return the figures of one set of tasks with their units; none without a whole cycle."""
    if not walks.any_cycle:
        return {}
    result = walks.study(one_each=True)
    off = [1e3 * c.com_error_max_m for c in result.comparisons]
    knees = np.array([list(c.swing_knee.values()) for c in result.comparisons])
    simulated, recorded = np.nanmean(knees, axis=(0, 1))
    differences = [abs(row.difference) for row in result.rows]
    absolute = [row.difference_abs for row in result.rows]
    return {
        "people": (result.n, ""),
        "ROM difference": (float(np.mean(differences)), "deg"),
        "ROM difference, absolute": (float(np.mean(absolute)), "deg"),
        "ROM difference, largest": (float(np.max(differences)), "deg"),
        "RMSE": (float(np.mean([row.rmse for row in result.rows])), "deg"),
        "swing knee peak": (float(simulated), "deg"),
        "swing knee peak recorded": (float(recorded), "deg"),
        "centre of mass off by, largest": (float(np.max(off)), "mm"),
        "centre of mass off by, median": (float(np.median(off)), "mm"),
    }

"""Labels exchanged in a part of a recording, by the continuity of trajectories.

Where two labels change places from one frame to the next, each marker appears where the other one
was expected. Positions are predicted with constant velocity from the two frames before; markers far
from their prediction are assigned to the predictions anew, and the assignment is taken if it
explains the positions much better. The labels of most frames count as right.
"""

from collections import Counter
from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from plantigrade.kinematics.exchanged_labels import Exchange
from plantigrade.kinematics.faulty_samples import differences
from plantigrade.motion import Markers
from plantigrade.motion.filters import runs

# [m] minimum distance of an exchanged marker from its prediction. Heel and toe markers at landing
# deviate by 10 mm at 100 Hz.
MIN_JUMP = 0.04
MAX_LEFT = 0.2  # [1] maximum ratio of the distances after and before a new assignment
MIN_TIME = 0.1  # [s] minimum duration of an exchange; shorter ones are corrected without a note


def with_continuous_labels(markers: Markers) -> tuple[Markers, list[str]]:
    """Return the markers with the same labels in all frames, and a sentence for every exchange."""
    away = differences(markers.positions, 2) > MIN_JUMP
    suspects = np.flatnonzero(away.sum(axis=1) >= 2) + 2
    if not len(suspects):
        return markers, []
    x = np.array(markers.positions)
    order = np.tile(np.arange(x.shape[1]), (len(x), 1))  # trajectory → column, per frame
    for k in suspects:
        expected = 2 * x[k - 1] - x[k - 2]
        off = np.linalg.norm(x[k] - expected, axis=1)
        which = np.flatnonzero(off > MIN_JUMP)
        if len(which) < 2:
            continue
        distance = np.linalg.norm(x[k, which, None] - expected[which], axis=2)
        column, trajectory = linear_sum_assignment(distance)
        moved = column != trajectory
        column, trajectory = column[moved], trajectory[moved]
        if distance[column, trajectory].sum() < MAX_LEFT * off[which[column]].sum():
            here, there = which[column], which[trajectory]
            x[k:, there] = x[k:, here]
            order[k:, there] = order[k:, here]
    (usual, _), *others = Counter(map(tuple, order)).most_common()
    if not others:
        return markers, []
    labels = np.array(usual)
    positions = np.empty_like(x)
    positions[:, labels] = x
    return replace(markers, positions=positions), _notes(markers, order, labels)


def _notes(markers: Markers, order: np.ndarray, labels: np.ndarray) -> list[str]:
    notes, time = [], markers.time
    for other in sorted({tuple(row) for row in order} - {tuple(labels)}):
        columns = np.empty(len(labels), dtype=int)
        columns[labels] = other
        pairs = "; ".join(" and ".join(c) for c in Exchange.of(markers.names, columns).cycles)
        for run in runs(np.asarray((order == other).all(axis=1))):
            start, stop = time[run.start], time[run.stop - 1]
            if stop - start >= MIN_TIME:
                notes.append(
                    f"labels are swapped from {start:.2f} to {stop:.2f} s: {pairs}; the "
                    "trajectories are continuous otherwise, and this was corrected."
                )
    return notes

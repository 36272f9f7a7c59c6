"""Markers under their own labels: labels exchanged throughout, or in a part, are corrected.

**In a part of a recording**, continuity tells. Where two labels change places from one frame to the
next, each marker appears where the other one was expected. Positions are predicted with constant
velocity from the two frames before; markers far from their prediction are assigned to the
predictions anew, and the assignment is taken if it explains the positions much better. The labels
of most frames count as right.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from plantigrade.kinematics.exchanged_labels import Exchange, Landmarks, exchanged_by_anatomy
from plantigrade.kinematics.faulty_samples import differences
from plantigrade.kinematics.standing_trial import exchanged_by_standing, require_same_person
from plantigrade.kinematics.wrists import exchanged_wrists
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment, attachments
from plantigrade.motion import Markers, Recording
from plantigrade.motion.filters import runs

# [m] minimum distance of an exchanged marker from its prediction. Heel and toe markers at landing
# deviate by 10 mm at 100 Hz.
MIN_JUMP = 0.04
MAX_LEFT = 0.2  # [1] maximum ratio of the distances after and before a new assignment
MIN_TIME = 0.1  # [s] minimum duration of an exchange; shorter ones are corrected without a note


@dataclass(frozen=True)
class CorrectedLabels:
    """A recording and its standing trial with every marker under its own label."""

    recording: Recording  #: The recording
    static: Recording | None  #: Its standing trial, if there is one
    #: Labels of the recording that were exchanged with each other, mostly pairs
    exchanged: tuple[tuple[str, ...], ...] = ()
    notes: tuple[str, ...] = ()  #: Corrections, one sentence each


def corrected_labels(
    recording: Recording,
    static: Recording | None,
    human: Human,
    names: Sequence[str],
    placed: Mapping[str, Attachment | None],
) -> CorrectedLabels:
    """Put exchanged labels back: by anatomy, rigidity and the standing trial.

    Args:
        static: Its standing trial, if there is one.
        human: A person of about the size.
        placed: Where they sit; None where unknown.

    Raises:
        FitError: If the person is mirrored, or the standing trial is of another person.
    """
    notes: list[str] = []
    if static is not None and static.markers is not None:
        static, found = _as_anatomy_has_it(static, human, names, placed)
        notes += _said(found, f"the standing trial {static.source.name}")
        static, found = _thumbs_in_front(static, human, placed)
        notes += _said(found, f"the standing trial {static.source.name}")
    recording, found = _as_anatomy_has_it(recording, human, names, placed)
    exchanged = list(found.cycles)
    notes += _said(found, "the whole recording")
    recording, found = _thumbs_in_front(recording, human, placed)
    exchanged += found.cycles
    notes += _said(found, "the whole recording")
    if static is not None and static.markers is not None and recording.markers is not None:
        used = [n for n in recording.markers.names if n in names]
        markers = recording.markers.select(used)
        segments = {n: p.body for n in used if (p := placed[n]) is not None}
        found = exchanged_by_standing(markers, static.markers, list(segments))
        exchanged += found.cycles
        notes += _said(found, "the whole recording, as its standing trial shows")
        recording = replace(recording, markers=found.undone(recording.markers))
        markers = found.undone(markers)
        require_same_person(markers, static.markers, segments, static.source)
    return CorrectedLabels(recording, static, tuple(exchanged), tuple(notes))


def _as_anatomy_has_it(
    recording: Recording,
    human: Human,
    names: Sequence[str],
    placed: Mapping[str, Attachment | None],
) -> tuple[Recording, Exchange]:
    markers = recording.markers
    assert markers is not None
    own = {n: p for n in names if (p := placed[n]) is not None and n in markers.names}
    seen = {
        n: p for n, p in own.items() if np.isfinite(markers.positions[:, markers.index(n), 0]).any()
    }
    if not seen:
        return recording, Exchange({})
    known = Landmarks(human, tuple(seen), tuple(seen.values()))
    samples = markers.select(list(seen)).positions
    found = exchanged_by_anatomy(known, samples, recording.source)
    return replace(recording, markers=found.undone(markers)), found


def _thumbs_in_front(
    recording: Recording, human: Human, placed: Mapping[str, Attachment | None]
) -> tuple[Recording, Exchange]:
    assert recording.markers is not None
    table = {(a.body, tuple(a.position)): mark for mark, a in attachments(human).items()}
    marks = {n: table.get((p.body, tuple(p.position))) for n, p in placed.items() if p is not None}
    found = exchanged_wrists(recording.markers, marks)
    return replace(recording, markers=found.undone(recording.markers)), found


def _said(found: Exchange, where: str) -> list[str]:
    if not found:
        return []
    pairs = "; ".join(" and ".join(cycle) for cycle in found.cycles)
    return [f"labels are swapped throughout {where}: {pairs}; this was corrected."]


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

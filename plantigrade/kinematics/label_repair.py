r"""Markers under their own labels: labels exchanged throughout, or in a part, are corrected.

**In a part of a recording**, continuity tells. Where two labels change places from one frame to the
next, each marker appears where the other one was expected. Positions are predicted with constant
velocity from the two frames before; markers far from their prediction are assigned to the
predictions anew, and the assignment is taken if it explains the positions much better. The labels
of most frames count as right.

**At a wrist** anatomy tells which of its two sides a marker is on. A forearm turns on its length by
half a circle, from the palm forward to the palm back next to a hanging arm. Meanwhile the thumb's
side of the wrist goes from the outer side over the front to the inner side: it is never behind,
where the elbow does not bend to. With the flexion axis :math:`f` of the elbow, the forearm's
direction :math:`v` and the vector :math:`m` from the ulna's marker to the radius',

.. math:: \rho = \frac{m \cdot (f \times v)}{\lVert m \rVert}

is the sine of the angle of pronation; below :data:`MIN_PRONATION_SINE` the labels are exchanged.
Where the elbow has a lateral marker alone, the axis is the one that is perpendicular to upper arm
and forearm through the point inside of it, so that the kink of the markers in a straight arm is no
flexion.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.exchanged_labels import Exchange, Landmarks, exchanged_by_anatomy
from plantigrade.kinematics.faulty_samples import differences
from plantigrade.kinematics.standing_trial import exchanged_by_standing, require_same_person
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment, attachments
from plantigrade.motion import Markers, Recording
from plantigrade.motion.filters import runs
from plantigrade.spatial.conventions import unit_vectors

MIN_PRONATION_SINE = -0.35  # [1] sine of 20° beyond an end of the range [AAOS1965]_
ELBOW_MARKER_OFFSET = 0.042  # [m] distance of a lateral elbow marker from the joint centre
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


def exchanged_wrists(markers: Markers, marks: Mapping[str, str | None]) -> Exchange:
    """Return the wrist markers that are exchanged through a whole recording."""
    label = {mark: name for name, mark in marks.items() if mark and name in markers.names}
    found = {}
    for side in SIDES:
        pair = [label.get(f"wrist_{which}_{side}") for which in ("radial", "ulnar")]
        if None not in pair and thumb_side(markers, label, side) < MIN_PRONATION_SINE:
            found |= {str(pair[0]): str(pair[1]), str(pair[1]): str(pair[0])}
    return Exchange(found)


def thumb_side(markers: Markers, label: Mapping[str, str], side: str) -> float:
    """Return the sine of the forearm's pronation as the wrist markers show it, median of frames.

    It is 1 with the thumb in front, and NaN where markers of the arm are missing.

    Args:
        side: ``"r"`` or ``"l"``.
    """

    def at(mark: str) -> Float[Array, "n_frames 3"]:
        name = label.get(f"{mark}_{side}")
        if name is None:
            return np.full((markers.n_frames, 3), np.nan)
        return markers.positions[:, markers.index(name)]

    shoulder, elbow, medial = at("acromion"), at("elbow_lateral"), at("elbow_medial")
    radial, ulnar = at("wrist_radial"), at("wrist_ulnar")
    sign = 1.0 if side == "r" else -1.0
    u, v = elbow - shoulder, (radial + ulnar) / 2 - elbow
    outward = unit_vectors(elbow - medial)
    if np.isnan(outward).all():
        outward = _outward(u, v, sign)
        v = v + ELBOW_MARKER_OFFSET * outward
    else:
        v = v + (elbow - medial) / 2
    front = np.cross(sign * outward, unit_vectors(v))
    sines = (unit_vectors(radial - ulnar) * front).sum(axis=1)
    return float(np.nanmedian(sines)) if np.isfinite(sines).any() else float("nan")


def _outward(
    u: Float[Array, "n_frames 3"], v: Float[Array, "n_frames 3"], sign: float
) -> Float[Array, "n_frames 3"]:
    """Return the direction of the elbow's axis, outwards, from shoulder to elbow to wrist.

    It meets :data:`ELBOW_MARKER_OFFSET` along both, and the elbow bends forward about it.
    """
    uu, vv, uv = (u * u).sum(axis=1), (v * v).sum(axis=1), (u * v).sum(axis=1)
    area = np.maximum(uu * vv - uv**2, 1e-12)
    a, b = ELBOW_MARKER_OFFSET * (vv + uv) / area, -ELBOW_MARKER_OFFSET * (uu + uv) / area
    within = a[:, None] * u + b[:, None] * v
    across = np.sqrt(np.maximum(1 - (within**2).sum(axis=1), 0.0))
    return unit_vectors(within + sign * across[:, None] * unit_vectors(np.cross(u, v)))

r"""Markers of the legs that sit elsewhere on one side than on the other, or off both knees' axes.

**Sides.** Where a marker sits on a segment is found from the recording itself, so that one that is
centimetres off leaves no error. What shows it are two distances that it changes in opposite ways,
on this side and not on the other: a knee marker that is low makes a long thigh and a short shank, a
heel marker that is high comes nearer to the ankle and rises above the toes. A leg that is longer
than the other changes one of them alone, or both alike.

**Knees.** A low knee marker also lies below the point about which the shank turns, to which its
markers keep their distances (:func:`plantigrade.kinematics.joint_distances.joint_centre`). Either
alone may be of a person's proportions or of the skin. Their mean, weighted by what each has shown
of people, is the estimate for both legs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.kinematics.joint_distances import (
    MIN_SEEN,
    SegmentPoses,
    joint_centre,
    seen_markers,
)
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment, attachments
from plantigrade.motion import Markers

USUAL_RATIO = -0.03
"""Natural logarithm of thigh (hip centre to knee marker) over shank (knee to ankle marker) [1].
Eight people have -0.08 to 0.14, children the lowest; 0.01 are 2 mm of the marker."""
USUAL_CENTRE = -0.021
"""Height of the point about which the shank turns above the knee marker, along the thigh [m]: mean
of seven recordings with a standard deviation of 8 mm."""
CENTRE_WEIGHT = 0.7  # [1] weight of the centre in the estimate, by the inverse variances
MIN_KNEE_RANGE = np.deg2rad(40.0)  # [rad] minimum flexion that shows the centre; walks have 60°
MAX_HEIGHT = 0.027
"""Largest mean distance of the knee markers from their usual height [m]. Settled on 18 recordings
of 8 people with -0.010 to 0.025; 20 of 12 others have -0.018 to 0.013."""
MAX_DIFFERENCE = 0.025
"""Largest difference between the sides of where a marker sits [m]: half the difference of the two
distances that it changes. Settled on 16 recordings of 11 people, with up to 0.019; 20 recordings of
11 others have up to 0.020."""
MIN_SHARE = 0.3
"""Smallest share of each distance in their sum [1]: half where one marker changes both by as much;
legs of unequal length change one alone."""
LOW_SHARE = 0.2  # [1] share of the frames in which the markers of a foot are lowest, as in stance
MIN_FRAMES = 10  # [1] minimum number of frames with both markers


@dataclass(frozen=True)
class Move:
    """Two distances that a marker changes in opposite ways where it is moved one way."""

    marker: str  #: Name of the marker, for the sentence
    longer: str  #: Distance that grows
    shorter: str  #: Distance that shrinks
    ways: tuple[str, str]  #: Which way it sits where the first grows, and where it shrinks


MOVES = (
    Move("knee", "thigh", "shank", ("low", "high")),
    Move("ankle", "ankle above heel", "shank", ("high", "low")),
    Move("heel", "heel above toes", "ankle above heel", ("high", "low")),
    Move("heel", "heel behind ankle", "heel to toes, negative", ("far back", "far ahead")),
)


def side_notes(
    markers: Markers, landmarks: Mapping[str, str], human: Human, qpos: Float[Array, "n_frames nq"]
) -> list[str]:
    """Return a sentence for each marker of knee, ankle and heel that the other side contradicts.

    Args:
        markers: The markers that were fitted, turned so that the person faces x.
        landmarks: Landmark → marker.
    """
    right, left = (_distances(markers, landmarks, human, qpos, side) for side in SIDES)
    more = {what: right[what] - left[what] for what in right.keys() & left.keys()}
    notes, known = [], set()
    for move in MOVES:
        if move.longer not in more or move.shorter not in more or move.marker in known:
            continue
        grown, shrunk = more[move.longer], -more[move.shorter]
        off = 0.5 * (grown + shrunk)
        if abs(off) <= MAX_DIFFERENCE or min(grown / off, shrunk / off) < 2 * MIN_SHARE:
            continue
        known.add(move.marker)
        names = [landmarks[f"{_LANDMARKS[move.marker]}_{side}"] for side in SIDES]
        way = move.ways[0 if off > 0 else 1]
        other = move.ways[1 if off > 0 else 0]
        notes.append(
            f"the {move.marker} marker {names[0]} sits {1e3 * abs(off):.0f} mm further {way} than "
            f"{names[1]} does on the other side: {names[0]} is probably too {way}, or {names[1]} "
            f"too {other}; angles of the joints beside it are some degrees off."
        )
    return notes


_LANDMARKS = {"knee": "knee_lateral", "ankle": "ankle_lateral", "heel": "heel"}
_TOES = ("metatarsal_2_head", "hallux")


def _distances(
    markers: Markers,
    landmarks: Mapping[str, str],
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    side: str,
) -> dict[str, float]:
    """Return mean distances between markers of a leg, upward and forward ones of its stance [m]."""

    def path(*marks: str) -> Float[Array, "n 3"] | None:
        name = next((n for m in marks if (n := landmarks.get(f"{m}_{side}"))), None)
        return None if name is None else markers.positions[:, markers.index(name)]

    hip = PointSet.of(human, [attachments(human)[f"hip_joint_{side}"]]).path(qpos)[:, 0]
    knee, ankle, heel = (path(_LANDMARKS[joint]) for joint in _LANDMARKS)
    toes = path(*_TOES)
    found = {}
    if knee is not None:
        found["thigh"] = _mean(np.linalg.norm(knee - hip, axis=1))
    if knee is not None and ankle is not None:
        found["shank"] = _mean(np.linalg.norm(knee - ankle, axis=1))
    if ankle is not None and heel is not None and toes is not None:
        low = heel[:, 2] + toes[:, 2]
        if np.isfinite(low).sum() >= MIN_FRAMES:
            rests = low <= np.nanquantile(low, LOW_SHARE)
            along = (toes - heel)[rests, :2]
            length = np.linalg.norm(along, axis=1)
            ahead = ((ankle - heel)[rests, :2] * along).sum(axis=1) / length
            found["ankle above heel"] = _mean((ankle - heel)[rests, 2])
            found["heel above toes"] = _mean((heel - toes)[rests, 2])
            found["heel behind ankle"] = _mean(ahead)
            found["heel to toes, negative"] = -_mean(length)
    return {what: length for what, length in found.items() if np.isfinite(length)}


def _mean(x: Float[Array, " n"]) -> float:
    return float(np.mean(x[np.isfinite(x)])) if np.isfinite(x).sum() >= MIN_FRAMES else np.nan


def knee_notes(
    markers: Markers,
    landmarks: Mapping[str, str],
    places: Sequence[Attachment],
    human: Human,
    qpos: Float[Array, "n_frames nq"],
) -> list[str]:
    """Return a sentence where both knee markers sit too low or too high.

    Args:
        markers: The markers that were fitted.
        landmarks: Landmark → marker.
        places: Attachments of the markers.
        human: The scaled person.
        qpos: The motion.
    """
    low = _lowness(markers, landmarks, places, human, qpos)
    if low is None or not abs(low) > MAX_HEIGHT:
        return []
    names = [landmarks[f"knee_lateral_{side}"] for side in SIDE_NAMES]
    way, lengths = ("low", ("long", "short")) if low > 0 else ("high", ("short", "long"))
    return [
        f"the knee markers {names[0]} and {names[1]} sit about {1e3 * abs(low):.0f} mm too {way}: "
        f"thighs are {lengths[0]} and shanks {lengths[1]}, and the shanks turn about points "
        f"{'above' if low > 0 else 'below'} the markers; knee and ankle angles are some degrees "
        "off."
    ]


def _lowness(
    markers: Markers,
    landmarks: Mapping[str, str],
    places: Sequence[Attachment],
    human: Human,
    qpos: Float[Array, "n_frames nq"],
) -> float | None:
    """Return how far below their usual height the knee markers sit, mean of both sides [m].

    None where a marker is missing or seldom seen, or the knees bend too little.
    """
    found = []
    for side, name in SIDE_NAMES.items():
        knee, ankle = (landmarks.get(f"{joint}_lateral_{side}") for joint in ("knee", "ankle"))
        if knee is None or ankle is None:
            return None
        x, ends = markers.positions, [markers.index(knee), markers.index(ankle)]
        if np.isfinite(x[:, ends, 0]).mean(axis=0).min() < MIN_SEEN:
            return None
        if np.ptp(qpos[:, 7 + human.hinge(f"knee_angle_{side}")]) < MIN_KNEE_RANGE:
            return None
        hip = PointSet.of(human, [attachments(human)[f"hip_joint_{side}"]]).path(qpos)
        thigh = SegmentPoses.of(
            np.concatenate([x[:, seen_markers(places, x, f"{name} thigh")], hip], 1)
        )
        shank = x[:, seen_markers(places, x, f"{name} shank")]
        if thigh is None or not shank.shape[1]:
            return None
        centre = joint_centre(thigh.seen_from_here(shank))[0]
        on_knee = x[:, ends[:1]]
        up = np.nanmean(thigh.seen_from_here(hip) - thigh.seen_from_here(on_knee), axis=0)[0]
        at = np.nanmean(thigh.seen_from_here(on_knee), axis=0)[0]
        above = float((centre - at) @ up / np.linalg.norm(up))
        lengths = [
            float(np.nanmean(np.linalg.norm(end - on_knee[:, 0], axis=1)))
            for end in (hip[:, 0], x[:, ends[1]])
        ]
        ratio = 0.5 * np.mean(lengths) * (np.log(lengths[0] / lengths[1]) - USUAL_RATIO)
        found.append(CENTRE_WEIGHT * (above - USUAL_CENTRE) + (1 - CENTRE_WEIGHT) * ratio)
    return float(np.mean(found))

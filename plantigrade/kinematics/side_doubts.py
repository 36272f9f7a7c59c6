"""Markers of the legs that sit elsewhere on one side than on the other.

Where a marker sits on a segment is found from the recording itself, so that one that is centimetres
off leaves no error. What shows it are two distances that it changes in opposite ways, on this side
and not on the other: a knee marker that is low makes a long thigh and a short shank, a heel marker
that is high comes nearer to the ankle and rises above the toes. A leg that is longer than the other
changes one of them alone, or both alike.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.models.landmarks import attachments
from plantigrade.motion import Markers

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
    markers: Markers,
    landmarks: Mapping[str, str],
    human: Human,
    qpos: Float[Array, "n_frames nq"],
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

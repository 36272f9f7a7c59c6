"""Companion files of a recording: a standing trial, measured forces.

They are found in the folder of the recording by name and verified by content. In case of doubt
there is no companion, and the user gives it as an option.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plantigrade.errors import PlantigradeError
from plantigrade.io.siblings import Siblings
from plantigrade.io.subjects import same_size
from plantigrade.motion import ForcePlate, Recording
from plantigrade.motion.distances import distances

_MAX_MARKER_MOTION = 0.02  # [m] maximum deviation of markers from their mean in a standing trial
_MAX_SPREAD = 0.004  # [m] maximum spread of a distance between two markers on one segment
_MIN_DISTANCE = 0.08  # [m] minimum distance between such markers
_MAX_DIFFERENCE = 0.04  # maximum median relative difference of one person's distances


@dataclass(frozen=True)
class Companions:
    """Companions of a recording."""

    static: Recording | None = None  #: A standing trial of the same person
    forces: tuple[ForcePlate, ...] = ()  #: Measured ground reactions of the same trial
    forces_source: Path | None = None  #: The file they came from


def find_companions(recording: Recording, read) -> Companions:
    """Return the companions of a recording from its folder; ``read`` reads a file."""
    static = find_static(recording, read) if recording.markers is not None else None
    if recording.plates:
        return Companions(static)
    forces, source = find_forces(recording, read)
    return Companions(static, forces, source)


def find_static(recording: Recording, read) -> Recording | None:
    """Return the standing trial that belongs to a marker recording, or None."""
    markers = recording.markers
    if markers is None or is_still(recording):
        return None
    best: tuple[int, Recording] | None = None
    for other in Siblings.of(recording.source).standing_trials(recording.source):
        try:
            candidate = read(other)
        except PlantigradeError:
            continue
        if candidate.markers is None or not is_still(candidate):
            continue
        shared = len(set(candidate.markers.names) & set(markers.names))
        if shared < 0.6 * len(markers.names) or not same_person(recording, candidate):
            continue
        if best is None or shared > best[0]:
            best = (shared, candidate)
    return best[1] if best else None


def find_forces(recording: Recording, read) -> tuple[tuple[ForcePlate, ...], Path | None]:
    """Return the measured forces that belong to a recording without plates of its own."""
    time = _time_of(recording)
    if time is None or len(time) < 2:
        return (), None
    found = []
    for other in Siblings.of(recording.source).force_files(recording.source):
        try:
            candidate = read(other)
        except PlantigradeError:
            continue
        if not candidate.plates:
            continue
        clock = candidate.plates[0].time
        overlap = min(time[-1], clock[-1]) - max(time[0], clock[0])
        if overlap >= 0.8 * (time[-1] - time[0]):
            found.append((candidate.plates, other))
    converted = [each for each in found if each[1].suffix.lower() != ".forces"]
    found = converted or found  # a force file may exist twice, as recorded and for OpenSim
    return found[0] if len(found) == 1 else ((), None)


def candidates(path: Path) -> list[Path]:
    """Return the files that may be companions of a recording, by their names alone."""
    siblings = Siblings.of(path)
    return [*siblings.standing_trials(path), *siblings.force_files(path)]


def is_still(recording: Recording) -> bool:
    """Return whether the person stands still in a marker recording."""
    markers = recording.markers
    if markers is None:
        return False
    x = markers.positions
    seen = np.isfinite(x[..., 0]).mean(axis=0) > 0.5
    if seen.sum() < 4:
        return False
    wander = np.sqrt(np.nanvar(x[:, seen], axis=0).sum(axis=1))
    return bool(np.quantile(wander, 0.8) < _MAX_MARKER_MOTION)


def same_person(a: Recording, b: Recording) -> bool:
    """Return whether two marker recordings may show the same person with the same markers.

    Distances between markers that are constant in one recording must be the same in the other, to
    about a percent (soft tissue). A distance is constant if it varies by less than
    :data:`_MAX_SPREAD`.
    """
    if not same_size(a, b) or a.markers is None or b.markers is None:
        return False
    names = [n for n in a.markers.names if n in b.markers.names]
    here, there = (distances(m.select(names).positions) for m in (a.markers, b.markers))
    with np.errstate(invalid="ignore"):
        kept = np.triu(
            (here.spread < _MAX_SPREAD) & (here.usual > _MIN_DISTANCE) & np.isfinite(there.usual)
        )
    off = np.abs(there.usual[kept] / here.usual[kept] - 1)
    return not len(off) or float(np.median(off)) < _MAX_DIFFERENCE


def _time_of(recording: Recording) -> np.ndarray | None:
    for part in (recording.markers, recording.coordinates, recording.skeleton):
        if part is not None:
            return part.time
    return None

"""Companion files of a recording: a standing trial, measured forces.

They are found in the folder of the recording by name and verified by content. In case of doubt
there is no companion, and the user gives it as an option.
"""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from plantigrade.errors import PlantigradeError
from plantigrade.io.subjects import before_number, same_size
from plantigrade.motion import ForcePlate, Recording
from plantigrade.motion.distances import distances

# Words that describe the kind of data of a file, not the trial.
_KIND_WORDS = {
    "coordinates", "markers", "marker", "ik", "kinematics", "motion", "mot", "trc", "data",
    "results", "solution", "filtered", "raw", "joint", "angles", "reference",
}  # fmt: skip
_FORCE_WORDS = {"grf", "grfs", "force", "forces", "fp", "kinetics", "ground", "reaction"}
_STATIC_WORDS = {"static", "stat", "standing", "stand", "cal", "calib", "calibration", "tpose",
                 "npose", "neutral", "anatomical"}  # fmt: skip
_MAX_CANDIDATES = 12  # maximum number of opened candidates
_MAX_MARKER_MOTION = 0.02  # [m] maximum deviation of markers from their mean in a standing trial
_MAX_SPREAD = 0.004  # [m] maximum spread of a distance between two markers on one segment
_MIN_DISTANCE = 0.08  # [m] minimum distance between such markers
_MAX_DIFFERENCE = 0.04  # maximum median relative difference of one person's distances


@dataclass(frozen=True)
class Companions:
    """Companions of a recording.

    Attributes:
        static: A standing trial of the same person.
        forces: Measured ground reactions of the same trial.
        forces_source: The file they came from.
    """

    static: Recording | None = None
    forces: tuple[ForcePlate, ...] = ()
    forces_source: Path | None = None


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
    for other in _static_candidates(recording.source):
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
    for other in _force_candidates(recording.source):
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
    return [*_static_candidates(path), *_force_candidates(path)]


def _static_candidates(path: Path) -> list[Path]:
    """Return the files that may be the standing trial of a recording, likely ones first."""
    own = _words(path.stem)
    ranked = []
    for other in _siblings(path, [path.suffix]):
        words = _words(before_number(other.stem))
        named = bool(words & _STATIC_WORDS)
        numbered = before_number(other.stem) == before_number(path.stem)
        related = bool((words - _STATIC_WORDS) & own) or not (words - _STATIC_WORDS)
        if (named and related) or numbered:
            # Standing trials are short, so small files come first.
            ranked.append((not named, other.stat().st_size, other))
    return [other for *_, other in sorted(ranked)[:_MAX_CANDIDATES]]


def _force_candidates(path: Path) -> list[Path]:
    """Return the files that may hold the ground reactions of a recording."""
    own = _words(path.stem) - _KIND_WORDS
    named = []
    for other in _siblings(path, [".forces", ".mot", ".sto"])[:50]:
        words = _words(other.stem)
        if not (words & _FORCE_WORDS) and other.suffix.lower() != ".forces":
            continue
        rest = words - _FORCE_WORDS - _KIND_WORDS
        if rest == own or not own:
            named.append((rest != own, other))
        elif rest and _numbered(rest) == _numbered(own) and (rest <= own or own <= rest):
            named.append((True, other))
    exact = [other for less, other in named if not less]
    return exact or [other for _, other in named]


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


def _siblings(path: Path, suffixes: Iterable[str]) -> list[Path]:
    wanted = {s.lower() for s in suffixes}
    try:
        entries = sorted(path.resolve().parent.iterdir())
    except OSError:
        return []
    return [
        p for p in entries if p.suffix.lower() in wanted and p.name != path.name and p.is_file()
    ]


def _words(stem: str) -> set[str]:
    split = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", stem)
    for word in sorted(_FORCE_WORDS | _KIND_WORDS, key=len, reverse=True):
        if len(word) > 2:
            split = re.sub(rf"(?i)(?<![a-z]){word}(?![a-z])", f"_{word}_", split)
    return {w.lower() for w in re.split(r"[^A-Za-z0-9]+", split) if w}


def _numbered(words: set[str]) -> set[str]:
    """Return the words that identify a trial or a person."""
    return {w for w in words if any(c.isdigit() for c in w)}

"""Companion files of a recording: a standing trial, measured forces.

They are found in the folder of the recording by name and verified by content. In case of doubt
there is no companion, and the user gives it as an option. A folder is listed once and its names are
indexed, so that a batch over all files of a folder takes time linear in their number.
"""

import contextlib
import os
import re
import time
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from heapq import merge
from itertools import chain
from pathlib import Path

import numpy as np

from plantigrade.errors import PlantigradeError
from plantigrade.io.subjects import before_number, changes, same_size
from plantigrade.motion import ForcePlate, Recording

_MAX_MARKER_MOTION = 0.02  # [m] maximum deviation of markers from their mean in a standing trial
_MAX_DIFFERENCE = 0.04  # maximum median relative difference of one person's distances
# Words that describe the kind of data of a file, not the trial.
KIND_WORDS = {
    "coordinates", "markers", "marker", "ik", "kinematics", "motion", "mot", "trc", "data",
    "results", "solution", "filtered", "raw", "joint", "angles", "reference",
}  # fmt: skip
FORCE_WORDS = {"grf", "grfs", "force", "forces", "fp", "kinetics", "ground", "reaction"}
FORCE_SUFFIXES = {".forces", ".mot", ".sto"}
STATIC_WORDS = {"static", "stat", "standing", "stand", "cal", "calib", "calibration", "tpose",
                "npose", "neutral", "anatomical"}  # fmt: skip
MAX_CANDIDATES = 12  # maximum number of files of one kind that are opened; chosen
COARSEST_TIME_STAMP = 2.0  # [s] of a file system (FAT): a later change might not show
FOLDERS_KEPT = 16  # number of indexed folders in memory; chosen

Trial = frozenset[str]
"""Words of a file name that identify a trial."""


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
    about a percent (soft tissue).
    """
    if not same_size(a, b) or a.markers is None or b.markers is None:
        return False
    off = changes(a.markers, b.markers, both=False)
    return not len(off) or float(np.median(off)) < _MAX_DIFFERENCE


def _time_of(recording: Recording) -> np.ndarray | None:
    for part in (recording.markers, recording.coordinates, recording.skeleton):
        if part is not None:
            return part.time
    return None


@dataclass
class Siblings:
    """Files of a folder, indexed by the words of their names."""

    #: Size [B] and path of files named as standing trials, small ones first, by ending and each
    #: other word of the name (``""`` where there is none)
    static: dict[tuple[str, str], list[tuple[int, Path]]] = field(default_factory=dict)
    #: Size and path of all files, by ending and name before the trial number
    numbered: dict[tuple[str, str], list[tuple[int, Path]]] = field(default_factory=dict)
    #: Files that may hold ground reactions, by their trial
    forces: dict[Trial, list[Path]] = field(default_factory=dict)
    #: Trials of these files, by each of their words
    trials: dict[str, list[Trial]] = field(default_factory=dict)
    #: The same trials, each by that of its words which the fewest trials have
    rarest: dict[str, list[Trial]] = field(default_factory=dict)
    #: ASF files by name without ending, in small letters
    skeletons: dict[str, Path] = field(default_factory=dict)

    @classmethod
    def of(cls, path: Path) -> "Siblings":
        """Return the index of the folder of a recording; it is kept until the folder changes."""
        folder = path.resolve().parent
        try:
            changed = folder.stat().st_mtime_ns
            settled = time.time_ns() - changed > 1e9 * COARSEST_TIME_STAMP
            return _kept(folder, changed) if settled else _indexed(folder)
        except OSError:
            return cls()

    def standing_trials(self, path: Path) -> list[Path]:
        """Return the files that may be the standing trial of a recording, likely ones first."""
        ending = path.suffix.lower()
        named = merge(*(self.static.get((ending, word), ()) for word in {"", *_words(path.stem)}))
        found: dict[Path, None] = {}
        numbered = self.numbered.get((ending, before_number(path.stem)), ())
        for _, other in chain(named, numbered):
            if len(found) == MAX_CANDIDATES:
                break
            if other.name != path.name:
                found[other] = None
        return list(found)

    def force_files(self, path: Path) -> list[Path]:
        """Return the files that may hold the ground reactions of a recording; none if in doubt."""
        own = frozenset(_words(path.stem) - KIND_WORDS)
        found = self._forces_of([own], path)
        if not found:
            found = self._forces_of(self._related(own) if own else list(self.forces), path)
        return found if len(found) <= MAX_CANDIDATES else []

    def _forces_of(self, trials: Iterable[Trial], path: Path) -> list[Path]:
        files = (other for trial in trials for other in self.forces.get(trial, ()))
        return sorted(other for other in files if other.name != path.name)

    def _related(self, own: Trial) -> set[Trial]:
        """Return the trials whose words are part of a trial's, or the other way round."""
        wider = min((self.trials.get(word, []) for word in own), key=len)
        narrower = (trial for word in own for trial in self.rarest.get(word, ()))
        return {
            trial
            for trial in (*wider, *narrower)
            if _numbered(trial) == _numbered(own) and (trial <= own or own <= trial)
        }


def _indexed(folder: Path) -> Siblings:
    static, numbered, forces, trials, rarest = (defaultdict(list) for _ in range(5))
    skeletons = {}
    for name, size in sorted(_files(folder)):
        path = folder / name
        ending, before = path.suffix.lower(), before_number(path.stem)
        numbered[ending, before].append((size, path))
        words = _words(before)
        if words & STATIC_WORDS:
            for word in words - STATIC_WORDS or {""}:
                static[ending, word].append((size, path))
        words = _words(path.stem)
        if ending == ".forces" or (ending in FORCE_SUFFIXES and words & FORCE_WORDS):
            forces[frozenset(words - FORCE_WORDS - KIND_WORDS)].append(path)
        if ending == ".asf":
            skeletons.setdefault(path.stem.lower(), path)
    for trial in forces:
        for word in trial:
            trials[word].append(trial)
    for trial in filter(None, forces):
        rarest[min(trial, key=lambda word: (len(trials[word]), word))].append(trial)
    for files in (*static.values(), *numbered.values()):
        files.sort()
    return Siblings(static, numbered, forces, trials, rarest, skeletons)


@lru_cache(maxsize=FOLDERS_KEPT)
def _kept(folder: Path, changed: int) -> Siblings:
    del changed  # tells whether the index still holds
    return _indexed(folder)


def _files(folder: Path) -> Iterable[tuple[str, int]]:
    """Yield name and size [B] of each file of a folder."""
    with os.scandir(folder) as entries:
        for entry in entries:
            with contextlib.suppress(OSError):  # a file that was removed meanwhile
                if entry.is_file():
                    yield entry.name, entry.stat().st_size


def _words(stem: str) -> set[str]:
    split = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", stem)
    for word in sorted(FORCE_WORDS | KIND_WORDS, key=len, reverse=True):
        if len(word) > 2:
            split = re.sub(rf"(?i)(?<![a-z]){word}(?![a-z])", f"_{word}_", split)
    return {w.lower() for w in re.split(r"[^A-Za-z0-9]+", split) if w}


def _numbered(words: Trial) -> set[str]:
    """Return the words that identify a trial or a person."""
    return {w for w in words if any(c.isdigit() for c in w)}

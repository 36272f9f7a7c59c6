"""Grouping of recordings by subject with the same marker placement.

Recordings of one group are in one folder and have the same subject in the file or, without one, the
same name before the trial number. In addition, constant distances between markers are equal. That
holds within a session; another placement of markers differs by some millimetres, other people by
more.
"""

from collections.abc import Hashable, Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion import Markers, Recording
from plantigrade.motion.distances import distances

MAX_SPREAD = 0.004  # [m] spread of a distance on one segment
MIN_DISTANCE = 0.08  # [m] shortest such distance
MIN_DISTANCES = 6  # minimum number of distances that identify a subject
MAX_DIFFERENCE = 0.02
"""Maximum median relative difference of such distances within one session. Trials of a session
differ by 0.002 to 0.006, from a standing trial by up to 0.015; other people by 0.04 and more."""

MAX_COMPARED = 20
"""Most groups of one name that a recording is compared with, the latest by file name: trials of a
session follow one another, and a folder of any size takes time linear in its files."""


def subjects(recordings: Sequence[Recording]) -> list[tuple[int, ...]]:
    """Return the recordings of each subject, as indices; a doubtful recording stays alone.

    The groups do not depend on the order of the recordings; each is sorted by file.
    """
    order = sorted(range(len(recordings)), key=lambda i: str(recordings[i].source))
    named: dict[Hashable, list[list[int]]] = {}
    for i in order:
        groups = named.setdefault(_name(recordings[i]) or i, [])
        for group in groups[-MAX_COMPARED:]:
            one = recordings[group[0]]
            if same_size(one, recordings[i]) and difference(one, recordings[i]) < MAX_DIFFERENCE:
                group.append(i)
                break
        else:
            groups.append([i])
    return [tuple(group) for groups in named.values() for group in groups]


def _name(recording: Recording) -> tuple[str, ...] | None:
    """Return folder and subject of a recording, None where it names no subject."""
    folder, name = str(recording.source.resolve().parent), recording.subject.name
    before = before_number(recording.source.stem)
    return (folder, name) if name else (folder, "before number", before) if before else None


def same_size(a: Recording, b: Recording) -> bool:
    """Return whether height and mass agree to 5 %, if both files give them."""
    for name in ("height", "mass"):
        one, other = getattr(a.subject, name), getattr(b.subject, name)
        if one and other and abs(one - other) > 0.05 * one:
            return False
    return True


def difference(a: Recording, b: Recording) -> float:
    """Return the median relative difference of common constant marker distances.

    It is infinite if there are too few.
    """
    if a.markers is None or b.markers is None:
        return float("inf")
    off = changes(a.markers, b.markers, both=True)
    return float("inf") if len(off) < MIN_DISTANCES else float(np.median(off))


def changes(a: Markers, b: Markers, *, both: bool) -> Float[Array, " n"]:
    """Return the relative differences of the marker distances that two recordings share.

    Distances are constant, as on one segment: they vary by less than :data:`MAX_SPREAD`.

    Args:
        both: Whether distances are constant in both recordings, or in the first at least.
    """
    names = [n for n in a.names if n in b.names]
    here, there = (distances(m.select(names).positions) for m in (a, b))
    with np.errstate(invalid="ignore"):
        rigid = (here.spread < MAX_SPREAD) & (here.usual > MIN_DISTANCE)
        rigid &= (there.spread < MAX_SPREAD) | (not both)
    kept = np.triu(rigid & np.isfinite(there.usual))
    return np.abs(there.usual[kept] / here.usual[kept] - 1)


def before_number(stem: str) -> str:
    """Return the name of a trial without the number at its end.

    Example:
        >>> before_number("HC038A11"), before_number("walk_02"), before_number("static")
        ('HC038A', 'walk', 'static')
    """
    return stem.rstrip("0123456789").rstrip("_- .")

"""Maximum length of recordings, by frames and the memory that reading and fitting them needs."""

from dataclasses import fields
from pathlib import Path

import numpy as np

from plantigrade.errors import FileError, FitError
from plantigrade.motion import Recording

MAX_FRAMES = 360_000
"""Maximum length of a recording [frames], an hour at 100 Hz, as for text files of 200 MB; its fit
takes an hour and several gigabytes."""
ASSUMED_FREE_BYTES = 4e9
"""Assumed free memory if the system does not report it [bytes], half of a small laptop's."""
REMEDY = "export it in parts, or at a lower frame rate"

_MEMINFO = Path("/proc/meminfo")
_GROUPS, _GROUP = Path("/sys/fs/cgroup"), Path("/proc/self/cgroup")
FIT_BASE_BYTES = 150e6  # Memory of a fit besides its frames [bytes], measured
FIT_BYTES_PER_FRAME = 12e3
"""Memory of a fit for each frame [bytes], measured on 10 minutes at 100 Hz."""
RECORDING_COPIES = 2  # Copies of the recording that a fit makes: turned to face forward, and cut


def check_length(path: str | Path, n_frames: int, n_bytes: float = 0.0) -> None:
    """Raise for a recording that is too long, before memory is allocated.

    Args:
        n_bytes: Memory required for reading [bytes].
    """
    if n_frames > MAX_FRAMES:
        problem = f"has {n_frames} frames; at most {MAX_FRAMES} (an hour at 100 Hz) are read"
        raise FileError(path, problem, remedy=REMEDY)
    free = free_memory()
    if n_bytes > free:
        problem = (
            f"its {n_frames} frames need {n_bytes / 1e9:.1f} GB of memory to be read, "
            f"{free / 1e9:.1f} GB are free"
        )
        raise FileError(path, problem, remedy=f"close other programs, or {REMEDY}")


def free_memory() -> float:
    """Return the memory available to this process without swapping [bytes].

    It is that of the system, or less in a container or job with a limit.
    """
    found = [_available(), _left_of_group()]
    return min((each for each in found if each is not None), default=ASSUMED_FREE_BYTES)


def _available() -> float | None:
    """Return the available memory of Linux; None on other systems."""
    try:
        fields = dict(line.split(":") for line in _MEMINFO.read_text().splitlines())
        return 1024.0 * int(fields["MemAvailable"].split()[0])  # in KiB
    except (OSError, ValueError, KeyError, IndexError):
        return None


def _left_of_group() -> float | None:
    """Return the remaining memory of a control group (Linux, version 2); None without one."""
    try:
        group = _GROUPS / _GROUP.read_text().strip().rpartition("::")[2].strip("/")
        limit, used = (int((group / f"memory.{n}").read_text()) for n in ("max", "current"))
        stat = dict(line.split() for line in (group / "memory.stat").read_text().splitlines())
    except (OSError, ValueError):  # no group, or its limit is "max"
        return None
    return float(max(limit - used + int(stat.get("inactive_file", 0)), 0))  # the cache is given up


def require_memory(recording: Recording) -> None:
    """Refuse a recording whose fit would not fit into free memory; the machine would swap."""
    motion = (recording.markers, recording.skeleton, recording.coordinates)
    parts = [part for part in (*motion, *recording.plates) if part is not None]
    arrays = [getattr(part, f.name) for part in parts for f in fields(part)]
    held = sum(each.nbytes for each in arrays if isinstance(each, np.ndarray))
    n_frames = max((len(part.time) for part in motion if part is not None), default=0)
    needed, free = (
        FIT_BASE_BYTES + FIT_BYTES_PER_FRAME * n_frames + RECORDING_COPIES * held,
        free_memory(),
    )
    if needed > free:
        raise FitError(
            f"{recording.source.name} has {n_frames} frames; their fit needs {needed / 1e9:.1f} GB "
            f"of memory, {free / 1e9:.1f} GB are free: close other programs, or {REMEDY}"
        )

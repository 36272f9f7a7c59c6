"""How long a recording may be: frames that are read, and memory that the machine can give."""

from pathlib import Path

from plantigrade.errors import FileError

MAX_FRAMES = 360_000
"""Longest recording that is read [frames]: an hour at 100 Hz, as of text files of 200 MB. A fit of
it takes an hour and some gigabytes."""
ASSUMED_FREE_BYTES = 4e9
"""Free memory assumed where the system does not report it [bytes]: half of a small laptop's."""
IN_PARTS = "export it in parts, or at a lower frame rate"

_MEMINFO = Path("/proc/meminfo")
_GROUPS, _GROUP = Path("/sys/fs/cgroup"), Path("/proc/self/cgroup")


def check_length(path: str | Path, n_frames: int, n_bytes: float = 0.0) -> None:
    """Refuse a recording that is too long, before memory is taken for it.

    Args:
        path: The file.
        n_frames: Number of its frames.
        n_bytes: Memory that reading it takes [bytes].

    Raises:
        FileError: If it has more than :data:`MAX_FRAMES` frames, or does not fit into free memory.
    """
    if n_frames > MAX_FRAMES:
        problem = f"has {n_frames} frames; at most {MAX_FRAMES} (an hour at 100 Hz) are read"
        raise FileError(path, problem, remedy=IN_PARTS)
    free = free_memory()
    if n_bytes > free:
        problem = (
            f"its {n_frames} frames need {n_bytes / 1e9:.1f} GB of memory to be read, "
            f"{free / 1e9:.1f} GB are free"
        )
        raise FileError(path, problem, remedy=f"close other programs, or {IN_PARTS}")


def free_memory() -> float:
    """Return how much memory this process can still take without swapping [bytes].

    It is what the system calls available, or less in a container or job with a limit of its own.
    """
    found = [_available(), _left_of_group()]
    return min((each for each in found if each is not None), default=ASSUMED_FREE_BYTES)


def _available() -> float | None:
    """Return the memory that Linux calls available; None on other systems."""
    try:
        fields = dict(line.split(":") for line in _MEMINFO.read_text().splitlines())
        return 1024.0 * int(fields["MemAvailable"].split()[0])  # in KiB
    except (OSError, ValueError, KeyError, IndexError):
        return None


def _left_of_group() -> float | None:
    """Return what is left of the memory of a control group (Linux, version 2); None without one."""
    try:
        group = _GROUPS / _GROUP.read_text().strip().rpartition("::")[2].strip("/")
        limit, used = (int((group / f"memory.{n}").read_text()) for n in ("max", "current"))
        stat = dict(line.split() for line in (group / "memory.stat").read_text().splitlines())
    except (OSError, ValueError):  # no group, or its limit is "max"
        return None
    return float(max(limit - used + int(stat.get("inactive_file", 0)), 0))  # the cache is given up

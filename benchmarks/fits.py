"""From command to finished run folder, for every recording of a folder."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks.processes import PLANTIGRADE, measure
from experiments.table import Row, at_most
from plantigrade.errors import PlantigradeError
from plantigrade.io import read
from plantigrade.motion import Recording

MAX_FIT_TIME = 15.0  # seconds from command to finished run folder


def rows(data: Path) -> Iterator[Row]:
    """Yield the time of ``plantigrade fit FILE`` in a fresh process for every motion there is.

    A file that holds a motion and yet is not fitted is listed with the reason; files that hold
    none (ground reactions alone, tables) are left out.
    """
    most = 0.0
    for path in sorted(data.rglob("*")):
        if not path.is_file() or not _moves(path):
            continue
        name = str(path.relative_to(data))
        with tempfile.TemporaryDirectory() as folder:
            spent = measure([*PLANTIGRADE, "fit", str(path), "--out", str(Path(folder) / "run")])
        most = max(most, spent.peak_mb)
        if spent.code == 0:
            yield at_most("fit", name, spent.seconds, MAX_FIT_TIME, "s")
        else:  # refused with a reason (2); anything else should not happen
            why = f"exit code {spent.code}: {spent.message[:160]}"
            yield Row("fit", name, None, note=why, met=None if spent.code == 2 else False)
    if most:
        yield Row("fit", "peak memory of the largest", most, "MB")


def _moves(path: Path) -> bool:
    try:
        recording = read(path)
    except PlantigradeError:
        return False
    return _has_motion(recording)


def _has_motion(recording: Recording) -> bool:
    parts = (recording.markers, recording.skeleton, recording.coordinates)
    return any(part is not None and len(part.names) > 0 for part in parts)

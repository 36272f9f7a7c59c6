"""How fast each file format is read."""

import time
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from experiments.table import Row
from plantigrade.errors import PlantigradeError
from plantigrade.io import format_of, read

REPEATS = 3  # times a file is read; the best counts


def rows(data: Path) -> Iterator[Row]:
    """Yield megabytes per second for every format of which the folder has recordings."""
    sizes, seconds, counts = defaultdict(float), defaultdict(float), defaultdict(int)
    for path in sorted(data.rglob("*")):
        if not path.is_file():
            continue
        try:
            kind = format_of(path).name
            read(path)
        except PlantigradeError:
            continue  # no recording
        best = min(_time(path) for _ in range(REPEATS))
        sizes[kind] += path.stat().st_size / 1e6
        seconds[kind] += best
        counts[kind] += 1
    for kind in sizes:
        files = f"{counts[kind]} files, {sizes[kind]:.1f} MB"
        yield Row("reading", kind, sizes[kind] / seconds[kind], "MB/s", note=files)


def _time(path: Path) -> float:
    begin = time.perf_counter()
    read(path)
    return time.perf_counter() - begin

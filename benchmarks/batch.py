"""Batches: what an item costs, how well two cores are used, whether memory stays flat."""

import json
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from benchmarks.processes import PLANTIGRADE
from experiments.table import Row, at_least, at_most
from plantigrade.io import read, write

RECORDINGS = (
    "c3d/HC038A11.c3d",
    "c3d/HC032A03.c3d",
    "c3d/opensim_walking2.c3d",
    "opensim/rajagopal_walk/markers_walk.trc",
    "opensim/gait2392_subject01/subject01_walk1.trc",
)
"""Walks of five laboratories."""
NOISE_M = 0.001
"""Standard deviation of the noise that makes an item of its own of a recording [m]."""
EFFICIENCY = 0.85
"""Goal of the share of the cores that is used."""
MAX_MEMORY_GROWTH = 1.1
"""Goal of the memory in the last quarter of the items over that in the second."""
SAMPLE_SECONDS = 0.5


@dataclass(frozen=True)
class Spent:
    """What a batch took.

    Attributes:
        seconds: From the command to its end [s].
        memory: Memory of the process and its workers together, every half second [MB].
        failed: Number of items that failed.
        megabytes: Size of its folder [MB].
    """

    seconds: float
    memory: list[float]
    failed: int
    megabytes: float


def rows(data: Path, items: int, jobs: int) -> Iterator[Row]:
    """Yield time and memory of ``plantigrade fit`` on many recordings, with one core and more."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        few = max(items // 5, len(RECORDINGS))
        every = _recordings(data, folder / "items", items)
        (folder / "few.txt").write_text("".join(f"{path}\n" for path in every[:few]))
        (folder / "all.txt").write_text("".join(f"{path}\n" for path in every))
        alone = _spent(folder, "few", jobs=1)
        both = _spent(folder, "all", jobs=jobs)
        pages = _spent(folder, "few", jobs=jobs, keep="pages")
    per_item = both.seconds / items
    subject = f"batch of {items}, {jobs} cores"
    yield Row(subject, "failed", both.failed, met=both.failed == 0)
    yield Row(subject, "seconds per item and core, one core", alone.seconds / few, "s")
    yield Row(subject, "seconds per item", per_item, "s")
    yield Row(subject, "seconds per item, with pages", pages.seconds / few, "s")
    efficiency = alone.seconds / few / (jobs * per_item)
    yield at_least(subject, "efficiency", efficiency, EFFICIENCY)
    n = len(both.memory)
    middle, last = max(both.memory[n // 4 : n // 2]), max(both.memory[3 * n // 4 :])
    yield Row(subject, "memory of all processes, last quarter", last, "MB")
    yield at_most(subject, "memory, last quarter over second", last / middle, MAX_MEMORY_GROWTH)
    yield Row(subject, "folder per item", 1e3 * both.megabytes / items, "kB")
    yield Row(subject, "folder per item, with pages", 1e3 * pages.megabytes / few, "kB")
    hours = 1e5 * jobs * per_item / 3600
    yield Row(subject, "core hours of 100,000 items, extrapolated", hours, "h")


def _recordings(data: Path, folder: Path, count: int) -> list[Path]:
    """Write recordings with noise of their own."""
    folder.mkdir()
    read_once = [read(data / name) for name in RECORDINGS]
    rng = np.random.default_rng(0)
    paths = []
    for k in range(count):
        recording = read_once[k % len(read_once)]
        assert recording.markers is not None
        noisy = recording.markers.positions + rng.normal(
            scale=NOISE_M, size=recording.markers.positions.shape
        )
        path = folder / f"p{k:05d}" / f"{recording.source.stem}{recording.source.suffix}"
        path.parent.mkdir()
        markers = replace(recording.markers, positions=noisy)
        write(replace(recording, source=path, markers=markers), path)
        paths.append(path)
    return paths


def _spent(folder: Path, name: str, *, jobs: int, keep: str = "figures") -> Spent:
    out = folder / f"{name}-{jobs}-{keep}"
    words = [*PLANTIGRADE, "fit", "--list", str(folder / f"{name}.txt"), "--keep", keep]
    words += ["--jobs", str(jobs), "--out", str(out), "--quiet"]
    began, memory = time.perf_counter(), []
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    while process.poll() is None:
        memory.append(_memory(process.pid))
        time.sleep(SAMPLE_SECONDS)
    seconds = time.perf_counter() - began
    metrics = json.loads((out / "metrics.json").read_text(encoding="utf-8"))
    size = sum(path.stat().st_size for path in out.rglob("*") if path.is_file())
    return Spent(seconds, memory, metrics["without_result_count"], size / 1e6)


def _memory(pid: int) -> float:
    """Return the resident memory of a process and of those it started [MB]; Linux only."""
    parents: dict[int, int] = {}
    resident: dict[int, float] = {}
    for place in Path("/proc").iterdir():
        if not place.name.isdigit():
            continue
        try:
            words = (place / "stat").read_text().rpartition(")")[2].split()
            pages = int((place / "statm").read_text().split()[1])
        except OSError:  # it has ended
            continue
        parents[int(place.name)] = int(words[1])
        resident[int(place.name)] = pages * 4096 / 1e6

    def below(one: int) -> bool:
        while one and one != pid:
            one = parents.get(one, 0)
        return one == pid

    return sum(size for one, size in resident.items() if below(one))

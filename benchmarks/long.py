"""Long recordings: time, memory and pages of a fit by duration.

A short recording of steady walking on a treadmill with plates is repeated for as long as asked.
"""

import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from benchmarks.processes import ALL_IMPORTS, PLANTIGRADE, measure
from experiments.table import Row, at_most
from plantigrade.arrays import Array, Float
from plantigrade.io import read, write
from plantigrade.motion.recording import ForcePlate, Markers, Recording

SOURCE = "c3d/gaitalytics_treadmill_events.c3d"
MINUTES = (0.2, 1.0)
"""Default durations [min]: both take some minutes together; 10 is what a goal is stated for."""
MOST_MEMORY = 1000.0
"""Goal for the peak memory of a fit, up to 10 minutes at 100 Hz [MB]."""
LARGEST_PAGE = 50.0
"""Goal for each page [MB]: a browser opens it in seconds."""

NOISE = 5e-4
"""Standard deviation of the noise added to every coordinate of a marker [m]: that of a laboratory,
so that no two strides are equal."""
BLEND_TIME = 0.1
"""Time over which one pass goes over into the next [s]."""


def rows(data: Path, minutes: Sequence[float] = MINUTES) -> Iterator[Row]:
    """Yield what ``plantigrade fit`` takes in a fresh process, for each duration [min]."""
    recording = read(data / SOURCE)
    start = measure([sys.executable, "-c", ALL_IMPORTS]).peak_mb
    for each in minutes:
        with tempfile.TemporaryDirectory() as folder:
            path, run = Path(folder) / "long.c3d", Path(folder) / "run"
            longer = prolonged(recording, 60.0 * each)
            assert longer.markers is not None  # the source has some
            write(longer, path)
            spent = measure([*PLANTIGRADE, "fit", str(path), "--out", str(run)])
            what = f"{each:g} min"
            if spent.code != 0:
                yield Row("long", f"{what}: failed", None, note=spent.message, met=False)
                continue
            note = f"{spent.cpu_seconds:.0f} s of processor time"
            yield Row("long", f"{what}: command to run folder", spent.seconds, "s", note=note)
            yield at_most("long", f"{what}: peak memory", spent.peak_mb, MOST_MEMORY, "MB")
            more = 1000.0 * (spent.peak_mb - start) / longer.markers.n_frames
            yield Row("long", f"{what}: memory of 1000 frames", more, "MB")
            for page in ("report.html", "viewer.html"):
                size = (run / page).stat().st_size / 1e6
                yield at_most("long", f"{what}: {page}", size, LARGEST_PAGE, "MB")


def prolonged(recording: Recording, duration: float, seed: int = 0) -> Recording:
    """Return the recording repeated for a duration [s], with noise on the markers.

    A pass goes from the first heel strike of a side to its last one, and goes over into the next
    within :data:`BLEND_TIME`.
    """
    markers = recording.markers
    assert markers is not None
    strikes = [e for e in recording.events if e.kind == "heel_strike"]
    margin = markers.time[0] + BLEND_TIME
    strikes = [e.time for e in strikes if e.side == strikes[0].side and e.time > margin]
    first, last = strikes[0], strikes[-1]
    n_frames = int(round(duration * markers.rate))
    clock = np.arange(n_frames) / markers.rate
    positions = _repeated(markers.time, markers.positions, clock, first, last)
    noise = np.random.default_rng(seed).normal(0.0, NOISE, positions.shape)
    plates = tuple(_repeated_plate(plate, duration, first, last) for plate in recording.plates)
    passed = [replace(e, time=e.time - first) for e in recording.events if first <= e.time < last]
    starts = np.arange(0.0, duration, last - first)
    events = [replace(e, time=start + e.time) for start in starts for e in passed]
    return replace(
        recording,
        markers=Markers(markers.names, clock, positions + noise),
        plates=plates,
        events=tuple(event for event in events if event.time < clock[-1]),
        outputs={},
    )


def _repeated_plate(plate: ForcePlate, duration: float, first: float, last: float) -> ForcePlate:
    rate = (len(plate.time) - 1) / (plate.time[-1] - plate.time[0])
    clock = np.arange(int(round(duration * rate))) / rate
    force, cop = (_repeated(plate.time, x, clock, first, last) for x in (plate.force, plate.cop))
    free = _repeated(plate.time, plate.free_moment[:, None], clock, first, last)[:, 0]
    return replace(plate, time=clock, force=force, cop=cop, free_moment=free)


def _repeated(
    time: Float[Array, " n"], values: Float[Array, "n ..."], clock: Float[Array, " m"],
    first: float, last: float,
) -> Float[Array, "m ..."]:  # fmt: skip
    """Return values at times ``clock`` of the passes from ``first`` to ``last``, one after another.

    The end of a pass is blended with what came before its beginning.
    """
    rate = (len(time) - 1) / (time[-1] - time[0])
    begin = int(round((first - time[0]) * rate))
    length = int(round((last - first) * rate))
    blend = int(round(BLEND_TIME * rate))
    one = values[begin : begin + length].copy()
    weight = (np.arange(1, blend + 1) / (blend + 1)).reshape(-1, *[1] * (values.ndim - 1))
    before = values[begin - blend : begin]
    one[-blend:] = (1 - weight) * one[-blend:] + weight * before
    return one[np.arange(len(clock)) % length]

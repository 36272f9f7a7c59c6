"""Inverse kinematics per frame, compared with OpenSim's if it is installed."""

import json
import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from experiments.table import Row, at_least, at_most
from plantigrade.kinematics.inverse import InverseKinematics, track
from plantigrade.kinematics.state import PointSet
from plantigrade.workflows.fit import fit_trial

RAJAGOPAL = "opensim/rajagopal_walk/markers_walk.trc"
RAJAGOPAL_MODEL = "opensim/rajagopal_walk/subject_walk_scaled.osim"
TRIALS = (
    RAJAGOPAL,
    "opensim/gait2392_subject01/subject01_walk1.trc",
    "c3d/HC038A11.c3d",
    "c3d/opensim_walking2.c3d",
    "c3d/gaitalytics_treadmill_events.c3d",
)
REPEATS = 3


@dataclass(frozen=True)
class Solved:
    """Inverse kinematics of one trial.

    Attributes:
        frames_ms: Time of each frame [ms], the shortest of the repeats.
        cpu_ms: Processor time per frame of the whole trial, first frame included [ms].
        rms_mm: Mean over the frames of the root mean square distance to the markers [mm].
        markers: Markers fitted.
        fit_s: Reading, scaling, calibration, kinematics and analysis together [s].
    """

    frames_ms: np.ndarray
    cpu_ms: float
    rms_mm: float
    markers: int
    fit_s: float


def rows(data: Path) -> Iterator[Row]:
    """Yield time per frame and per fit of walking trials with markers."""
    for name in TRIALS:
        if not (data / name).exists():
            yield Row(name, "not measured", None, note="the file is not there")
            continue
        solved = solve(data / name)
        median, p95 = np.percentile(solved.frames_ms, [50, 95])
        size = f"{len(solved.frames_ms)} frames, {solved.markers} markers"
        row = at_most(name, "inverse kinematics, median", float(median), 1.0, "ms/frame")
        yield replace(row, note=size)
        yield Row(name, "inverse kinematics, 95th percentile", float(p95), "ms/frame")
        yield Row(name, "read, scale, fit and analyse", solved.fit_s, "s")


def solve(path: Path) -> Solved:
    """Fit a trial, then time its inverse kinematics alone on the person found."""
    begin = time.perf_counter()
    fit = fit_trial(path)[1].fit
    fit_s = time.perf_counter() - begin
    assert fit.markers is not None  # these trials are markers
    measured = fit.markers.positions
    points = PointSet(
        fit.human, [p.body for p in fit.places], np.array([p.position for p in fit.places])
    )
    solver = InverseKinematics(points)
    frames = np.full(len(measured), np.inf)
    for _ in range(REPEATS):
        q = fit.qpos[0]
        for k, markers in enumerate(measured):
            begin = time.perf_counter()
            q = solver.solve(markers, q).qpos
            frames[k] = min(frames[k], time.perf_counter() - begin)
    cpu = []
    for _ in range(REPEATS):
        begin = time.process_time()
        _, residual = track(solver, measured, points.human.standing())
        cpu.append(time.process_time() - begin)
    rms = np.sqrt(np.nanmean(residual**2, axis=1))
    return Solved(
        1e3 * frames,
        1e3 * min(cpu) / len(measured),
        1e3 * float(np.nanmean(rms)),
        measured.shape[1],
        fit_s,
    )


def opensim_rows(data: Path, python: str) -> Iterator[Row]:
    """Yield our and OpenSim's inverse kinematics on the same markers, in the same run."""
    what = "beside OpenSim"
    theirs, why = solve_with_opensim(data, python)
    if theirs is None:
        yield Row(what, "not measured", None, note=why)
        return
    ours = solve(data / RAJAGOPAL)
    version = f"OpenSim {theirs['version']}, {theirs['markers']} markers"
    yield Row(what, "theirs, processor time", theirs["cpu_ms"], "ms/frame", note=version)
    yield Row(
        what,
        "ours, processor time",
        ours.cpu_ms,
        "ms/frame",
        note=f"{ours.markers} markers, started from standing",
    )
    yield at_least(what, "times faster", theirs["cpu_ms"] / ours.cpu_ms, 10)
    yield Row(what, "theirs, mean marker RMS", theirs["rms_mm"], "mm")
    yield at_most(what, "ours, mean marker RMS", ours.rms_mm, theirs["rms_mm"], "mm")


def solve_with_opensim(data: Path, python: str) -> tuple[dict | None, str]:
    """Run OpenSim's tool in the given interpreter; return its figures, or None and why not."""
    for name in (RAJAGOPAL, RAJAGOPAL_MODEL):
        if not (data / name).exists():
            return None, f"{name} is not in the folder of recordings"
    if shutil.which(python) is None:
        return None, f"no Python at {python}"
    script = Path(__file__).with_name("opensim_reference.py")
    with tempfile.TemporaryDirectory() as folder:
        command = [python, str(script), str(data / RAJAGOPAL_MODEL), str(data / RAJAGOPAL)]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        answer = Path(folder) / "figures.json"
        if answer.exists():
            return json.loads(answer.read_text()), ""
    if "No module named 'opensim'" in done.stderr:
        return None, "OpenSim is not installed; name a Python that has it: --opensim-python"
    last = done.stderr.strip().splitlines()
    return None, f"OpenSim failed: {last[-1] if last else f'exit code {done.returncode}'}"

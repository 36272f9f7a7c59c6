"""Estimated vertical forces by phase: single support, double support, ends of a recording.

Recordings are cut in double support and just after landings, which gives many ends with known
forces: the plates measured beyond the cut as well.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from experiments.table import Row
from plantigrade.analyze.gait_forces import STANCE_LOAD
from plantigrade.analyze.trial import Trial, analyse
from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.kinematics.result import Fit
from plantigrade.motion.filters import runs

END_DURATION = 0.15  # length of the ends of a recording [s]
AFTER_LANDING = 0.04  # time from a landing to a cut [s]
MIN_DURATION = 0.8  # shortest part of a cut recording [s]
MAX_CUTS = 10  # most cuts of one recording
PHASES = ("single support", "double support", f"first and last {END_DURATION:g} s")
ERROR_PREFIX = "vertical force, RMSE, "
COVERAGE_PREFIX = "vertical force in the 90 % band, "


def phase_rows(name: str, trial: Trial, mass: float) -> list[Row]:
    """Return error and coverage of the vertical force of a walk in each phase.

    Args:
        name: Of the recording.
        trial: The walk, its plates withheld.
        mass: Body mass [kg].
    """
    found: dict[str, list[np.ndarray]] = {phase: [] for phase in PHASES}
    whole = np.arange(len(trial.fit.time))
    for phase, values in _errors(trial, trial, whole, (True, True)):
        found[phase].append(values)
    for frames in cuts(trial):
        cut = analyse(part(trial.fit, frames), mass=mass)
        if cut.ground is None:
            continue
        ends = bool(frames[0] > 0), bool(frames[-1] < len(whole) - 1)
        for phase, values in _errors(cut, trial, frames, ends):
            if phase == PHASES[2]:
                found[phase].append(values)
    rows = []
    for phase, parts in found.items():
        off = np.concatenate(parts) if parts else np.empty((0, 2))
        if len(off):
            inside = 100.0 * float(np.mean(np.abs(off[:, 0]) <= off[:, 1]))
            rows.append(
                Row(name, ERROR_PREFIX + phase, float(np.sqrt(np.mean(off[:, 0] ** 2))), "BW")
            )
            rows.append(Row(name, COVERAGE_PREFIX + phase, inside, "%"))
    return rows


def cuts(trial: Trial) -> list[Array]:
    """Return the frames of parts of a walk that end or begin where plates measured the load."""
    assert trial.measured is not None
    time, load, known = trial.fit.time, *_measured(trial)
    at: list[int] = []
    both = np.asarray((load > STANCE_LOAD).all(axis=1) & known.all(axis=1))
    for run in runs(both):
        at.append((run.start + run.stop) // 2)
    for k in range(len(SIDES)):
        landed = [run.start for run in runs(np.asarray((load[:, k] > STANCE_LOAD) & known[:, k]))]
        at += [int(np.searchsorted(time, time[i] + AFTER_LANDING)) for i in landed if i > 0]
    found, frames = [], np.arange(len(time))
    for i in sorted(at):
        if i < len(time) and time[i] - time[0] >= MIN_DURATION:
            found.append(frames[: i + 1])
        if i < len(time) and time[-1] - time[i] >= MIN_DURATION:
            found.append(frames[i:])
    return found[:: max(1, -(-len(found) // MAX_CUTS))]


def part(fit: Fit, frames: Array) -> Fit:
    """Return a fit of some frames only, without plates."""
    markers = fit.markers
    if markers is not None:
        markers = replace(markers, time=markers.time[frames], positions=markers.positions[frames])
    return replace(
        fit,
        time=fit.time[frames],
        qpos=fit.qpos[frames],
        markers=markers,
        residual=None if fit.residual is None else fit.residual[frames],
        kept=None if fit.kept is None else fit.kept[frames],
        recording=replace(fit.recording, plates=()),
    )


def _measured(trial: Trial) -> tuple[Array, Array]:
    """Return the load of each foot on plates [BW], and where it was measured, (n, 2)."""
    assert trial.measured is not None
    feet = [trial.measured.foot(side) for side in SIDES]
    load = np.stack([foot.force[:, 2] for foot in feet], axis=1) / trial.measured.weight
    return load, np.stack([foot.measured for foot in feet], axis=1)


def _errors(
    found: Trial, true: Trial, frames: Array, ends: tuple[bool, bool]
) -> Iterator[tuple[str, Array]]:
    """Yield phase by phase the vertical errors and half-widths of their bands (m, 2) [BW]."""
    assert found.ground is not None
    load, known = (values[frames] for values in _measured(true))
    time, weight = true.fit.time[frames], found.record().weight
    off = found.ground.forces.force[..., 2] / weight - load
    pairs = np.stack([off, found.ground.force_band[..., 2] / weight], axis=-1)
    near = np.zeros(len(time), bool)
    for end, at in zip(ends, (time[0], time[-1]), strict=True):
        near |= end & (np.abs(time - at) < END_DURATION)
    both = (load > STANCE_LOAD).all(axis=1)
    for phase, here in zip(PHASES, (~both & ~near, both & ~near, near), strict=True):
        yield phase, pairs[here[:, None] & known & (load > STANCE_LOAD)]

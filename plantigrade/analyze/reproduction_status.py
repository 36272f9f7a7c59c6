"""Status and figures of a reproduced gait, with and without forces."""

from typing import Any

import numpy as np

from plantigrade.analyze.gait_forces import compare_forces
from plantigrade.analyze.reproduction import ROTATIONS, Comparison, phases_of
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.record import Record

MAX_ERRORS = {
    "com_error_max_mm": 50.0,
    "rom_error_mean_deg": 8.0,
    "rom_error_max_deg": 20.0,
    "contact_drift_max_mm": 20.0,
    "sole_lowest_mm": -10.0,
}
"""Maximum errors of a reproduced gait: centre of mass, ranges of motion (mean and worst rotation of
the legs), slip of the soles and their penetration of the ground."""
FORCE_LIMITS = {"force_residual_rms_bw": 0.10, "equations_residual_max_bw": 1e-6}
"""Maximum differences of forces from the estimated ones, and from those that the motion
requires."""
PELVIS_LIMIT = 0.30  # [m] maximum distance of the pelvis from the recorded one
MAX_FORCED_COM_ERROR = 0.15
"""Error of the centre of mass above which a body moved by forces has fallen [m]."""

LEGS = tuple(name for _, name in ROTATIONS)
UNITS = {"mm": " mm", "deg": "°", "bw": " body weights"}
ADVICE = "; the report's “Residual of each level” shows which task gave way first"


def run_status(motion: str, forces: str = "ok", recording: str = "ok") -> str:
    """Return ``"ok"``, or the failures of each part of a run and of the recording it shows."""
    parts = {
        "recording": recording,
        "gait computed without forces": motion,
        "gait computed with forces": forces,
    }
    return (
        "; ".join(f"{part}: {status}" for part, status in parts.items() if status != "ok") or "ok"
    )


def gait_status(record: Record, comparison: Comparison) -> str:
    """Return ``"ok"``, or failures of a reproduced gait with location and time."""
    time = record.motion.time
    stopped = str(record.signals.get("stopped", ""))
    if stopped:
        return f"the motion ended early, {when(record, time[-1])}: {stopped}{ADVICE}"
    com_error, most = comparison.com_error, 1e-3 * MAX_ERRORS["com_error_max_mm"]
    if com_error.max() > most:
        first = time[np.argmax(com_error > most)]
        return (
            f"the centre of mass left its path by more than {100 * most:.0f} cm, "
            f"{when(record, first)} (at most {100 * com_error.max():.0f} cm off){ADVICE}"
        )
    recorded = record.references["recorded"].at(time)
    off = np.linalg.norm(record.motion.qpos[:, :3] - recorded.qpos[:, :3], axis=1)
    if off.max() > PELVIS_LIMIT:
        first = time[np.argmax(off > PELVIS_LIMIT)]
        return (
            f"the pelvis deviated by more than {100 * PELVIS_LIMIT:.0f} cm from the recorded one, "
            f"{when(record, first)}{ADVICE}"
        )
    return limits_exceeded(record, comparison, MAX_ERRORS) or "ok"


def forces_status(forced: Record, comparison: Comparison) -> str:
    """Return ``"ok"``, or failures of a gait moved by forces."""
    time = forced.motion.time
    stopped = str(forced.signals.get("stopped", ""))
    if stopped:
        return f"it ended early, {when(forced, time[-1])}: {stopped}"
    if comparison.com_error.max() > MAX_FORCED_COM_ERROR:
        first = time[np.argmax(comparison.com_error > MAX_FORCED_COM_ERROR)]
        return (
            f"the body fell: its centre of mass was more than {100 * MAX_FORCED_COM_ERROR:.0f} cm "
            f"off its path, {when(forced, first)}"
        )
    return limits_exceeded(forced, comparison, MAX_ERRORS | FORCE_LIMITS) or "ok"


def limits_exceeded(record: Record, comparison: Comparison, limits: dict[str, float]) -> str:
    """Return a description of figures beyond their limits; empty if there are none."""
    figures = comparison.metrics()
    if record.qfrc_actuator is not None:
        figures |= force_residuals(record)
    found = []
    for key, limit in limits.items():
        value = figures.get(key, 0.0)
        if not value * np.sign(limit) > abs(limit):
            continue
        allowed = f"{limit:g}{UNITS[key.rpartition('_')[2]]}"
        bound = "at least" if limit < 0 else "at most"
        found.append(f"{_describe(key, value, record, comparison)} ({bound} {allowed} allowed)")
    return "; ".join(found)


def _describe(key: str, value: float, record: Record, comparison: Comparison) -> str:
    """Return a description of one figure, with location and time of its worst value."""
    time = record.motion.time
    if key == "com_error_max_mm":
        instant = when(record, time[np.argmax(comparison.com_error)])
        return f"the centre of mass is {value:.0f} mm off its path, {instant}"
    if key == "rom_error_mean_deg":
        return f"the ranges of motion of the legs are {value:.1f}° off on average over the strides"
    if key == "rmse_max_deg":
        worst = max(
            (name for name in LEGS if name in comparison.rmse), key=lambda n: comparison.rmse[n]
        )
        instant = when(record, time[np.argmax(_deviation(record, worst))])
        return f"{worst} is {value:.1f}° (RMS) from the recorded one, furthest apart {instant}"
    if key == "rom_error_max_deg":
        errors = {name: x for name, x in comparison.rom_error.items() if name in LEGS}
        worst = max(errors, key=lambda name: abs(errors[name]))
        ours, theirs = comparison.rom[worst]
        instant = when(record, time[np.argmax(_deviation(record, worst))])
        return (
            f"the range of motion of {worst} is {value:.1f}° off ({ours:.0f}° for {theirs:.0f}° "
            f"recorded, furthest apart {instant})"
        )
    if key == "contact_drift_max_mm":
        site, instant = comparison.contact_drift_at
        return f"the sole slides by {value:.0f} mm at {site}, {when(record, instant)}"
    if key == "sole_lowest_mm":
        tick, k = np.unravel_index(np.argmin(comparison.soles), comparison.soles.shape)
        foot = SIDE_NAMES[SIDES[int(k)]]
        return f"the {foot} sole is at {value:.0f} mm, in the ground, {when(record, time[tick])}"
    if key == "force_residual_rms_bw":
        deviation = _force_residual(record)
        tick, k = np.unravel_index(np.nanargmax(deviation), deviation.shape)
        return (
            f"the ground reactions are {value:.2f} body weights (RMS) from the estimated ones, "
            f"most at the {SIDE_NAMES[SIDES[int(k)]]} foot, {when(record, time[tick])}"
        )
    assert record.qfrc_actuator is not None
    instant = when(record, time[np.argmax(np.abs(record.qfrc_actuator[:, :3]).max(axis=1))])
    return f"forces and motion disagree by {value:.1g} body weights, {instant}"


def _deviation(record: Record, name: str) -> Float[Array, " n"]:
    """Return the mean-free deviation of a coordinate from the recorded one at each tick [rad]."""
    ours = record.motion[name]
    deviation = ours - record.references["recorded"].at(record.motion.time)[name]
    return np.abs(deviation - deviation.mean())


def limit_of(key: str) -> str:
    """Return the name of a figure's limit, with ``_limit`` before the unit."""
    stem, _, unit = key.rpartition("_")
    return f"{stem}_limit_{unit}"


def force_residuals(forced: Record) -> dict[str, float]:
    """Return differences of forces from the estimated ones and from the equations of motion."""
    assert forced.qfrc_actuator is not None
    found = {
        "equations_residual_max_bw": float(
            np.abs(forced.qfrc_actuator[:, :3]).max() / forced.weight
        )
    }
    if "estimated.force" in forced.signals:
        found["force_residual_rms_bw"] = float(np.sqrt(np.nanmean(_force_residual(forced) ** 2)))
    return found


def _force_residual(forced: Record) -> Float[Array, "n 2"]:
    """Return the difference between force and estimated force on each foot [body weights].

    It is NaN where neither foot is loaded.
    """
    estimated = forced.signals["estimated.force"]
    force = np.stack([forced.foot(side).force for side in SIDES], axis=1)
    deviation = np.linalg.norm(force - estimated, axis=2) / forced.weight
    return np.where((force[..., 2] > 0) | (estimated[..., 2] > 0), deviation, np.nan)


def when(record: Record, time: float) -> str:
    """Return a description of an instant."""
    words = f"{time:.2f} s into the recording"
    for phase in phases_of(record):
        if phase.start <= time <= phase.stop:
            what = "in double support before the" if phase.kind == "double" else "while the"
            return f"{words}, {what} {SIDE_NAMES[phase.swing]} foot swings"
    return words


def gait_figures(record: Record, comparison: Comparison) -> dict[str, Any]:
    """Return the figures of a reproduced gait."""
    time, signals = record.motion.time, record.signals
    return {
        "motion_status": gait_status(record, comparison),
        "task_order": [str(name) for name in signals["tasks.names"]],
        "reproduced_from_s": float(time[0]),
        "reproduced_to_s": float(time[-1]),
        "cycles_count": len(comparison.cycles),
        **comparison.metrics(),
        **{limit_of(key): limit for key, limit in MAX_ERRORS.items()},
        "step_s": float(time[1] - time[0]),
        "ticks_exact_pct": 100.0 * float(np.mean(signals["exact"])),
    }


def force_figures(
    forced: Record,
    comparison: Comparison,
    measured: Record | None = None,
    ground: Float[Array, "n_frames 3"] | None = None,
) -> dict[str, Any]:
    """Return the figures of a gait moved by forces, with a comparison to measured forces if known.

    Args:
        comparison: The same against the recorded one.
        measured: The fitted recording with its measured forces.
        ground: Path of a treadmill's belt [m]; at rest if absent.
    """
    status, against = forces_status(forced, comparison), comparison.metrics()
    found: dict[str, Any] = {
        "dynamics_status": status,
        **force_residuals(forced),
        **{limit_of(key): limit for key, limit in FORCE_LIMITS.items()},
        **{f"dynamics_{key}": against[key] for key in MAX_ERRORS if key in against},
        **{f"dynamics_{limit_of(key)}": limit for key, limit in MAX_ERRORS.items()},
    }
    if measured is None or status != "ok":
        return found
    compared = compare_forces(forced, measured, ground=ground).metrics()
    return found | {
        k: v for k, v in compared.items() if np.isfinite(v) and not k.startswith("forced")
    }

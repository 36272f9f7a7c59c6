"""Whether a reproduced gait succeeded, and its figures."""

from typing import Any

import numpy as np

from plantigrade.analyze.gait_forces import compare_forces
from plantigrade.analyze.reproduction import Comparison, phases_of
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.record import Record

LIMITS = {
    "com_error_max_mm": 50.0,
    "rom_error_mean_deg": 8.0,
    "rom_error_max_deg": 20.0,
    "contact_drift_max_mm": 20.0,
    "sole_lowest_mm": -10.0,
}
"""How far a reproduced gait may be off: its centre of mass, its ranges of motion (mean and worst
single rotation of the legs), the soles along the ground and into it."""
FORCE_LIMITS = {"force_residual_rms_bw": 0.10, "equations_residual_max_bw": 1e-6}
"""How far forces may be from the estimated ones, and from those that their motion needs."""
PELVIS_LIMIT = 0.30
"""A pelvis further from the recorded one has wandered off [m]."""
FALLEN = 0.15
"""A body moved by forces whose centre of mass is further off has fallen [m]."""

WORDS = {
    "com_error_max_mm": "the centre of mass is {:.0f} mm off its path",
    "rom_error_mean_deg": "the ranges of motion are {:.0f}° off on average",
    "rom_error_max_deg": "the range of motion of one rotation is {:.0f}° off",
    "contact_drift_max_mm": "a sole slides by {:.0f} mm",
    "sole_lowest_mm": "a sole is at {:.0f} mm, in the ground",
    "force_residual_rms_bw": "the ground reactions are {:.2f} body weights from the estimated ones",
    "equations_residual_max_bw": "forces and motion disagree by {:.1g} body weights",
}
LOOK = "; the report's “Residual of each level” shows which task gave way first"


def gait_status(record: Record, held: Comparison) -> str:
    """Return ``"ok"``, or what went wrong with a reproduced gait, where and when."""
    time = record.motion.time
    stopped = str(record.signals.get("stopped", ""))
    if stopped:
        return f"the motion ended early, {when(record, time[-1])}: {stopped}{LOOK}"
    away, most = held.com_error, 1e-3 * LIMITS["com_error_max_mm"]
    if away.max() > most:
        first = time[np.argmax(away > most)]
        return (
            f"the centre of mass left its path by more than {100 * most:.0f} cm, "
            f"{when(record, first)} (at most {100 * away.max():.0f} cm off){LOOK}"
        )
    recorded = record.references["recorded"].at(time)
    off = np.linalg.norm(record.motion.qpos[:, :3] - recorded.qpos[:, :3], axis=1)
    if off.max() > PELVIS_LIMIT:
        first = time[np.argmax(off > PELVIS_LIMIT)]
        return (
            f"the pelvis wandered more than {100 * PELVIS_LIMIT:.0f} cm from the recorded one, "
            f"{when(record, first)}{LOOK}"
        )
    return beyond(held.metrics(), LIMITS) or "ok"


def forces_status(forced: Record, held: Comparison) -> str:
    """Return ``"ok"``, or how a gait moved by forces was lost, or what of it is too far off."""
    time = forced.motion.time
    stopped = str(forced.signals.get("stopped", ""))
    if stopped:
        return f"it ended early, {when(forced, time[-1])}: {stopped}"
    if held.com_error.max() > FALLEN:
        first = time[np.argmax(held.com_error > FALLEN)]
        return (
            f"the body fell: its centre of mass was more than {100 * FALLEN:.0f} cm off its path, "
            f"{when(forced, first)}"
        )
    return beyond(held.metrics() | force_residuals(forced), LIMITS | FORCE_LIMITS) or "ok"


def beyond(figures: dict[str, Any], limits: dict[str, float]) -> str:
    """Return what is beyond its limit, in words; empty where nothing is."""
    said = [
        f"{WORDS[key].format(figures[key])} (allowed are {limit:g})"
        for key, limit in limits.items()
        if key in figures and not abs(figures[key]) <= abs(limit) and figures[key] * limit > 0
    ]
    return "; ".join(said)


def limit_of(key: str) -> str:
    """Return the name of a figure's limit: ``_limit`` stands before the unit."""
    stem, _, unit = key.rpartition("_")
    return f"{stem}_limit_{unit}"


def force_residuals(forced: Record) -> dict[str, float]:
    """Return how far forces are from the estimated ones, and from the motion that they move."""
    assert forced.qfrc_actuator is not None
    found = {
        "equations_residual_max_bw": float(
            np.abs(forced.qfrc_actuator[:, :3]).max() / forced.weight
        )
    }
    wanted = forced.signals.get("estimated.force")
    if wanted is not None:
        force = np.stack([forced.foot(side).force for side in SIDES], axis=1)
        apart = np.linalg.norm(force - wanted, axis=2)[(force[..., 2] > 0) | (wanted[..., 2] > 0)]
        found["force_residual_rms_bw"] = float(np.sqrt(np.mean(apart**2)) / forced.weight)
    return found


def when(record: Record, time: float) -> str:
    """Return an instant in words."""
    words = f"{time:.2f} s into the recording"
    for phase in phases_of(record):
        if phase.start <= time <= phase.stop:
            side = {"r": "right", "l": "left"}[phase.swing]
            what = "in double support before the" if phase.kind == "double" else "while the"
            return f"{words}, {what} {side} foot swings"
    return words


def gait_figures(record: Record, held: Comparison) -> dict[str, Any]:
    """Return the figures of a reproduced gait."""
    time, signals = record.motion.time, record.signals
    return {
        "task_order": [str(name) for name in signals["tasks.names"]],
        "reproduced_from_s": float(time[0]),
        "reproduced_to_s": float(time[-1]),
        "cycles_count": len(held.cycles),
        **held.metrics(),
        **{limit_of(key): limit for key, limit in LIMITS.items()},
        "step_s": float(time[1] - time[0]),
        "ticks_exact_pct": 100.0 * float(np.mean(signals["exact"])),
    }


def force_figures(
    forced: Record,
    held: Comparison,
    measured: Record | None = None,
    ground: Float[Array, "n_frames 3"] | None = None,
) -> dict[str, Any]:
    """Return the figures of a gait moved by forces, beside the measured forces where known.

    Args:
        forced: The gait moved by forces.
        held: The same against the recorded one.
        measured: The fitted recording with its measured forces.
        ground: Path of the ground itself, a treadmill's belt [m]; at rest if absent.
    """
    status, against = forces_status(forced, held), held.metrics()
    found: dict[str, Any] = {
        "dynamics_status": status,
        **force_residuals(forced),
        **{limit_of(key): limit for key, limit in FORCE_LIMITS.items()},
        **{f"dynamics_{key}": against[key] for key in LIMITS if key in against},
        **{f"dynamics_{limit_of(key)}": limit for key, limit in LIMITS.items()},
    }
    if measured is None or status != "ok":
        return found
    beside = compare_forces(forced, measured, ground=ground).metrics()
    return found | {
        k: v for k, v in beside.items() if np.isfinite(v) and not k.startswith("forced")
    }

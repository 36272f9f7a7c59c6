"""Whether a reproduced gait succeeded, and its figures."""

from typing import Any

import numpy as np

from plantigrade.analyze.gait_forces import compare_forces
from plantigrade.analyze.reproduction import Comparison, phases_of
from plantigrade.arrays import Array, Float
from plantigrade.record import Record

COM_LIMIT = 0.05
"""A centre of mass further off its path is not on it [m]."""
PELVIS_LIMIT = 0.30
"""A pelvis further from the recorded one has wandered off [m]."""
FALLEN = 0.15
"""A body moved by forces whose centre of mass is further off has fallen [m]."""

LOOK = "; the report's “What each level missed” shows which task gave way first"
KEPT = (
    "rom_error_mean_deg", "rom_error_max_deg", "com_error_max_mm", "contact_drift_max_mm",
    "sole_lowest_mm",
)  # fmt: skip


def gait_status(record: Record, held: Comparison) -> str:
    """Return ``"ok"``, or what went wrong with a reproduced gait, where and when."""
    time = record.motion.time
    stopped = str(record.signals.get("stopped", ""))
    if stopped:
        return f"the motion ended early, {when(record, time[-1])}: {stopped}{LOOK}"
    away = held.com_error
    if away.max() > COM_LIMIT:
        first = time[np.argmax(away > COM_LIMIT)]
        return (
            f"the centre of mass left its path by more than {100 * COM_LIMIT:.0f} cm, "
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
    return "ok"


def forces_status(forced: Record, held: Comparison) -> str:
    """Return ``"ok"``, or when and how a gait moved by forces was lost."""
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
    return "ok"


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
    assert forced.qfrc_actuator is not None
    status, against = forces_status(forced, held), held.metrics()
    found: dict[str, Any] = {
        "dynamics_status": status,
        "equations_residual_max_bw": float(
            np.abs(forced.qfrc_actuator[:, :3]).max() / forced.weight
        ),
        **{f"dynamics_{key}": against[key] for key in KEPT if key in against},
    }
    if measured is None or status != "ok":
        return found
    beside = compare_forces(forced, measured, ground=ground).metrics()
    return found | {
        k: v for k, v in beside.items() if np.isfinite(v) and not k.startswith("forced")
    }

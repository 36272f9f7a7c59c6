"""Joints that stay at a limit of their range: a curve that is cut there is no measurement.

What a fit cannot reach, because a marker sits elsewhere or a limit is too narrow, ends in a joint
that lies at its stop. Its curve looks like any other, so it is said, and hatched in the plots.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool
from plantigrade.kinematics.posture import LIMIT_TOLERANCE
from plantigrade.motion.cycles import PERCENT, Cycle
from plantigrade.record import Record

OFTEN = 5.0
"""Share of the frames from which on it is said [%]."""


def at_limit(record: Record) -> dict[str, Bool[Array, " n_frames"]]:
    """Return, of each joint that is at a limit in more than :data:`OFTEN` of the frames, where.

    The limits are those that the motion had to keep to, else the person's; a joint without a range
    is left out.
    """
    limits = record.limits.coordinate
    low, high = record.human.limits if limits is None else limits
    q = record.motion.qpos[:, 7:]
    held = ((q <= low + LIMIT_TOLERANCE) | (q >= high - LIMIT_TOLERANCE)) & (
        high - low > 4 * LIMIT_TOLERANCE
    )
    shares = 100.0 * held.mean(axis=0)
    return {n: held[:, k] for k, n in enumerate(record.human.coordinates) if shares[k] > OFTEN}


def limit_figures(record: Record) -> dict[str, Any]:
    """Return ``joints_at_limit_pct``: joint → share of the frames at a limit [%], largest first."""
    shares = {name: 100.0 * float(held.mean()) for name, held in at_limit(record).items()}
    return {"joints_at_limit_pct": dict(sorted(shares.items(), key=lambda one: -one[1]))}


def limit_notes(record: Record) -> list[str]:
    """Return the sentence that names these joints; none where there are none."""
    shares = limit_figures(record)["joints_at_limit_pct"]
    if not shares:
        return []
    named = ", ".join(f"{name} ({share:.0f} %)" for name, share in shares.items())
    return [
        f"joints at a limit of their range in more than {OFTEN:.0f} % of the frames: {named}; "
        "their curves are clipped there, and hatched in the plots."
    ]


def cycles_at_limit(
    record: Record, cycles: Iterable[Cycle]
) -> dict[str, Bool[Array, " n_percent"]]:
    """Return, of each joint of :func:`at_limit`, where it is so in most gait cycles of its side.

    Those of joints of the middle are the right side's.
    """
    found, time, cycles = {}, record.motion.time, tuple(cycles)
    for name, held in at_limit(record).items():
        side = name[-1] if name[-2:] in ("_r", "_l") else "r"
        rows = [
            np.interp(c.start + (c.stop - c.start) * PERCENT / 100.0, time, held)
            for c in cycles
            if c.side == side
        ]
        if rows:
            found[name] = np.mean(rows, axis=0) >= 0.5
    return found

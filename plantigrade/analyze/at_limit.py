"""Joints at a limit of their range, where curves are clipped.

A misplaced marker or a range that is too narrow drives a joint of a fit to its limit. The clipped
part of the curve is reported, and hatched in the plots.
"""

from collections.abc import Iterable
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool
from plantigrade.kinematics.posture import LIMIT_TOLERANCE
from plantigrade.motion.cycles import PERCENT, Cycle
from plantigrade.record import Record
from plantigrade.side_names import split_side

MIN_SHARE = 5.0
"""Share of frames above which a joint is reported [%]."""


def at_limit(record: Record) -> dict[str, Bool[Array, " n_frames"]]:
    """Return the frames at a limit for joints with more than :data:`MIN_SHARE` of such frames.

    The limits are those of the record, or else of the person; joints without a range are excluded.
    """
    limits = record.limits.coordinate
    low, high = record.human.limits if limits is None else limits
    q = record.motion.qpos[:, 7:]
    limited = ((q <= low + LIMIT_TOLERANCE) | (q >= high - LIMIT_TOLERANCE)) & (
        high - low > 4 * LIMIT_TOLERANCE
    )
    shares = 100.0 * limited.mean(axis=0)
    return {
        n: limited[:, k] for k, n in enumerate(record.human.coordinates) if shares[k] > MIN_SHARE
    }


def limit_figures(record: Record) -> dict[str, Any]:
    """Return ``joints_at_limit_pct``: joint → share of frames at a limit [%], largest first."""
    shares = {name: 100.0 * float(limited.mean()) for name, limited in at_limit(record).items()}
    return {"joints_at_limit_pct": dict(sorted(shares.items(), key=lambda one: -one[1]))}


def limit_notes(record: Record) -> list[str]:
    """Return a sentence that names these joints; none if there are none."""
    shares = limit_figures(record)["joints_at_limit_pct"]
    if not shares:
        return []
    named = ", ".join(f"{name} ({share:.0f} %)" for name, share in shares.items())
    return [
        f"joints at a limit of their range in more than {MIN_SHARE:.0f} % of the frames: {named}; "
        "their curves are clipped there, and hatched in the plots."
    ]


def cycles_at_limit(
    record: Record, cycles: Iterable[Cycle]
) -> dict[str, Bool[Array, " n_percent"]]:
    """Return the percentages at which joints of :func:`at_limit` are so in most gait cycles.

    Joints without a side use the cycles of the right side.
    """
    found, time, cycles = {}, record.motion.time, tuple(cycles)
    for name, limited in at_limit(record).items():
        side = split_side(name)[1] or "r"
        rows = [
            np.interp(c.start + (c.stop - c.start) * PERCENT / 100.0, time, limited)
            for c in cycles
            if c.side == side
        ]
        if rows:
            found[name] = np.mean(rows, axis=0) >= 0.5
    return found

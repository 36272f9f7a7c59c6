"""Joints at a limit of their range, where curves are clipped, and motions beyond people.

A misplaced marker or a range that is too narrow drives a joint of a fit to its limit. The clipped
part of the curve is reported, and hatched in the plots.
"""

from collections.abc import Iterable
from itertools import pairwise
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool
from plantigrade.kinematics.posture import LIMIT_TOLERANCE, leans
from plantigrade.motion.cycles import PERCENT, Cycle
from plantigrade.motion.event_timing import is_running
from plantigrade.record import Record
from plantigrade.side_names import split_side

MAX_CADENCE = 250.0
"""Cadence that only sprinters exceed [steps/min]; distance runners take up to 220. Estimate."""
LANDING_TOGETHER = 0.05
"""Time between the landings of two feet below which they end a jump [s]. Chosen: a fifth of a step
at that cadence."""
MAX_JOINT_POWER = 40.0
"""Power of a joint above that of people [W/kg]: an *estimate* above hips and knees in sprinting at
9 m/s, which come nearest [Schache2011]_."""
MAX_WALKING_LEAN = 20.0
"""Lean of the trunk from the vertical above which nobody walks without need [deg]; healthy adults
lean by 1 to 3° [Chung2010]_, on stairs and slopes by more (*estimate*)."""
MAX_STRENGTH_USE = 1.02  # [1] torque relative to a person's strength, with the check's tolerance
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


def motion_notes(record: Record) -> list[str]:
    """Return warnings about a computed motion that is physical and still beyond people.

    They concern cadence, joint power, joint strength, and the lean of the trunk in walking.
    """
    motion, human, notes = record.motion, record.human, []
    strikes = sorted(e.time for e in motion.events if e.kind == "heel_strike")
    strikes = [b for a, b in pairwise([-np.inf, *strikes]) if b - a > LANDING_TOGETHER]
    if len(strikes) > 1:
        cadence = 60.0 * (len(strikes) - 1) / (strikes[-1] - strikes[0])
        if cadence > MAX_CADENCE:
            notes.append(
                f"the cadence is {cadence:.0f} steps/min; only sprinters take more than "
                f"{MAX_CADENCE:.0f}: take longer steps or a lower speed."
            )
        lean = np.abs(leans(human, motion.qpos, "c7"))
        way = ("forward or backward", "sideways")[int(np.argmax(lean.max(axis=0)))]
        if lean.max() > MAX_WALKING_LEAN and not is_running(motion.events):
            notes.append(
                f"the trunk leans {lean.max():.0f}° {way} in walking; healthy people lean by less "
                f"than {MAX_WALKING_LEAN:.0f}°: check the strength, the speed and the loads."
            )
    if record.qfrc_actuator is None:
        return notes
    tau = np.nan_to_num((record.qfrc_actuator - record.device_torque)[:, 6:])
    power = np.abs(tau * motion.qvel[:, 6:]).max(axis=0, initial=0.0) / human.mass
    k = int(np.argmax(power))
    if power[k] > MAX_JOINT_POWER:
        notes.append(
            f"{human.coordinates[k]} works at {power[k]:.0f} W/kg; no joint of a person exceeds "
            f"{MAX_JOINT_POWER:.0f} W/kg: give the motion more time, or reduce speed or height."
        )
    low, high = human.model.jnt_actfrcrange[1:].T
    with np.errstate(divide="ignore", invalid="ignore"):
        use = np.nan_to_num(np.where(tau > 0, tau / high, tau / low), posinf=0.0, neginf=0.0)
    k = int(np.argmax(use.max(axis=0)))
    if use[:, k].max() > MAX_STRENGTH_USE:
        notes.append(
            f"{human.coordinates[k]} needs {100.0 * use[:, k].max():.0f} % of this person's "
            "strength; the task allows more than the person has."
        )
    return notes

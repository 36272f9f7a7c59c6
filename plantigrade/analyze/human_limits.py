"""Limits of people that a computed motion may exceed although it obeys physics.

A fit is judged by :mod:`plantigrade.analyze.plausibility`.
"""

from itertools import pairwise

import numpy as np

from plantigrade.kinematics.posture import leans
from plantigrade.motion.event_timing import is_running
from plantigrade.record import Record

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

"""Intervals in which feet or a seat can carry load, for the estimate of ground forces."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.kinematics.contacts import stances
from plantigrade.motion.motion import Motion

EARLY_LOAD = 0.010  # [s] time before the detected heel strike at which load may begin
LATE_LOAD = 0.015  # [s] time after the detected toe-off at which load may end
USUAL_STANCE = 0.65  # [s] duration of a stance if none is complete in the recording
# [1] duration of a double support relative to a stance, 11 and 61 % of a gait cycle, including
# EARLY_LOAD and LATE_LOAD
DOUBLE_SUPPORT_RATIO = 0.21


@dataclass(frozen=True)
class Support:
    """A support other than the feet, such as the seat of a chair."""

    name: str  #: Name of the support
    body: str  #: Supported segment
    #: Middle of the contact in that segment's frame [m]
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    #: Maximum distance of the centre of pressure from there, forward or backward and to either side
    #: [m]
    reach: tuple[float, float] = (0.15, 0.15)


def walking_intervals(
    motion: Motion, *, early: float = EARLY_LOAD, late: float = LATE_LOAD
) -> tuple[ContactInterval, ...]:
    """Return the stances of a gait from its events, slightly extended at both ends.

    A foot without events stands throughout, flat.

    Args:
        motion: The motion with its events.
        early: Extension before heel strike [s].
        late: Extension after toe-off [s].
    """
    first, last = float(motion.time[0]), float(motion.time[-1])
    events = sorted(motion.events, key=lambda e: e.time)
    found = []
    for side in SIDES:
        if not any(event.side == side for event in events):
            found.append(ContactInterval(side, "sole", first, last, False, False))
            continue
        for each in stances(events, side, first, last):
            begins, ends = bool(each.start > first), bool(each.stop < last)
            start = each.start - early if begins else each.start
            stop = each.stop + late if ends else each.stop
            found.append(ContactInterval(side, "foot", start, stop, begins, ends))
    return tuple(found)


def usual_length(intervals: tuple[ContactInterval, ...]) -> float:
    """Return the median duration of the complete contacts [s]."""
    whole = [c.stop - c.start for c in intervals if c.whole]
    return float(np.median(whole)) if whole else USUAL_STANCE


def completed(
    intervals: tuple[ContactInterval, ...], first: float, last: float
) -> tuple[ContactInterval, ...]:
    """Return stances cut by the recording in double support with their estimated ends.

    A foot that still stands after the other has landed leaves after the median double support of
    this recording, or after a usual one if there is none; correspondingly at the start. These
    instants lie outside the recording.

    Args:
        first: Start of the recording [s].
        last: End of the recording [s].
    """
    steps = [c for c in intervals if c.rolls]
    pairs = [(a, b) for a in steps for b in steps if a.side != b.side and b.begins and a.ends]
    seen = [a.stop - b.start for a, b in pairs if a.start < b.start < a.stop < b.stop]
    length = float(np.median(seen)) if seen else DOUBLE_SUPPORT_RATIO * usual_length(intervals)
    found = []
    for each in intervals:
        others = [c for c in steps if each in steps and c.side != each.side]
        landed = [c.start for c in others if c.begins and each.start < c.start and not c.ends]
        left = [c.stop for c in others if c.ends and c.stop < each.stop and not c.begins]
        if not each.ends and landed:
            each = replace(each, stop=max(landed[-1] + length, last), ends=True)
        if not each.begins and left:
            each = replace(each, start=min(left[0] - length, first), begins=True)
        found.append(each)
    return tuple(found)

"""Intervals in which feet or a seat can carry load, for the estimate of ground forces."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.kinematics.contacts import stances
from plantigrade.motion.motion import Motion

EARLY, LATE = 0.010, 0.015  # a load that begins and ends smoothly is not noticed at once [s]
USUAL_STANCE = 0.65  # where none was seen whole [s]
# Length of a double support over that of a stance: 11 and 61 % of a gait cycle, with EARLY and LATE
USUAL_HAND_OVER = 0.21


@dataclass(frozen=True)
class Support:
    """Something besides the feet that may carry load, such as the seat of a chair.

    Attributes:
        name: Its name.
        body: Segment that it carries.
        point: Middle of the contact in that segment's frame [m].
        reach: How far from there the centre of pressure may lie, forward or backward and to
            either side [m].
    """

    name: str
    body: str
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    reach: tuple[float, float] = (0.15, 0.15)


def walking_intervals(
    motion: Motion, *, early: float = EARLY, late: float = LATE
) -> tuple[ContactInterval, ...]:
    """Return the stances of a gait by its events, a little longer at both ends.

    A foot without any event is taken to stand all the time, not rolling.

    Args:
        motion: The motion with its events.
        early: By how much they begin before heel strike [s].
        late: By how much they end after toe off [s].
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
    """Return how long the contacts that were seen whole last, their median [s]."""
    whole = [c.stop - c.start for c in intervals if c.whole]
    return float(np.median(whole)) if whole else USUAL_STANCE


def completed(
    intervals: tuple[ContactInterval, ...], first: float, last: float
) -> tuple[ContactInterval, ...]:
    """Return the stances that a recording cuts in double support, with their likely other ends.

    A foot that still stands when the other has landed leaves after a double support of the median
    length of this recording, or of a usual length if none was seen; correspondingly at the start.
    Those instants lie outside the recording.

    Args:
        intervals: Contacts.
        first: Start of the recording [s].
        last: Its end [s].
    """
    steps = [c for c in intervals if c.rolls]
    pairs = [(a, b) for a in steps for b in steps if a.side != b.side and b.begins and a.ends]
    seen = [a.stop - b.start for a, b in pairs if a.start < b.start < a.stop < b.stop]
    length = float(np.median(seen)) if seen else USUAL_HAND_OVER * usual_length(intervals)
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

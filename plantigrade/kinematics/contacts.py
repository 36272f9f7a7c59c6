"""Contact intervals of each region of each foot, from gait events and sole rests."""

from collections.abc import Sequence
from itertools import pairwise

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.kinematics.sole_rests import ContactFrames
from plantigrade.motion import GaitEvent

# [1] share of a stance with contact of each region if the recording does not show it; typical of
# walks that do. (A heel that begins to rise is too slow for detection.)
USUAL_CONTACT = {"heel": (0.0, 0.75), "ball": (0.15, 0.95), "toes": (0.15, 1.0)}


def foot_contacts(
    time: Float[Array, " n_frames"], events: Sequence[GaitEvent], rests: Sequence[ContactFrames]
) -> tuple[ContactInterval, ...]:
    """Return the contact intervals of each region, its rests within the stances of its foot.

    The heel is in contact from heel strike and the toes until toe-off regardless of speed; a region
    without detected rest has the usual shares of the stance.
    """
    contacts, touching = [], [rest.interval(time) for rest in rests]
    for side in SIDES:
        for stance in stances(events, side, time[0], time[-1]):
            start, stop = stance.start, stance.stop
            for region, share in USUAL_CONTACT.items():
                resting = [
                    c
                    for c in touching
                    if c.side == side and c.region == region and c.start < stop and c.stop > start
                ]
                if resting:
                    first, last = min(c.start for c in resting), max(c.stop for c in resting)
                elif stance.whole:
                    first, last = (start + s * (stop - start) for s in share)
                else:
                    continue
                if region == "heel" and start > time[0]:
                    first = start
                if region == "toes":
                    last = stop
                contacts.append(ContactInterval(side, region, max(first, start), min(last, stop)))
    return tuple(c for c in contacts if c.stop > c.start)


def stances(
    events: Sequence[GaitEvent], side: str, first: float, last: float
) -> list[ContactInterval]:
    """Return the stances of a foot.

    The recording lasts from ``first`` to ``last`` [s]; the events are ordered by time.
    """
    own = [(e.kind, e.time) for e in events if e.side == side]
    whole = [(a, b) for a, b in pairwise(own) if (a[0], b[0]) == ("heel_strike", "toe_off")]
    found = [ContactInterval(side, "foot", strike[1], off[1]) for strike, off in whole]
    if own and own[0][0] == "toe_off":
        found.insert(0, ContactInterval(side, "foot", first, own[0][1], begins=False))
    if own and own[-1][0] == "heel_strike":
        found.append(ContactInterval(side, "foot", own[-1][1], last, ends=False))
    return found

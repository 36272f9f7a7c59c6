"""When each part of each foot touches the ground, from gait events and from what rests."""

from collections.abc import Sequence
from itertools import pairwise

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.kinematics.rests import ContactFrames
from plantigrade.motion import GaitEvent

# Share of a stance during which each region rests, where a recording does not show it: about what
# walks that do show it have. (A heel that has begun to rise still moves too slowly to be noticed.)
USUAL = {"heel": (0.0, 0.75), "ball": (0.15, 0.95), "toes": (0.15, 1.0)}


def foot_contacts(
    time: Float[Array, " n_frames"], events: Sequence[GaitEvent], rests: Sequence[ContactFrames]
) -> tuple[ContactInterval, ...]:
    """Return when each region touches: its rests within the stances of its foot.

    The heel touches from heel strike on and the toes up to toe off, whatever their speed; where a
    region is not seen to rest, the usual shares of the stance are taken.
    """
    contacts, touching = [], [rest.interval(time) for rest in rests]
    for side in SIDES:
        for stance in stances(events, side, time[0], time[-1]):
            start, stop = stance.start, stance.stop
            for region, share in USUAL.items():
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

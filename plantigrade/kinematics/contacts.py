"""Contact intervals of each region of each foot, from gait events and sole rests; foot flat."""

from collections.abc import Iterable, Sequence
from itertools import pairwise

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.intervals import ContactInterval
from plantigrade.kinematics.sole_rests import ContactFrames
from plantigrade.motion import GaitEvent
from plantigrade.motion.filters import crossing

DOWN_HEIGHT = 0.004
"""Height of the forefoot above its level in midstance at foot flat [m]; 1.5° of pitch."""
MID_STANCE = 0.15, 0.30
"""Interval after heel strike in which the foot is flat, which defines the forefoot's level [s]."""
MAX_TIME = 0.25  # [s] maximum time from heel strike to foot flat
START_TOLERANCE = 0.02
"""Maximum time from a heel strike to the start of a motion that still includes it [s]."""
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


def foot_flat_time(
    time: Float[Array, " n"], forefoot: Float[Array, " n"], strikes: Iterable[float]
) -> float:
    """Return the mean time from heel strike to contact of ball and toes [s].

    Args:
        time: Time of each frame [s].
        forefoot: Height of the lowest point of ball and toes [m].
        strikes: Heel strikes of that foot [s].

    Returns:
        Mean time; NaN without a stance from heel strike to midstance, 0 for a flat landing.
    """
    found = []
    for strike in strikes:
        flat = (time >= strike + MID_STANCE[0]) & (time <= strike + MID_STANCE[1])
        if (
            time[0] > strike + START_TOLERANCE
            or time[-1] < strike + MID_STANCE[1]
            or not flat.any()
        ):
            continue
        above = forefoot - float(np.median(forefoot[flat])) - DOWN_HEIGHT
        down = np.flatnonzero((time >= strike) & (time <= strike + MAX_TIME) & (above <= 0.0))
        if len(down):
            k = int(down[0])
            lands = k > 0 and above[k - 1] > 0.0
            instant = crossing(time, above, k - 1, 0.0) if lands else float(time[k])
            found.append(max(instant - strike, 0.0))
    return float(np.mean(found)) if found else float("nan")

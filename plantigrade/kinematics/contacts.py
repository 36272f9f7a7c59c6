"""When each part of each foot touches the ground, from gait events and from what rests."""

from collections.abc import Sequence
from dataclasses import dataclass

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.rests import Rest
from plantigrade.motion import GaitEvent

# Share of a stance during which each region rests, where a recording does not show it: about what
# walks that do show it have. (A heel that has begun to rise still moves too slowly to be noticed.)
USUAL = {"heel": (0.0, 0.75), "ball": (0.15, 0.95), "toes": (0.15, 1.0)}


@dataclass(frozen=True)
class ContactInterval:
    """One region of one foot on the ground.

    Attributes:
        side: ``"r"`` or ``"l"``.
        region: ``"heel"``, ``"ball"`` or ``"toes"``.
        start: [s].
        stop: [s].
    """

    side: str
    region: str
    start: float
    stop: float


def foot_contacts(
    time: Float[Array, " n_frames"], events: Sequence[GaitEvent], rests: Sequence[Rest]
) -> tuple[ContactInterval, ...]:
    """Return when each region touches: its rests within the stances of its foot.

    The heel touches from heel strike on and the toes up to toe off, whatever their speed; where a
    region is not seen to rest, the usual shares of the stance are taken.
    """
    contacts = []
    for side in SIDES:
        for start, stop, whole in stances(events, side, time[0], time[-1]):
            for region, share in USUAL.items():
                found = [
                    (float(time[r.start]), float(time[r.stop - 1]))
                    for r in rests
                    if r.side == side
                    and r.region == region
                    and time[r.start] < stop
                    and time[r.stop - 1] > start
                ]
                if found:
                    first, last = min(f[0] for f in found), max(f[1] for f in found)
                elif whole:
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
) -> list[tuple[float, float, bool]]:
    """Return start and stop of a foot's stances [s], and whether they were seen whole.

    Args:
        events: All gait events, by time.
        side: The foot.
        first: Start of the recording [s].
        last: Its end [s].
    """
    own = [e for e in events if e.side == side]
    found = []
    for k, event in enumerate(own):
        if event.kind == "toe_off" and k == 0:
            found.append((first, event.time, False))
        if event.kind == "heel_strike":
            off = own[k + 1] if k + 1 < len(own) else None
            if off is None:
                found.append((event.time, last, False))
            elif off.kind == "toe_off":
                found.append((event.time, off.time, True))
    return found

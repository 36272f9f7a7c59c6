"""Gait events from the motion and from force plates: which to believe, and whether clocks agree.

A plate tells when a foot is loaded to a few milliseconds if its force was stored as measured. A
force that was low-passed first rises before the foot lands and falls after it has left, by up to
20 ms: then the motion knows better.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plantigrade.motion.plate_events import THRESHOLD, contact_events
from plantigrade.motion.recording import ForcePlate, GaitEvent

SAME = 0.06
"""Furthest apart the event of a plate and that of the motion may be to be the same [s]."""

SEEN = 0.15
"""The same when clocks are compared [s]."""

RISE = 0.015
"""Longest time in which the force of a landing foot rises from 20 to 100 N [s]. It takes 5 to 13 ms
unfiltered, and 18 to 25 ms after a low-pass of 10 to 6 Hz, which shows it 10 to 20 ms early."""

SHIFTED = 0.03
"""Plates and markers disagree by this much where their clocks do [s]: three times the mean error of
events from the motion."""


def as_measured(plates: Sequence[ForcePlate]) -> tuple[ForcePlate, ...]:
    """Return the plates whose force was not low-passed before it was stored.

    A plate on which nobody landed is judged by the others.
    """
    rises: dict[int, list[float]] = {}
    for i, plate in enumerate(plates):
        force = plate.force[:, 2]
        for contact in contact_events(plate.time, force):
            if contact.start is None or not contact.peak > 10 * THRESHOLD:
                continue
            after = plate.time >= contact.start
            high = np.flatnonzero(after & (force > 5 * THRESHOLD))
            if len(high):
                rises.setdefault(i, []).append(float(plate.time[high[0]] - contact.start))
    usual = [rise for found in rises.values() for rise in found]
    return tuple(
        plate
        for i, plate in enumerate(plates)
        if usual and float(np.median(rises.get(i, usual))) <= RISE
    )


def with_measured(
    events: Sequence[GaitEvent], measured: Sequence[GaitEvent]
) -> tuple[tuple[GaitEvent, ...], int]:
    """Return the events of a motion with the instants that plates saw, and how many these are."""
    result, count = [], 0
    for event in events:
        found = _nearest(event, measured, SAME)
        count += found is not None
        result.append(event if found is None else replace(event, time=found.time))
    return tuple(sorted(result, key=lambda event: (event.time, event.side))), count


def clock_shift(events: Sequence[GaitEvent], measured: Sequence[GaitEvent]) -> float | None:
    """Return by how much the plates' clock seems to be late [s]; None where they agree.

    A shift moves landings and lift-offs alike. It is seen where both kinds were measured, by
    more than :data:`SHIFTED` and to the same side.

    Args:
        events: From the motion.
        measured: From the plates.
    """
    late: dict[str, list[float]] = {"heel_strike": [], "toe_off": []}
    for each in measured:
        found = _nearest(each, events, SEEN)
        if found is not None:
            late[each.kind].append(each.time - found.time)
    if not all(late.values()):
        return None
    usual = [float(np.median(values)) for values in late.values()]
    if min(usual) < -SHIFTED / 2 and max(usual) > SHIFTED / 2:
        return None
    shift = float(np.mean(usual))
    return shift if abs(shift) > SHIFTED else None


def _nearest(event, others, furthest):
    """Return the nearest event of the same foot and kind within ``furthest`` seconds, or None."""
    same = [o for o in others if (o.side, o.kind) == (event.side, event.kind)]
    found = min(same, key=lambda o: abs(o.time - event.time), default=None)
    return found if found is not None and abs(found.time - event.time) <= furthest else None

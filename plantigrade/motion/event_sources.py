"""Choice between gait events from motion and from force plates, and a check of their clocks.

A plate tells when a foot is loaded to a few milliseconds if its force was stored as measured. A
force that was low-passed first rises before the foot lands and falls after it has left, by up to
20 ms: then the motion knows better.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plantigrade.motion.plate_events import THRESHOLD, contact_events
from plantigrade.motion.recording import ForcePlate, GaitEvent

MAX_EVENT_DIFFERENCE = 0.06
"""Maximum difference between events of plate and motion that are the same [s]."""
MAX_CLOCK_DIFFERENCE = 0.15  # [s] the same for the comparison of clocks
MAX_RISE_TIME = 0.015
"""Maximum rise time of an unfiltered force at touchdown, from 20 to 100 N [s]. It is 5 to 13 ms
unfiltered, and 18 to 25 ms after a low-pass of 10 to 6 Hz, which makes the event 10 to 20 ms
early."""
MIN_CLOCK_SHIFT = 0.03
"""Minimum difference between plate and motion events if their clocks differ [s], three times the
mean error of events from the motion."""


def as_measured(plates: Sequence[ForcePlate]) -> tuple[ForcePlate, ...]:
    """Return the plates whose force was not low-passed before it was stored.

    A plate without a landing is judged by the others.
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
        if usual and float(np.median(rises.get(i, usual))) <= MAX_RISE_TIME
    )


def with_measured(
    events: Sequence[GaitEvent], measured: Sequence[GaitEvent]
) -> tuple[tuple[GaitEvent, ...], int]:
    """Return the events of a motion, timed by plates where possible, and the number of those."""
    result, count = [], 0
    for event in events:
        found = _nearest(event, measured, MAX_EVENT_DIFFERENCE)
        count += found is not None
        result.append(event if found is None else replace(event, time=found.time))
    return tuple(sorted(result, key=lambda event: (event.time, event.side))), count


def clock_shift(events: Sequence[GaitEvent], measured: Sequence[GaitEvent]) -> float | None:
    """Return the apparent delay of the plates' clock [s]; None if the clocks agree.

    A shift affects touchdown and lift-off equally. It is detected if both kinds were measured and
    differ by more than :data:`MIN_CLOCK_SHIFT` in the same direction.
    """
    late: dict[str, list[float]] = {"heel_strike": [], "toe_off": []}
    for each in measured:
        found = _nearest(each, events, MAX_CLOCK_DIFFERENCE)
        if found is not None:
            late[each.kind].append(each.time - found.time)
    if not all(late.values()):
        return None
    usual = [float(np.median(values)) for values in late.values()]
    if min(usual) < -MIN_CLOCK_SHIFT / 2 and max(usual) > MIN_CLOCK_SHIFT / 2:
        return None
    shift = float(np.mean(usual))
    return shift if abs(shift) > MIN_CLOCK_SHIFT else None


def _nearest(event, others, furthest):
    """Return the nearest event of the same foot and kind within ``furthest`` seconds, or None."""
    same = [o for o in others if (o.side, o.kind) == (event.side, event.kind)]
    found = min(same, key=lambda o: abs(o.time - event.time), default=None)
    return found if found is not None and abs(found.time - event.time) <= furthest else None

"""The phases of gait: between one event and the next, one foot or both are on the ground.

The paper's four phases of a cycle are two double supports (heel strike to the other foot's toe
off) and two single supports (toe off to the same foot's heel strike).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from plantigrade.motion import GaitEvent

# Each event of walking is followed by exactly one other.
_NEXT = {
    ("r", "heel_strike"): ("l", "toe_off"),
    ("l", "toe_off"): ("l", "heel_strike"),
    ("l", "heel_strike"): ("r", "toe_off"),
    ("r", "toe_off"): ("r", "heel_strike"),
}


@dataclass(frozen=True, kw_only=True)
class PhaseSettings:
    """What sequence of events is walking."""

    max_duration: float = 1.5
    """Duration beyond which a phase is a stop, not a part of a stride [s]. Chosen."""
    max_flight: float = 0.1
    """Time from a toe off to the other foot's heel strike up to which their order is taken for
    blurred [s]. Chosen."""
    blurred_double_support: float = 0.02
    """Duration of the double support that is put in its place [s]. Chosen."""


@dataclass(frozen=True)
class Phase:
    """One phase.

    Attributes:
        start: [s].
        stop: [s].
        kind: ``"double"`` or ``"single"`` support.
        swing: The swinging foot of a single support; of a double support the one that will swing
            next.
    """

    start: float
    stop: float
    kind: str
    swing: str

    @property
    def duration(self) -> float:
        """[s]."""
        return self.stop - self.start


def in_order(
    events: Sequence[GaitEvent], settings: PhaseSettings | None = None
) -> tuple[tuple[GaitEvent, ...], int]:
    """Return the events with blurred double supports put in order, and how many those were.

    Where a recording jerks while one foot takes over from the other, the toe off can seem to come
    before the heel strike. In a walk, that is where most double supports are seen in order, both
    events are put at their middle, the strike first; a run, with its flight, is left as it is.
    """
    settings, events = settings or PhaseSettings(), sorted(events, key=lambda e: e.time)
    pairs = list(pairwise(events))
    regular = sum(
        a.kind == "heel_strike" and b.kind == "toe_off" and a.side != b.side for a, b in pairs
    )
    blurred = [
        k
        for k, (a, b) in enumerate(pairs)
        if a.kind == "toe_off"
        and b.kind == "heel_strike"
        and a.side != b.side
        and b.time - a.time <= settings.max_flight
    ]
    if len(blurred) >= regular:
        return tuple(events), 0
    for k in blurred:
        off, strike = events[k], events[k + 1]
        middle, half = (off.time + strike.time) / 2, settings.blurred_double_support / 2
        events[k] = replace(strike, time=middle - half)
        events[k + 1] = replace(off, time=middle + half)
    return tuple(events), len(blurred)


def walking_events(
    events: Sequence[GaitEvent], settings: PhaseSettings | None = None
) -> tuple[GaitEvent, ...]:
    """Return the longest run of events that follow one another as in walking."""
    longest = (settings or PhaseSettings()).max_duration
    events = sorted(events, key=lambda e: e.time)
    best: list[GaitEvent] = []
    run: list[GaitEvent] = []
    for event in events:
        last = run[-1] if run else None
        follows = (
            last is not None
            and _NEXT.get((last.side, last.kind)) == (event.side, event.kind)
            and event.time - last.time <= longest
        )
        run = [*run, event] if follows else [event]
        if len(run) > len(best):
            best = run
    return tuple(best)


def phases_between(events: Sequence[GaitEvent]) -> tuple[Phase, ...]:
    """Return the phases between consecutive events of :func:`walking_events`."""
    phases = []
    for a, b in pairwise(events):
        if a.kind == "toe_off":
            phases.append(Phase(a.time, b.time, "single", a.side))
        else:
            phases.append(Phase(a.time, b.time, "double", "l" if a.side == "r" else "r"))
    return tuple(phases)

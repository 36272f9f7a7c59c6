"""Phases of gait between consecutive events: single and double supports.

The paper's four phases of a cycle are two double supports (heel strike to the other foot's toe-off)
and two single supports (toe-off to the same foot's heel strike).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from plantigrade.motion import GaitEvent
from plantigrade.side_names import opposite

# Each event of walking is followed by exactly one other.
_NEXT = {
    ("r", "heel_strike"): ("l", "toe_off"),
    ("l", "toe_off"): ("l", "heel_strike"),
    ("l", "heel_strike"): ("r", "toe_off"),
    ("r", "toe_off"): ("r", "heel_strike"),
}


@dataclass(frozen=True, kw_only=True)
class PhaseSettings:
    """Criteria for a sequence of events to be walking."""

    max_duration: float = 1.5
    """Maximum duration of a phase; a longer one is a stop [s]. Chosen."""
    max_flight: float = 0.1
    """Maximum time from a toe-off to the other foot's heel strike for which their order counts as
    uncertain [s]. Chosen."""
    blurred_double_support: float = 0.02
    """Duration of the double support that replaces an uncertain order [s]. Chosen."""


@dataclass(frozen=True)
class Phase:
    """A phase of gait."""

    start: float  #: [s]
    stop: float  #: [s]
    kind: str  #: ``"double"`` or ``"single"`` support
    swing: str  #: The swing foot of a single support; for a double support the one that swings next

    @property
    def duration(self) -> float:
        """[s]."""
        return self.stop - self.start


def ordered_events(events: Sequence[GaitEvent]) -> tuple[tuple[GaitEvent, ...], int]:
    """Return the events with uncertain double supports corrected, and the number of corrections.

    In a jerky recording the toe-off can appear to precede the other foot's heel strike. In a walk,
    where most double supports have the correct order, both events are moved to their mean time with
    the heel strike first; a run, with its flight phases, is unchanged.
    """
    settings, events = PhaseSettings(), sorted(events, key=lambda e: e.time)
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


def walking_events(events: Sequence[GaitEvent]) -> tuple[GaitEvent, ...]:
    """Return the longest series of events in the order of walking."""
    longest = PhaseSettings().max_duration
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
            phases.append(Phase(a.time, b.time, "double", opposite(a.side)))
    return tuple(phases)

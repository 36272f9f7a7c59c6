"""Gait events of a contact plan."""

from itertools import pairwise

from plantigrade.contact.plan import TIME_TOLERANCE, ContactPlan
from plantigrade.motion.recording import GaitEvent


def alternates(plan: ContactPlan) -> bool:
    """Return whether the feet step alternately, as strides require."""
    strikes = sorted(
        (s.heel_strike, s.footprint.side)
        for s in plan.unrolled()
        if plan.periodic or s.heel_strike > 0
    )
    later = TIME_TOLERANCE  # feet that land together do not step
    return len(strikes) > 1 and all(
        a[1] != b[1] and b[0] - a[0] > later for a, b in pairwise(strikes)
    )


def gait_events(plan: ContactPlan, end: float) -> tuple[GaitEvent, ...]:
    """Return heel strikes and toe-offs from the start of a plan to ``end`` [s], by time.

    In a plan without repetition, a foot that stands from the start has no heel strike.
    """
    periods = 0 if not plan.periodic else round(end / plan.duration) + 2
    edge = 10 * TIME_TOLERANCE if plan.periodic else -10 * TIME_TOLERANCE
    events = [
        GaitEvent(min(max(time, 0.0), end), s.footprint.side, kind)
        for s in plan.unrolled(after=periods)
        for time, kind in ((s.heel_strike, "heel_strike"), (s.toe_off, "toe_off"))
        if -edge < time < end + edge
    ]
    return tuple(sorted(events, key=lambda e: e.time))

r"""Refinement of touchdown and lift-off times that are known to within a tenth of a second.

The swings of a foot (:mod:`plantigrade.motion.swings`) tell which steps were made; here each event
is moved to the instant that published comparisons with force plates found nearest.

**Walking.** The heel lands while the forefoot still comes down: initial contact is where the middle
of the foot falls fastest, the trough of its vertical velocity [OConnor2007]_. The foot leaves
where the speed of its slower end rises through :data:`LEAVING_FRACTION` of its peak in the swing, a
threshold of velocity [Ghoussayni2004]_ that scales with the walker [Bruening2014]_.

**Running.** The ground stops a foot within some 20 ms: it lands at the peak of the vertical
acceleration of heel or forefoot, whichever comes first, and leaves at the peak of the vertical jerk
of the forefoot [Handsaker2016]_.

An event whose neighbourhood shows no such extremum stays where the swing put it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.motion.filters import crossing, derivative, vertex
from plantigrade.motion.recording import GaitEvent, rate_of

LEAVING_FRACTION = 0.30
"""Speed of the slower end of a walking foot at toe-off, as a fraction of its peak in that swing.
Mean over the clean plates of two people (HC032, opensim_walking2)."""
NEAR_LANDING = 0.06  # [s] maximum correction of a touchdown in walking
TOUCHDOWN_WINDOW = (0.06, 0.01)
"""Search window of touchdown in running, before and after the end of the swing [s]."""
LEAVING_WINDOW = (0.08, 0.02)
"""Search window of toe-off in running, before and after the start of the swing [s]."""
MIN_IMPACT_ACCELERATION = 5.0  # Acceleration peak of touchdown in running [m/s²], half of gravity
WALKING_CUTOFF = 12.0  # [Hz] low-pass of the feet in walking, before differentiation
RUNNING_CUTOFF = 20.0
"""Low-pass of the feet in running, before differentiation [Hz]."""


def is_running(events: Sequence[GaitEvent]) -> bool:
    """Return whether most steps have a flight: one foot leaves before the other lands."""
    flights = []
    for off in (e for e in events if e.kind == "toe_off"):
        # The landing of the other foot that is nearest: before it in walking, after it in running.
        landings = [
            e.time - off.time for e in events if e.kind == "heel_strike" and e.side != off.side
        ]
        nearest = min(landings, key=abs, default=None)
        if nearest is not None and abs(nearest) < 0.4:
            flights.append(nearest > 0)
    return len(flights) > 1 and float(np.mean(flights)) > 0.5


def time_events(
    time: Float[Array, " n_frames"],
    heel: Float[Array, "n_frames 2 3"],
    toe: Float[Array, "n_frames 2 3"],
    speed: Float[Array, "n_frames 2"],
    ground: Float[Array, "n_frames 3"],
    events: Sequence[GaitEvent],
) -> tuple[GaitEvent, ...]:
    """Return the events with refined times of touchdown and lift-off.

    Args:
        time: Time of each frame [s].
        heel: Back of the heel, right then left, world, gaps closed [m].
        toe: Forefoot [m].
        speed: Speed of the slower end of each foot relative to the ground, smoothed [m/s].
        ground: Velocity of the ground [m/s].
        events: Events from the swings.
    """
    if is_running(events):
        signals = _Running(time, heel, toe)
    else:
        signals = _Walking(time, heel, toe, speed, ground)
    moved = []
    for event in events:
        k = SIDES.index(event.side)
        find = signals.landing if event.kind == "heel_strike" else signals.leaving
        instant = find(k, event.time)
        moved.append(event if instant is None else replace(event, time=instant))
    return tuple(sorted(moved, key=lambda event: (event.time, event.side)))


class _Walking:
    def __init__(self, time, heel, toe, speed, ground):
        cutoff = min(WALKING_CUTOFF, rate_of(time) / 4)
        middle = derivative(time, (heel + toe) / 2, cutoff=cutoff)[..., 2] - ground[:, None, 2]
        self.time, self.speed, self.fall = time, speed, -middle

    def landing(self, k, about):
        found = _peak(self.time, self.fall[:, k], about - NEAR_LANDING, about + NEAR_LANDING)
        return None if found is None else found[0]

    def leaving(self, k, about):
        time, speed = self.time, self.speed[:, k]
        first = int(np.searchsorted(time, about))
        # Up to the top of this swing.
        last = first
        while last + 1 < len(time) and speed[last + 1] > speed[last]:
            last += 1
        stop = int(np.searchsorted(time, about + 0.5))
        peak = np.max(speed[first:stop], initial=0.0, where=np.isfinite(speed[first:stop]))
        level = LEAVING_FRACTION * peak
        for i in range(max(first - 1, 0), last):
            if speed[i] <= level < speed[i + 1]:
                return crossing(time, speed, i, level)
        return None


class _Running:
    def __init__(self, time, heel, toe):
        cutoff = min(RUNNING_CUTOFF, rate_of(time) / 4)
        self.time = time
        self.up = [derivative(time, p, order=2, cutoff=cutoff) for p in (heel, toe)]
        self.jerk = derivative(time, self.up[1])

    def landing(self, k, about):
        window = about - TOUCHDOWN_WINDOW[0], about + TOUCHDOWN_WINDOW[1]
        peaks = [_peak(self.time, up[:, k, 2], *window) for up in self.up]
        strong = (found for found in peaks if found and found[1] > MIN_IMPACT_ACCELERATION)
        hits = [found[0] for found in strong]
        return min(hits, default=None)

    def leaving(self, k, about):
        window = about - LEAVING_WINDOW[0], about + LEAVING_WINDOW[1]
        found = _peak(self.time, self.jerk[:, k, 2], *window)
        return None if found is None else found[0]


def _peak(time, signal, start, stop):
    """Return instant and height of the highest local maximum in a window, or None."""
    inside = np.flatnonzero((time >= start) & (time <= stop))
    inside = inside[(inside > 0) & (inside < len(time) - 1)]
    tops = [i for i in inside if signal[i - 1] < signal[i] >= signal[i + 1]]
    if not tops:
        return None
    i = max(tops, key=lambda i: signal[i])
    return float(time[i] + vertex(signal, i) * (time[i + 1] - time[i])), float(signal[i])

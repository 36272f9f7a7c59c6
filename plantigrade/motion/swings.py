r"""Swings of a foot: humps of its speed, and which of them are steps.

:math:`s(t)` is the speed of the foot's slower end relative to the ground
(:mod:`plantigrade.motion.events`).
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.motion.filters import crossing, runs

TOE_OFF_FRACTION = 0.22
"""Speed of the slower end of the foot at toe-off, as a fraction of its peak in that swing."""
HEEL_STRIKE_FRACTION = 0.125
"""Speed of the slower end of the foot at heel strike, as a fraction of its last peak."""
MIN_PEAK_SPEED = 0.4  # Minimum peak speed of the slower end in a swing [m/s]; shuffling has 0.6
MIN_SWING = 0.1  # Minimum duration of a swing [s]; sprinting has 0.3 s
MIN_OTHER_STANCE = 0.2
"""Minimum fraction of a swing with the other foot in stance; 0.28 in sprinting, 0 in jumping."""
MAX_FLIGHT = 0.22  # Maximum flight phase of running [s]; usually below 0.2 s
MIN_STANCE = 0.06  # Minimum duration of stance [s]; sprinting has 0.08 s
MIN_STEP_TIME = 0.12  # Minimum step time [s]; sprinting has 0.2 s
MIN_STEP_DISPLACEMENT = 1.2
"""Minimum displacement of the foot in a step, as a multiple of the length from heel to metatarsal
head, which is 0.7 of foot length: footprints hardly overlap."""
MAX_LIFT = 0.6
"""Maximum lift of the foot in a step, relative to its displacement; 0.25 sprinting, 0.5 on
stairs."""
MIN_PELVIS_DISPLACEMENT = 0.1
"""Minimum displacement of the pelvis in a swing, relative to the foot's; 0.4 in steady walking."""


@dataclass(frozen=True)
class Swing:
    """A hump of the foot's speed: frames `first` to `last`; events None if not observed."""

    first: int
    last: int
    start: float | None
    stop: float | None
    peak: float

    @property
    def whole(self):
        """Whether both events were observed."""
        return self.start is not None and self.stop is not None


def swings(time, speed, middle, height, length):
    """Return the humps of `speed` that are steps, complete or cut by the end of a stretch."""
    found = []
    for stretch in runs(np.isfinite(speed)):
        s = speed[stretch]
        if len(s) < 5:
            continue
        taken = np.zeros(len(s), dtype=bool)
        for top in np.argsort(-s, kind="stable").tolist():
            peak = s[top]
            if peak < MIN_PEAK_SPEED:
                break
            if taken[top]:
                continue
            low = np.flatnonzero(s[:top] < TOE_OFF_FRACTION * peak)
            high = np.flatnonzero(s[top:] < HEEL_STRIKE_FRACTION * peak)
            left = int(low[-1]) if len(low) else -1
            right = int(top + high[0]) if len(high) else len(s)
            clash = taken[max(left, 0) : right].any()
            # A shoulder of a higher hump does not count: speed must fall to stance on both sides.
            taken[max(left, 0) : min(right + 1, len(s))] = True
            if clash:
                continue
            start = stop = None
            offset = stretch.start
            if left >= 0:
                start = crossing(time, speed, offset + left, TOE_OFF_FRACTION * peak)
            if right < len(s):
                stop = crossing(time, speed, offset + right - 1, HEEL_STRIKE_FRACTION * peak)
            last = offset + min(right, len(s) - 1)
            found.append(Swing(offset + max(left, 0), last, start, stop, float(peak)))
    found = _joined(sorted(found, key=lambda swing: swing.first))
    return [s for s in found if not s.whole or _carries(s, middle, height, length)]


def _joined(swings):
    """Return the swings; those without a real stance in between are joined."""
    joined: list[Swing] = []
    for swing in swings:
        before = joined[-1] if joined else None
        if (
            before is not None
            and before.whole
            and swing.whole
            and swing.start - before.stop < MIN_STANCE
        ):
            peak = max(before.peak, swing.peak)
            swing = Swing(before.first, swing.last, before.start, swing.stop, peak)
            joined.pop()
        joined.append(swing)
    return joined


def _carries(swing, middle, height, length):
    """Return whether a complete swing moves the foot elsewhere, further than it lifts it."""
    way = np.linalg.norm(middle[swing.last] - middle[swing.first])
    ends = max(height[swing.first], height[swing.last])
    lift = np.max(height[swing.first : swing.last + 1]) - ends
    return (
        way >= MIN_STEP_DISPLACEMENT * length
        and lift <= MAX_LIFT * way
        and swing.stop - swing.start >= MIN_SWING
    )


def apart(steps):
    """Return the steps (foot, swing) without those that end as the other foot lands.

    The foot with the shorter swing only closed up to the other.
    """
    return [
        (k, swing)
        for k, swing in steps
        if not any(
            other != k
            and swing.stop is not None
            and longer.stop is not None
            and abs(swing.stop - longer.stop) < MIN_STEP_TIME
            and swing.last - swing.first <= longer.last - longer.first
            for other, longer in steps
        )
    ]


def alternating(steps, speed):
    """Return the steps (foot, swing) without those that follow and precede steps of the same foot.

    If the other foot was hidden in between, it may have stepped.
    """
    steps = sorted(steps, key=lambda step: step[1].first + step[1].last)
    kept = []
    for i, (k, swing) in enumerate(steps):
        lone = []
        for j in (i - 1, i + 1):
            if 0 <= j < len(steps) and steps[j][0] == k:
                a, b = sorted((swing.first, steps[j][1].first))
                lone.append(bool(np.isfinite(speed[a : b + 1, 1 - k]).all()))
            else:
                lone.append(False)
        ends = (i == 0) + (i == len(steps) - 1)
        if sum(lone) + ends < 2 or not any(lone):
            kept.append((k, swing))
    return kept


def judge_cut(time, speed, swing, usual):
    """Return a swing cut by the end of a stretch with the events that are certain, or None."""
    if swing.start is None and swing.stop is None:
        return None
    if not np.isfinite(usual):
        # Without a complete swing to compare with, its peak must have been observed.
        inner = speed[swing.first + 1 : swing.last]
        seen = len(inner) > 0 and inner.max() > max(speed[swing.first], speed[swing.last])
        return swing if seen else None
    peak = max(swing.peak, usual) if swing.peak < 1.5 * usual else swing.peak
    s = speed[swing.first : swing.last + 1]
    top = int(np.argmax(s))
    if swing.stop is not None:  # came in from outside: only its end can be known
        if swing.peak < TOE_OFF_FRACTION * usual:
            return None
        below = np.flatnonzero(s[top:] < HEEL_STRIKE_FRACTION * peak)
        if len(below) == 0 or top + below[0] == 0:
            return None
        k = swing.first + top + int(below[0]) - 1
        stop = crossing(time, speed, k, HEEL_STRIKE_FRACTION * peak)
        return Swing(swing.first, swing.last, None, stop, float(peak))
    if swing.peak < 0.5 * usual:
        return None
    first = swing.first
    below = np.flatnonzero(s[:top] < TOE_OFF_FRACTION * peak)
    if len(below) == 0:
        return None
    start = crossing(time, speed, first + int(below[-1]), TOE_OFF_FRACTION * peak)
    return Swing(first, swing.last, start, None, float(peak))


def other_stands(time, other, swing, usual):
    """Return whether the other foot was in stance in part of the swing; True if not observed."""
    start = time[swing.first] if swing.start is None else swing.start
    stop = time[swing.last] if swing.stop is None else swing.stop
    inside = (time >= start) & (time <= stop) & np.isfinite(other)
    if not inside.any():
        return True
    reference = usual if np.isfinite(usual) else swing.peak
    stands = other < TOE_OFF_FRACTION * reference
    flights = runs(inside & ~stands)
    longest = max((time[f.stop - 1] - time[f.start] for f in flights), default=0.0)
    return bool(np.mean(stands[inside]) >= MIN_OTHER_STANCE and longest <= MAX_FLIGHT)


def pelvis_follows(time, body, middle, swing):
    """Return whether the pelvis moves with the foot; True if it was not observed."""
    if body is None:
        return True
    way = np.linalg.norm(middle[swing.last] - middle[swing.first])
    moved = np.linalg.norm(body[swing.last] - body[swing.first])
    return not moved < MIN_PELVIS_DISPLACEMENT * way  # NaN says nothing against it

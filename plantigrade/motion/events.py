r"""Heel strike and toe off: from the motion of the feet alone.

**The ground.** A foot in stance moves with the ground. The velocity that the feet's points share
most often is therefore the ground's: zero overground, the belt's on a treadmill. Everything below
is relative to it, so that one method serves both.

**The foot.** In stance at least one end of the foot rests on the ground: the heel after heel
strike, both in mid-stance, the toe in push-off. The speed of the slower end,

.. math:: s(t) = \min(|\dot p_\text{heel} - v_g|, |\dot p_\text{toe} - v_g|),

is near zero in stance and has one hump per swing, whatever the direction of walking: forward, in a
turn, sideways, backward (:mod:`plantigrade.motion.swings`). Heel strike and toe off alternate by
construction, and the thresholds scale with the walker. Near the edges of each hump the events are
then timed, of walking and of running by methods of their own
(:mod:`plantigrade.motion.event_timing`).

**Steps.** Not every hump is a step. A step puts the foot clear of its last footprint and moves
it further than it lifts it; otherwise it is a shuffle, a kick or a jump on the spot. The other foot
is in stance for part of it; both may be airborne, but no longer than in running, otherwise it is a
leap. Feet that land together end a jump. Between two steps of one foot the other foot steps;
otherwise it is a hop.

Velocity thresholds are those of [Ghoussayni2004]_; that they must scale with walking speed, and how
the published methods compare, is in [Bruening2014]_. The peak speed of the slower end is about
three and a half times the walking speed. A heel strike threshold must lie above the speed at which
a heel marker still rolls forward about the heel while the foot comes down (a tenth of the peak).
The coordinate method [Zeni2008]_ finds heel strike 20 to 45 ms before the plates do on the
recordings this was checked on, so it is not used here.
"""

from collections.abc import Iterable

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.motion.event_timing import time_events
from plantigrade.motion.filters import derivative, fill_gaps
from plantigrade.motion.ground_velocity import MAX_GAP, ground_velocity, smooth_feet, travel
from plantigrade.motion.recording import GaitEvent
from plantigrade.motion.swings import (
    Swing,
    alternating,
    apart,
    judge_cut,
    other_stands,
    pelvis_follows,
    swings,
)


def detect_gait_events(
    time: Float[Array, " n_frames"],
    heel: Float[Array, "n_frames 2 3"],
    toe: Float[Array, "n_frames 2 3"],
    pelvis: Float[Array, "n_frames 3"] | None = None,
) -> tuple[GaitEvent, ...]:
    """Return the heel strikes and toe offs of both feet, by time, from the motion alone.

    See the module's text for the method. Where the foot's trajectory begins or ends in mid-swing,
    a heel strike is reported if the foot comes in at a quarter of the usual peak speed or more, a
    toe off if it reaches at least half of it.

    Args:
        time: Time of each frame [s], evenly spaced.
        heel: Back of the heel, right then left, world [m]; NaN where not seen.
        toe: Toe tip or head of the second metatarsal, right then left, world [m].
        pelvis: A point of the pelvis [m]; where given, moving a foot while the pelvis stays
            (sitting, standing) does not count as a step.

    Returns:
        Events by time; none for standing, squatting, jumping, hopping and kicking.

    Raises:
        ParameterError: If the arrays do not have one frame per time, or time does not increase.
    """
    check_frames(time, heel, toe, pelvis)
    if len(time) < 8:
        return ()
    feet = smooth_feet(time, np.stack([heel, toe], axis=2))
    ground = ground_velocity(time, heel, toe)
    speeds = np.linalg.norm(derivative(time, feet) - ground[:, None, None], axis=-1)
    speed = speeds.min(axis=2)  # (n_frames, 2), NaN if either end is hidden
    way = travel(time, ground)
    middle = feet.mean(axis=2)[..., :2] - way[:, None, :2]
    filled = None if pelvis is None else fill_gaps(time, pelvis[:, :2], longest=1.0)
    body = None if filled is None else filled - way[:, :2]
    length = _foot_length(feet)
    if not length > 0:
        return ()
    height = feet[..., 2].min(axis=2) - way[:, None, 2]
    found = [swings(time, speed[:, k], middle[:, k], height[:, k], length) for k in (0, 1)]
    peaks = [s.peak for side in found for s in side if s.whole]
    usual = float(np.median(peaks)) if peaks else np.nan
    steps: list[tuple[int, Swing]] = []
    for k in (0, 1):
        for swing in found[k]:
            if not swing.whole:
                swing = judge_cut(time, speed[:, k], swing, usual)
            if (
                swing is not None
                and other_stands(time, speed[:, 1 - k], swing, usual)
                and pelvis_follows(time, body, middle[:, k], swing)
            ):
                steps.append((k, swing))
    events = _events_of(alternating(apart(steps), speed))
    heel, toe = (fill_gaps(time, each, longest=MAX_GAP) for each in (heel, toe))
    return time_events(time, heel, toe, speed, ground, events)


def check_frames(time, heel, toe, pelvis):
    """Raise a ParameterError unless there is one frame per instant and time increases."""
    if len(time) > 1 and not (np.diff(time) > 0).all():
        raise ParameterError("time must increase from frame to frame")
    for name, values in (("heel", heel), ("toe", toe), ("pelvis", pelvis)):
        if values is not None and len(values) != len(time):
            raise ParameterError(
                f"{name} has {len(values)} frames for {len(time)} instants: one frame per instant"
            )


def _events_of(steps: Iterable[tuple[int, Swing]]) -> list[GaitEvent]:
    """Return the events at the ends of swings, by time."""
    events = []
    for k, swing in steps:
        if swing.start is not None:
            events.append(GaitEvent(float(swing.start), SIDES[k], "toe_off"))
        if swing.stop is not None:
            events.append(GaitEvent(float(swing.stop), SIDES[k], "heel_strike"))
    return sorted(events, key=lambda event: (event.time, event.side))


def _foot_length(feet: Float[Array, "n_frames 2 2 3"]) -> float:
    """Return the usual distance of heel and toe [m]; NaN where they are never seen."""
    lengths = np.linalg.norm(feet[:, :, 0] - feet[:, :, 1], axis=-1)
    return float(np.nanmedian(lengths)) if np.isfinite(lengths).any() else np.nan

r"""Heel strike and toe off: from the feet's motion alone, and from force plates.

**The ground.** A foot in stance moves with the ground. The velocity that the feet's points share
most often is therefore the ground's: zero overground, the belt's on a treadmill. Everything below
is relative to it, so that one method serves both.

**The foot.** In stance at least one end of the foot rests on the ground: the heel after heel
strike, both in mid-stance, the toe in push-off. The speed of the slower end,

.. math:: s(t) = \min(|\dot p_\text{heel} - v_g|, |\dot p_\text{toe} - v_g|),

is near zero in stance and has one hump per swing, whatever the direction of walking: forward, in a
turn, sideways, backward. The foot leaves where the hump rises through :data:`TOE_OFF_FRACTION` of
its own peak and lands where it falls through :data:`HEEL_STRIKE_FRACTION`. Heel strike and toe off
alternate by construction, and the thresholds scale with the walker.

**Steps.** Not every hump is a step. A step puts the foot clear of where it stood and carries it
further than it lifts it, else it is a shuffle on the spot, a kick or a jump in place. The other
foot stands for part of it; both may be in the air, as in running, but for no longer than running
has it, else it is a leap. Feet that land together end a jump. Between two steps of one foot the
other steps, else it is a hop.

Velocity thresholds are those of [Ghoussayni2004]_; that they must scale with walking speed, and how
the published methods compare, is in [Bruening2014]_. The peak speed of the slower end is about
three and a half times the walking speed, so the two fractions are about 0.45 (heel strike) and 0.8
(toe off) of the walking speed. A heel strike threshold must lie above the speed at which a heel
marker still rolls forward about the heel while the foot comes down (a tenth of the peak). The
coordinate method [Zeni2008]_ finds heel strike 20 to 45 ms before the plates do on the recordings
this was checked on, so it is not used here.

References:
    [Ghoussayni2004]_, [Bruening2014]_, [Zeni2008]_.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.motion.filters import derivative, fill_gaps, lowpass, runs
from plantigrade.motion.recording import ForcePlate, GaitEvent, rate_of

SIDES = ("l", "r")

TOE_OFF_FRACTION = 0.22
"""Speed of the slower end of the foot at toe off, of its peak in that swing."""

HEEL_STRIKE_FRACTION = 0.125
"""Speed of the slower end of the foot at heel strike, of its peak in the swing before."""

SLOWEST_SWING = 0.4
"""Lowest peak speed of the slower end that counts as a swing [m/s]; shuffling reaches 0.6."""

SLOWEST_BELT = 0.15
"""A ground slower than this stands still [m/s]; no treadmill gait is that slow."""

SHORTEST_SWING = 0.1
"""Shortest swing [s]; a sprinter's lasts 0.3 s."""

OTHER_FOOT_STANDS = 0.2
"""Least part of a swing in which the other foot stands; a sprinter's 0.28, a jumper's 0."""

LONGEST_FLIGHT = 0.22
"""Longest time both feet are in the air in running [s]; a runner stays below 0.2 s."""

SHORTEST_STANCE = 0.06
"""Shortest stance [s]; a sprinter's lasts 0.08 s. A foot that rests for less was only slow."""

SHORTEST_STEP = 0.12
"""Shortest time from one foot's landing to the other's [s]; a sprinter's is 0.2 s."""

LEAST_WAY = 1.0
"""Least way of the foot in a step, of its length from heel to toe: its prints do not overlap."""

MOST_LIFT = 0.6
"""Greatest lift of the foot's lower end in a step, of its way; a sprinter's 0.25, on stairs 0.5."""

PULL_FACTOR = 5.0
"""A plate's threshold is at least this many times as far above rest as it reads below."""

MOST_RAISED = 2.5
"""The threshold is raised to this many times itself at most: 50 N, as is usual on treadmills."""

SLOWEST_EDGE = 0.08
"""Longest time in which a plate's force passes between its threshold and :data:`EDGE_LEVEL` [s]."""

EDGE_LEVEL = 0.25
"""Force at the upper end of an edge, of the greatest on the plates; a foot that comes down or
leaves passes it in 10 to 60 ms, another foot on the plate or a drifting plate makes it creep."""

TOE_TIP = 0.2
"""How far the foot reaches beyond the toe point, of its length from heel to toe point."""

PELVIS_FOLLOWS = 0.1
"""Least way of the pelvis during a swing, of the foot's way; 0.4 in steady walking."""

LONGEST_GAP = 0.1
"""Longest gap of a marker that is closed before looking for events [s]."""

CUTOFF = 12.0
"""Low-pass of the foot's points [Hz]; lower where the frame rate is too low for it."""


def detect_gait_events(
    time: Float[Array, " n_frames"],
    heel: Float[Array, "n_frames 2 3"],
    toe: Float[Array, "n_frames 2 3"],
    pelvis: Float[Array, "n_frames 3"] | None = None,
    *,
    cutoff: float = CUTOFF,
) -> tuple[GaitEvent, ...]:
    """Return the heel strikes and toe offs of both feet, by time, from the motion alone.

    See the module's text for the method. Near the ends of what was seen of a foot, a heel strike
    is reported if the foot is seen to come in at no less than a quarter of the usual peak speed,
    a toe off if it is seen to reach at least half of it.

    Args:
        time: Time of each frame [s], evenly spaced.
        heel: Back of the heel, left then right, world [m]; NaN where not seen.
        toe: Toe tip or head of the second metatarsal, left then right, world [m].
        pelvis: A point of the pelvis [m]; where given, a foot that is put elsewhere while the
            pelvis stays (sitting, standing) does not count as a step.
        cutoff: Low-pass of the points before differentiation [Hz].

    Returns:
        Events by time; none for standing, squatting, jumping, hopping and kicking.

    Raises:
        ParameterError: If the arrays do not have one frame per time, or time does not increase.
    """
    _check(time, heel, toe, pelvis)
    if len(time) < 8:
        return ()
    feet = _smooth(time, np.stack([heel, toe], axis=2), cutoff)
    ground = ground_velocity(time, heel, toe, cutoff=cutoff)
    speeds = np.linalg.norm(derivative(time, feet) - ground[:, None, None], axis=-1)
    speed = speeds.min(axis=2)  # (n_frames, 2), NaN if either end is hidden
    way = _travel(time, ground)
    middle = feet.mean(axis=2)[..., :2] - way[:, None, :2]
    body = None
    if pelvis is not None:
        body = fill_gaps(time, pelvis[:, :2], longest=1.0) - way[:, :2]
    lengths = np.linalg.norm(feet[:, :, 0] - feet[:, :, 1], axis=-1)
    length = float(np.nanmedian(lengths)) if np.isfinite(lengths).any() else np.nan
    if not length > 0:
        return ()

    height = feet[..., 2].min(axis=2) - way[:, None, 2]
    swings = [_swings(time, speed[:, k], middle[:, k], height[:, k], length) for k in (0, 1)]
    peaks = [s.peak for side in swings for s in side if s.whole]
    usual = float(np.median(peaks)) if peaks else np.nan
    steps: list[tuple[int, _Swing]] = []
    for k in (0, 1):
        for swing in swings[k]:
            if not swing.whole:
                swing = _judge_cut(time, speed[:, k], swing, usual)
            if (
                swing is not None
                and _other_stands(time, speed[:, 1 - k], swing, usual)
                and _pelvis_follows(time, body, middle[:, k], swing)
            ):
                steps.append((k, swing))
    events = []
    for k, swing in _alternating(_apart(steps), speed):
        if swing.start is not None:
            events.append(GaitEvent(float(swing.start), SIDES[k], "toe_off"))
        if swing.stop is not None:
            events.append(GaitEvent(float(swing.stop), SIDES[k], "heel_strike"))
    return tuple(sorted(events, key=lambda event: (event.time, event.side)))


def ground_velocity(
    time: Float[Array, " n_frames"],
    heel: Float[Array, "n_frames 2 3"],
    toe: Float[Array, "n_frames 2 3"],
    *,
    cutoff: float = CUTOFF,
) -> Float[Array, "n_frames 3"]:
    """Return the velocity of the ground under the feet [m/s]: zero overground, the belt's else.

    It is the velocity that the feet's points share most often (the densest spot of their
    velocities). On a treadmill it is followed through the recording, so that a belt that changes
    its speed, or slopes, is followed too.

    Args:
        time: Time of each frame [s].
        heel: Back of the heel, left then right, world [m].
        toe: Toe tip or metatarsal head, left then right, world [m].
        cutoff: Low-pass of the points before differentiation [Hz].
    """
    still = np.zeros((len(time), 3))
    if len(time) < 8:
        return still
    velocity = derivative(time, _smooth(time, np.stack([heel, toe], axis=2), cutoff))
    samples = velocity.reshape(len(time), -1, 3)
    seen = np.isfinite(samples).all(axis=2)
    common = _densest(samples[seen])
    if common is None or np.linalg.norm(common) < SLOWEST_BELT:
        return still
    # Follow the belt: the densest spot among the samples of two seconds to either side.
    centres = np.arange(time[0], time[-1] + 0.5, 0.5)
    followed = []
    for centre in centres:
        near = (np.abs(time - centre) <= 2.0)[:, None] & seen
        spot = _densest(samples[near]) if near.sum() > 50 else None
        lost = spot is None or np.linalg.norm(spot - common) > 0.5 * np.linalg.norm(common)
        followed.append(common if lost else spot)
    followed = np.array(followed)
    return np.stack([np.interp(time, centres, followed[:, i]) for i in range(3)], axis=1)


@dataclass(frozen=True)
class PlateContact:
    """One loading of a force plate.

    Attributes:
        start: When the force rose through the threshold [s]; None if loaded from the first sample.
        stop: When it fell through it [s]; None if still loaded at the last sample.
        peak: Greatest vertical force [N].
    """

    start: float | None
    stop: float | None
    peak: float


def contact_events(
    time: Float[Array, " n_samples"],
    vertical_force: Float[Array, " n_samples"],
    threshold: float = 20.0,
    *,
    shortest: float = 0.08,
) -> tuple[PlateContact, ...]:
    """Return when a plate was loaded.

    The force is smoothed (50 Hz, no lag) so that noise around the threshold makes no contacts, and
    a plate's offset is taken out: the value it rests at, if that is within the threshold.

    Args:
        time: Time of each sample [s].
        vertical_force: Force of the ground on the body, upward positive [N].
        threshold: Force that counts as contact [N].
        shortest: Contacts shorter than this are knocks, gaps shorter than a quarter of it are
            noise [s].

    Raises:
        ParameterError: If the threshold is not positive.
    """
    if not threshold > 0:
        raise ParameterError(f"{threshold=} [N] must be positive")
    if len(time) < 4:
        return ()
    force = np.nan_to_num(np.asarray(vertical_force, dtype=float))
    rate = rate_of(time)
    if rate > 250:
        force = lowpass(time, force, cutoff=50.0)
    low = force[force < threshold]
    if len(low) > 0.05 * len(force):
        force = force - np.median(low)
    loaded = force > threshold
    for gap in runs(~loaded):
        if 0 < gap.start and gap.stop < len(loaded):
            if time[gap.stop] - time[gap.start] < shortest / 4:
                loaded[gap] = True
    contacts = []
    for on in runs(loaded):
        first, last = on.start, on.stop - 1
        if time[last] - time[first] < shortest and first > 0 and last < len(time) - 1:
            continue
        start = _between(time, force, first - 1, threshold) if first > 0 else None
        stop = _between(time, force, last, threshold) if last < len(time) - 1 else None
        contacts.append(PlateContact(start, stop, float(force[on].max())))
    return tuple(contacts)


def plate_events(
    plates: Sequence[ForcePlate],
    time: Float[Array, " n_frames"],
    heel: Float[Array, "n_frames 2 3"],
    toe: Float[Array, "n_frames 2 3"],
    *,
    threshold: float = 20.0,
    margin: float = 0.02,
) -> tuple[GaitEvent, ...]:
    """Return the heel strikes and toe offs that force plates saw whole.

    A contact belongs to the foot that is nearest its centre of pressure. It gives a heel strike
    only where the heel came down inside the plate, a toe off only where the toe tip left inside it,
    and neither while the other foot is on the same plate: a partial hit would be late or early.
    Nor is there an event where the force creeps through the threshold (:data:`SLOWEST_EDGE`): a
    foot that comes down or leaves changes it fast, so something else was on the plate as well.

    Args:
        plates: Measured ground reactions. A plate without corners is taken as large enough; one
            that names its foot is believed.
        time: Time of each marker frame [s].
        heel: Back of the heel, left then right, world [m].
        toe: Toe tip or metatarsal head, left then right, world [m].
        threshold: Force that counts as contact [N]; more on a plate whose record reads below rest
            by more than a fifth of it, as filtered records do.
        margin: How far outside the plate's edge a marker may be, for markers stand off the foot
            [m].
    """
    _check(time, heel, toe, None)
    contacts = []
    for plate in plates:
        force = plate.force[:, 2]
        contacts.append(contact_events(plate.time, force, _above_noise(force, threshold)))
    peaks = [contact.peak for found in contacts for contact in found]
    upper = max(2 * threshold, EDGE_LEVEL * max(peaks, default=0.0))
    tip = toe + TOE_TIP * (toe - heel)
    events = []
    for plate, found in zip(plates, contacts, strict=True):
        for contact in found:
            side = plate.side or _foot_on(plate, contact, time, heel, toe)
            if side is None:
                continue
            own, other = SIDES.index(side), 1 - SIDES.index(side)
            ends = ((contact.start, heel, "heel_strike", 1), (contact.stop, tip, "toe_off", -1))
            for instant, point, kind, direction in ends:
                if instant is None or not time[0] <= instant <= time[-1]:
                    continue
                frame = int(np.argmin(np.abs(time - instant)))
                if plate.side is None and (
                    not _inside(plate.corners, point[frame, own], margin)
                    or _is_on(plate.corners, time, heel, toe, frame, other)
                ):
                    continue
                if _is_steep(plate, instant, direction, upper):
                    events.append(GaitEvent(instant, side, kind))
    return tuple(sorted(events, key=lambda event: (event.time, event.side)))


def _above_noise(force, threshold):
    """Return the threshold, raised where the plate's own record is not good for it [N].

    The ground cannot pull: how far the force reads below rest is the error of the record near
    the edges (noise, or the ringing that a low-pass filter leaves beside every edge).
    """
    low = force[np.isfinite(force) & (force < threshold)]
    if len(low) == 0:
        return threshold
    below = np.median(low) - np.percentile(low, 1)
    return float(np.clip(PULL_FACTOR * below, threshold, MOST_RAISED * threshold))


def _is_on(corners, time, heel, toe, frame, side):
    """Say whether an end of a foot rests inside a plate."""
    return any(
        _inside(corners, p[frame, side], -1e-9) and _rests(time, p, frame, side)
        for p in (heel, toe)
    )


def _is_steep(plate, instant, direction, upper):
    """Say whether the force passes from threshold to `upper` fast, in time's direction or against.

    True as well where the plate's record ends too soon to tell.
    """
    since = direction * (plate.time - instant)
    if since.max() < SLOWEST_EDGE:
        return True
    inside = (since >= 0) & (since <= SLOWEST_EDGE)
    return bool((plate.force[inside, 2] >= upper).any())


@dataclass(frozen=True)
class _Swing:
    """A hump of the foot's speed: frames `first` to `last`, events None where cut off."""

    first: int
    last: int
    start: float | None
    stop: float | None
    peak: float

    @property
    def whole(self):
        return self.start is not None and self.stop is not None


def _swings(time, speed, middle, height, length):
    """Return the humps of `speed` that are steps, whole or cut by the ends of a stretch."""
    found = []
    for stretch in runs(np.isfinite(speed)):
        s = speed[stretch]
        if len(s) < 5:
            continue
        taken = np.zeros(len(s), dtype=bool)
        for top in np.argsort(-s, kind="stable").tolist():
            peak = s[top]
            if peak < SLOWEST_SWING:
                break
            if taken[top]:
                continue
            low = np.flatnonzero(s[:top] < TOE_OFF_FRACTION * peak)
            high = np.flatnonzero(s[top:] < HEEL_STRIKE_FRACTION * peak)
            left = int(low[-1]) if len(low) else -1
            right = int(top + high[0]) if len(high) else len(s)
            clash = taken[max(left, 0) : right].any()
            # The skirt of a higher hump is no hump: it must come down to stance on both sides.
            taken[max(left, 0) : min(right + 1, len(s))] = True
            if clash:
                continue
            start = stop = None
            offset = stretch.start
            if left >= 0:
                start = _between(time, speed, offset + left, TOE_OFF_FRACTION * peak)
            if right < len(s):
                stop = _between(time, speed, offset + right - 1, HEEL_STRIKE_FRACTION * peak)
            last = offset + min(right, len(s) - 1)
            found.append(_Swing(offset + max(left, 0), last, start, stop, float(peak)))
    found = _joined(sorted(found, key=lambda swing: swing.first))
    return [s for s in found if not s.whole or _carries(s, middle, height, length)]


def _joined(swings):
    """Return the swings with those made one between which the foot did not really stand."""
    joined: list[_Swing] = []
    for swing in swings:
        before = joined[-1] if joined else None
        if (
            before is not None
            and before.whole
            and swing.whole
            and swing.start - before.stop < SHORTEST_STANCE
        ):
            peak = max(before.peak, swing.peak)
            swing = _Swing(before.first, swing.last, before.start, swing.stop, peak)
            joined.pop()
        joined.append(swing)
    return joined


def _carries(swing, middle, height, length):
    """Say whether a whole swing puts the foot elsewhere, further than it lifts it."""
    way = np.linalg.norm(middle[swing.last] - middle[swing.first])
    ends = max(height[swing.first], height[swing.last])
    lift = np.max(height[swing.first : swing.last + 1]) - ends
    return (
        way >= LEAST_WAY * length
        and lift <= MOST_LIFT * way
        and swing.stop - swing.start >= SHORTEST_SWING
    )


def _apart(steps):
    """Return the steps (foot, swing) without those that end as the other foot lands.

    The foot that was away for the shorter time only closed up to the other.
    """
    return [
        (k, swing)
        for k, swing in steps
        if not any(
            other != k
            and swing.stop is not None
            and longer.stop is not None
            and abs(swing.stop - longer.stop) < SHORTEST_STEP
            and swing.last - swing.first <= longer.last - longer.first
            for other, longer in steps
        )
    ]


def _alternating(steps, speed):
    """Return the steps (foot, swing) without those that the same foot took before and after.

    Where the other foot was hidden between them it may have stepped.
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


def _judge_cut(time, speed, swing, usual):
    """Return a swing cut off by the end of a stretch with what can be said of it, or None."""
    if swing.start is None and swing.stop is None:
        return None
    if not np.isfinite(usual):
        # No whole swing to compare with: its own peak must lie inside what was seen.
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
        stop = _between(time, speed, k, HEEL_STRIKE_FRACTION * peak)
        return _Swing(swing.first, swing.last, None, stop, float(peak))
    if swing.peak < 0.5 * usual:
        return None
    first = swing.first
    below = np.flatnonzero(s[:top] < TOE_OFF_FRACTION * peak)
    if len(below) == 0:
        return None
    start = _between(time, speed, first + int(below[-1]), TOE_OFF_FRACTION * peak)
    return _Swing(first, swing.last, start, None, float(peak))


def _other_stands(time, other, swing, usual):
    """Say whether the other foot stood for part of the swing; True where it was not seen."""
    start = time[swing.first] if swing.start is None else swing.start
    stop = time[swing.last] if swing.stop is None else swing.stop
    inside = (time >= start) & (time <= stop) & np.isfinite(other)
    if not inside.any():
        return True
    reference = usual if np.isfinite(usual) else swing.peak
    stands = other < TOE_OFF_FRACTION * reference
    flights = runs(inside & ~stands)
    longest = max((time[f.stop - 1] - time[f.start] for f in flights), default=0.0)
    return bool(np.mean(stands[inside]) >= OTHER_FOOT_STANDS and longest <= LONGEST_FLIGHT)


def _pelvis_follows(time, body, middle, swing):
    if body is None:
        return True
    way = np.linalg.norm(middle[swing.last] - middle[swing.first])
    moved = np.linalg.norm(body[swing.last] - body[swing.first])
    return not moved < PELVIS_FOLLOWS * way  # NaN says nothing against it


def _smooth(time, points, cutoff):
    rate = rate_of(time)
    return lowpass(time, fill_gaps(time, points, longest=LONGEST_GAP), cutoff=min(cutoff, rate / 4))


def _travel(time, velocity):
    """Return how far the ground has moved since the first frame."""
    steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time)[:, None]
    return np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])


def _densest(samples, radius=0.15):
    """Return the densest spot of a cloud of velocities, or None for an empty cloud."""
    if len(samples) == 0:
        return None
    samples = samples[:: max(1, len(samples) // 800)]
    apart = np.linalg.norm(samples[:, None] - samples[None], axis=-1)
    spot = samples[np.argmax((apart < radius).sum(axis=1))]
    for _ in range(5):
        spot = samples[np.linalg.norm(samples - spot, axis=1) < radius].mean(axis=0)
    return spot


def _between(time, signal, k, level):
    """Return the instant between samples k and k + 1 at which the signal passes the level."""
    a, b = signal[k], signal[k + 1]
    part = 0.5 if a == b else float(np.clip((level - a) / (b - a), 0.0, 1.0))
    return float(time[k] + part * (time[k + 1] - time[k]))


def _foot_on(plate, contact, time, heel, toe):
    """Return the side whose foot is nearest the centre of pressure while the plate is loaded."""
    start = plate.time[0] if contact.start is None else contact.start
    stop = plate.time[-1] if contact.stop is None else contact.stop
    instants = np.linspace(start, stop, 11)[2:-2]
    best, side = np.inf, None
    for k, name in enumerate(SIDES):
        apart = []
        for instant in instants:
            frame = int(np.argmin(np.abs(time - instant)))
            cop = plate.cop[int(np.argmin(np.abs(plate.time - instant))), :2]
            a, b = heel[frame, k, :2], toe[frame, k, :2]
            along = b - a
            part = np.clip((cop - a) @ along / max(along @ along, 1e-9), 0.0, 1.0)
            apart.append(np.linalg.norm(cop - a - part * along))
        apart = np.array(apart)
        if np.isfinite(apart).any() and np.nanmedian(apart) < best:
            best, side = float(np.nanmedian(apart)), name
    return side if best < 0.3 else None


def _inside(corners, point, margin):
    """Say whether a point is over the plate, grown by the margin; True without corners."""
    if corners is None:
        return margin >= 0
    p, c = point[:2], corners[:, :2]
    if not np.isfinite(p).all():
        return False
    centre = c.mean(axis=0)
    for a, b in zip(c, np.roll(c, -1, axis=0), strict=True):
        edge = b - a
        normal = np.array([edge[1], -edge[0]]) / np.linalg.norm(edge)
        if normal @ (centre - a) > 0:
            normal = -normal
        if normal @ (p - a) > margin:
            return False
    return True


def _rests(time, point, frame, side):
    a, b = max(frame - 2, 0), min(frame + 2, len(time) - 1)
    way = np.linalg.norm(point[b, side] - point[a, side])
    return bool(way < 0.3 * (time[b] - time[a]))


def _check(time, heel, toe, pelvis):
    if len(time) > 1 and not (np.diff(time) > 0).all():
        raise ParameterError("time must increase from frame to frame")
    for name, values in (("heel", heel), ("toe", toe), ("pelvis", pelvis)):
        if values is not None and len(values) != len(time):
            raise ParameterError(
                f"{name} has {len(values)} frames for {len(time)} instants: one frame per instant"
            )

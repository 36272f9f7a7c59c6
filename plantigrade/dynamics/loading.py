r"""Intervals in which feet and a seat carry load, detected from the motion.

**Feet.** In gait a foot is loaded from heel strike to toe-off, except where it is lifted in
between. Without gait events the height of its sole decides: a foot is in the air while its lowest
point is :data:`MIN_AIR_HEIGHT` above its support level, if it reaches :data:`MIN_FLIGHT_HEIGHT` in
that flight; the timing error of landings and take-offs of a jump is about 10 ms. The support level
is the ground or a box: a raised level on which a foot rests while the other foot is off the ground.

**Seat.** A person sits while the thighs are about level, the pelvis is at rest, and the feet alone
cannot supply the required wrench, because its zero-moment point is outside their base of support.
The seat carries load while the ischia are less than :data:`SEAT_COMPRESSION`, the compression of
cushion and buttocks, above their height at rest.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import LEVEL_GROUND, Ground
from plantigrade.contact.intervals import ContactInterval, grouped
from plantigrade.contact.limb_sites import ISCHIAL_DISTANCE, SEATED_PELVIS_TILT, seat_sites
from plantigrade.dynamics.centroid import centroid
from plantigrade.kinematics.contacts import stances
from plantigrade.kinematics.sole_paths import SitePoints, SolePaths, sole_paths
from plantigrade.kinematics.sole_rests import (
    MAX_REST_HEIGHT,
    MAX_REST_SPEED,
    STILL_SPEED,
    point_speed,
)
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.motion.event_timing import is_running
from plantigrade.motion.filters import crossing, runs
from plantigrade.motion.motion import Motion
from plantigrade.spatial.conventions import unit_vectors

# [1] ratio of the frequencies of running and jumps to those of walking, 15 to 6 Hz (see analyse)
RUNNING_FREQUENCY_RATIO = 2.5
RUNNING_STANCE = 0.30  # [s] stance of a run with these frequencies, at about 3 m/s

MIN_AIR_HEIGHT = 0.010  # [m] minimum height of the lowest point of a foot in the air
MIN_FLIGHT_HEIGHT = 0.030  # [m] minimum peak of this height in a flight
MIN_DURATION = 0.06  # [s] minimum duration of flights and contacts; shorter ones are noise
MIN_JUMP_TIME = 0.08  # [s] minimum time with both feet off the ground in a jump
MIN_BOX_REST = 0.3  # [s] minimum rest of a foot on a box

MAX_SEATED_RISE = 0.75  # [1] maximum height of the hip above the knee in sitting, in thigh lengths
MAX_SEATED_SPEED = 0.15  # [m/s] maximum speed of the pelvis in sitting
MIN_SEATED_TIME = 0.25  # [s] minimum rest on a seat
ZMP_MARGIN = 0.03  # [m] distance of the zero-moment point from the soles that requires a seat
SEAT = "seat"  # name of the support
SEAT_REACH = 0.12  # [1] extent of the contact before and behind the ischia, relative to stature
SEAT_COMPRESSION = 0.03  # [m] height of the ischia above their rest at which the seat unloads
EARLY_LOAD = 0.010  # [s] time before the detected heel strike at which load may begin
LATE_LOAD = 0.015  # [s] time after the detected toe-off at which load may end
USUAL_STANCE = 0.65  # [s] duration of a stance if none is complete in the recording
# [1] duration of a double support relative to a stance, 11 and 61 % of a gait cycle, including
# EARLY_LOAD and LATE_LOAD
DOUBLE_SUPPORT_RATIO = 0.21


@dataclass(frozen=True)
class Support:
    """A support other than the feet, such as the seat of a chair."""

    name: str  #: Name of the support
    body: str  #: Supported segment
    #: Middle of the contact in that segment's frame [m]
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    #: Maximum distance of the centre of pressure from there, forward or backward and to either side
    #: [m]
    reach: tuple[float, float] = (0.15, 0.15)


@dataclass(frozen=True)
class Loading:
    """Contact intervals and supports of a person."""

    #: Intervals in which feet and seat (:data:`SEAT`) may carry load
    contacts: tuple[ContactInterval, ...]
    supports: tuple[Support, ...]  #: The seat, if there is one
    flies: bool  #: Whether the person runs or jumps, with fast loading and unloading

    @property
    def walks(self) -> bool:
        """Whether feet roll as in walking."""
        return any(contact.rolls for contact in self.contacts)

    @property
    def pace(self) -> float:
        """Ratio of the motion's frequencies to those of walking [1].

        Those of running are proportional to the inverse of the stance time.
        """
        if not self.flies:
            return 1.0
        return RUNNING_FREQUENCY_RATIO * (
            RUNNING_STANCE / usual_length(self.contacts) if self.walks else 1.0
        )


def find_loading(human: Human, motion: Motion, ground: Ground = LEVEL_GROUND) -> Loading:
    """Return contact intervals and supports of a motion.

    Args:
        motion: The motion, filtered; a seat is detected only with accelerations.
    """
    time, soles = motion.time, sole_paths(human, motion.qpos, ground)
    seat = seat_intervals(human, motion)
    supports = (seat_support(human),) if seat else ()
    if motion.events and is_running(motion.events):
        steps = walking_intervals(
            motion,
            early=EARLY_LOAD / RUNNING_FREQUENCY_RATIO,
            late=LATE_LOAD / RUNNING_FREQUENCY_RATIO,
        )
        return Loading((*steps, *seat), supports, True)
    loaded, levels = on_the_ground(time, soles)
    steps, found = [step for step in walking_intervals(motion) if step.rolls], []
    for k, side in enumerate(SIDES):
        low = soles.lowest(side)
        flat = [*_intervals(time, loaded[:, k], low - levels[:, k], side, "sole")]
        own = [step for step in steps if step.side == side]
        found += [part for step in own for part in _set_down_again(step, flat)] if own else flat
    flies = not motion.events and leaves_the_ground(time, soles)
    return Loading((*found, *seat), supports, flies)


def seat_support(human: Human) -> Support:
    """Return the seat with its contact between the ischia and the reach around it."""
    right, left = seat_sites(human)
    middle = 0.5 * (np.array(right.position) + np.array(left.position))
    middle -= right.radius * np.array([np.sin(SEATED_PELVIS_TILT), 0.0, np.cos(SEATED_PELVIS_TILT)])
    x, y, z = (float(each) for each in middle)
    reach = SEAT_REACH * human.height, ISCHIAL_DISTANCE * human.height
    return Support(SEAT, "pelvis", (x, y, z), reach)


def leaves_the_ground(time: Float[Array, " n_frames"], soles: SolePaths) -> bool:
    """Return whether there is a flight phase, as in a jump."""
    return bool(flights(time, soles))


def flights(time: Float[Array, " n_frames"], soles: SolePaths) -> tuple[tuple[float, float], ...]:
    """Return start and end of the flight phases [s]."""
    loaded, _ = on_the_ground(time, soles)
    air = runs(np.asarray(~loaded.any(axis=1)))
    spans = ((float(time[run.start]), float(time[run.stop - 1])) for run in air)
    return tuple((start, stop) for start, stop in spans if stop - start >= MIN_JUMP_TIME)


def on_the_ground(
    time: Float[Array, " n_frames"], soles: SolePaths
) -> tuple[Bool[Array, "n_frames 2"], Float[Array, "n_frames 2"]]:
    """Return loaded frames of the feet (right, left) and the level below them [m].

    Args:
        time: Time of each frame [s].
    """
    n = len(time)
    low, speed = np.empty((n, 2)), np.empty((n, 2))
    for k, side in enumerate(SIDES):
        index = soles.of(side)
        height = soles.position[:, index, 2]
        lowest = height.argmin(axis=1)
        each = np.stack([point_speed(time, soles.position[:, i]) for i in index], axis=1)
        low[:, k], speed[:, k] = height.min(axis=1), each[np.arange(n), lowest]
    loaded, ground = np.zeros((n, 2), dtype=bool), np.zeros((n, 2))
    for k in (0, 1):
        near = np.abs(low[:, k]) < MAX_REST_HEIGHT
        level = float(np.median(low[near, k])) if near.any() else 0.0
        ground[:, k] = level
        air = low[:, k] - level > MIN_AIR_HEIGHT
        for run in runs(air):
            air[run] = low[run, k].max() - level > MIN_FLIGHT_HEIGHT
        loaded[:, k] = _without_short(time, ~air)
    floor = loaded.copy()
    for k in (0, 1):
        for run in runs((speed[:, k] < MAX_REST_SPEED) & ~floor[:, k]):
            rests = runs(speed[run, k] < STILL_SPEED)
            longest = max((time[run][r.stop - 1] - time[run][r.start] for r in rests), default=0.0)
            alone = ~floor[run, 1 - k]
            if longest >= MIN_BOX_REST and alone.sum() > 0.5 * len(alone):
                loaded[run, k], ground[run, k] = True, np.median(low[run, k])
    return loaded, ground


def seat_intervals(human: Human, motion: Motion) -> tuple[ContactInterval, ...]:
    """Return the intervals in which a seat carries load.

    Args:
        motion: The motion; without accelerations there are no intervals.
    """
    time = motion.time
    if motion.qacc is None or len(time) < 4:
        return ()
    joints = PointSet(human, ["femur_r", "femur_l", "tibia_r", "tibia_l"], np.zeros((4, 3)))
    hip, knee = np.split(joints.path(motion.qpos), 2, axis=1)
    rise = (hip[..., 2] - knee[..., 2]).max(axis=1)
    calm = point_speed(time, hip.mean(axis=1)) < MAX_SEATED_SPEED
    rests = [
        run
        for run in runs((rise < MAX_SEATED_RISE * human.dimensions.thigh) & calm)
        if time[run.stop - 1] - time[run.start] >= MIN_SEATED_TIME
    ]
    if not rests:
        return ()
    outside = _beyond_feet(human, motion, sole_paths(human, motion.qpos))
    ischia = SitePoints(human, seat_sites(human))
    height = (ischia.path(motion.qpos)[..., 2] - ischia.radius).mean(axis=1)
    found: list[ContactInterval] = []
    for run in rests:
        above = height - float(np.median(height[run])) - SEAT_COMPRESSION + MIN_AIR_HEIGHT
        low = above <= MIN_AIR_HEIGHT
        for part in runs(low):
            at_rest = slice(max(part.start, run.start), min(part.stop, run.stop))
            low[part] = at_rest.start < at_rest.stop and outside[at_rest].mean() > 0.5
        found += _intervals(time, low, above, "", SEAT)
    return tuple(_joined(found))


def _beyond_feet(human: Human, motion: Motion, soles: SolePaths) -> Bool[Array, " n_frames"]:
    """Return the frames with the zero-moment point outside the rectangle around both soles."""
    assert motion.qacc is not None
    point = centroid(human, motion.qpos, motion.qvel, motion.qacc).zmp
    assert point is not None
    heading = unit_vectors(np.mean([_heading(soles, side) for side in SIDES], axis=0))
    across = np.stack([-heading[:, 1], heading[:, 0]], axis=1)
    outside = np.zeros(len(point), dtype=bool)
    for axis in (heading, across):
        place = np.einsum("nkj,nj->nk", soles.position[..., :2], axis)
        at = np.einsum("nj,nj->n", point[:, :2], axis)
        with np.errstate(invalid="ignore"):
            outside |= (at < place.min(axis=1) - ZMP_MARGIN) | (at > place.max(axis=1) + ZMP_MARGIN)
    return outside


def _heading(soles: SolePaths, side: str) -> Float[Array, "n_frames 2"]:
    """Return the horizontal vector of a foot from heel to toes."""
    toes, heel = (
        soles.position[:, soles.of(side, region), :2].mean(axis=1) for region in ("toes", "heel")
    )
    return toes - heel


def _set_down_again(
    step: ContactInterval, flat: Sequence[ContactInterval]
) -> Iterator[ContactInterval]:
    """Yield the parts of a step whose foot is lifted in it, as onto a rung; else the step itself.

    Args:
        flat: Intervals in which the sole is down.
    """
    inside = [each for each in flat if each.stop > step.start and each.start < step.stop]
    if len(inside) < 2:
        yield step
        return
    first, *others, last = inside
    yield replace(step, stop=first.stop, ends=True)
    yield from others
    yield replace(last, stop=step.stop, ends=step.ends)


def _joined(intervals: list[ContactInterval]) -> Iterator[ContactInterval]:
    """Yield intervals in order, merging those that overlap."""
    for group in grouped(intervals):
        last = max(group, key=lambda c: c.stop)
        yield replace(group[0], stop=last.stop, ends=last.ends)


def _without_short(time, loaded):
    """Return the frames without flights and contacts that are too short."""
    for value in (False, True):
        for run in runs(loaded == value):
            inner = run.start > 0 and run.stop < len(time)
            if inner and time[run.stop] - time[run.start] < MIN_DURATION:
                loaded[run] = not value
    return loaded


def _intervals(time, loaded, above, side, region) -> Iterator[ContactInterval]:
    """Yield intervals of frames, with ends where ``above`` crosses :data:`MIN_AIR_HEIGHT`."""
    for run in runs(loaded):
        begins, ends = run.start > 0, run.stop < len(time)
        start, stop = float(time[run.start]), float(time[run.stop - 1])
        if begins and above[run.start - 1] > MIN_AIR_HEIGHT >= above[run.start]:
            start = crossing(time, above, run.start - 1, MIN_AIR_HEIGHT)
        if ends and above[run.stop] > MIN_AIR_HEIGHT >= above[run.stop - 1]:
            stop = crossing(time, above, run.stop - 1, MIN_AIR_HEIGHT)
        if stop > start:
            yield ContactInterval(side, region, start, stop, begins, ends)


def walking_intervals(
    motion: Motion, *, early: float = EARLY_LOAD, late: float = LATE_LOAD
) -> tuple[ContactInterval, ...]:
    """Return the stances of a gait from its events, slightly extended at both ends.

    A foot without events stands throughout, flat.

    Args:
        motion: The motion with its events.
        early: Extension before heel strike [s].
        late: Extension after toe-off [s].
    """
    first, last = float(motion.time[0]), float(motion.time[-1])
    events = sorted(motion.events, key=lambda e: e.time)
    found = []
    for side in SIDES:
        if not any(event.side == side for event in events):
            found.append(ContactInterval(side, "sole", first, last, False, False))
            continue
        for each in stances(events, side, first, last):
            begins, ends = bool(each.start > first), bool(each.stop < last)
            start = each.start - early if begins else each.start
            stop = each.stop + late if ends else each.stop
            found.append(ContactInterval(side, "foot", start, stop, begins, ends))
    return tuple(found)


def usual_length(intervals: tuple[ContactInterval, ...]) -> float:
    """Return the median duration of the complete contacts [s]."""
    whole = [c.stop - c.start for c in intervals if c.whole]
    return float(np.median(whole)) if whole else USUAL_STANCE


def completed(
    intervals: tuple[ContactInterval, ...], first: float, last: float
) -> tuple[ContactInterval, ...]:
    """Return stances cut by the recording in double support with their estimated ends.

    A foot that still stands after the other has landed leaves after the median double support of
    this recording, or after a usual one if there is none; correspondingly at the start. These
    instants lie outside the recording.

    Args:
        first: Start of the recording [s].
        last: End of the recording [s].
    """
    steps = [c for c in intervals if c.rolls]
    pairs = [(a, b) for a in steps for b in steps if a.side != b.side and b.begins and a.ends]
    seen = [a.stop - b.start for a, b in pairs if a.start < b.start < a.stop < b.stop]
    length = float(np.median(seen)) if seen else DOUBLE_SUPPORT_RATIO * usual_length(intervals)
    found = []
    for each in intervals:
        others = [c for c in steps if each in steps and c.side != each.side]
        landed = [c.start for c in others if c.begins and each.start < c.start and not c.ends]
        left = [c.stop for c in others if c.ends and c.stop < each.stop and not c.begins]
        if not each.ends and landed:
            each = replace(each, stop=max(landed[-1] + length, last), ends=True)
        if not each.begins and left:
            each = replace(each, start=min(left[0] - length, first), begins=True)
        found.append(each)
    return tuple(found)

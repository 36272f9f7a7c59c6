r"""When each foot carries load, and when a seat does: what the motion itself tells.

**Feet.** In gait a foot is loaded from heel strike to toe off. Without gait events the height of
its sole tells: a foot is in the air from when its lowest point is :data:`CLEAR` above what it stood
on, if it gets :data:`HIGH` in that flight; landings and take-offs of a jump are timed so to about
10 ms. What it stood on is the ground, or a box: a raised level is one on which a foot comes to rest
while the other is not on the ground (a foot held up beside a standing one stands on nothing).

**Seat.** A person sits while the thighs are about level, the pelvis is at rest, and the wrench that
the motion needs cannot come from the feet: its zero-moment point is outside their base of support.
The seat carries as long as the ischia are less than :data:`GIVE` above their height at rest, which
is what cushion and buttocks give way.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import LEVEL_GROUND, Ground
from plantigrade.contact.intervals import ContactInterval, grouped
from plantigrade.contact.seat import ISCHIAL_DISTANCE, SEATED_PELVIS_TILT, seat_sites
from plantigrade.dynamics.centroid import centroid
from plantigrade.dynamics.load_intervals import (
    EARLY,
    LATE,
    Support,
    usual_length,
    walking_intervals,
)
from plantigrade.kinematics.rests import NEAR, SLOW, STILL, point_speed
from plantigrade.kinematics.sole_paths import SitePoints, SolePaths, sole_paths
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.motion.event_timing import is_running
from plantigrade.motion.filters import crossing, runs

FASTER = 2.5  # running and jumps keep frequencies so much higher: 15 Hz, not 6 (see analyse)
RUNNING_STANCE = 0.30  # stance of a run with these frequencies, at about 3 m/s [s]

CLEAR = 0.010  # the lowest point of a foot in the air is higher than this [m] …
HIGH = 0.030  # … and at some time than this
SHORTEST = 0.06  # shorter flights and contacts are noise [s]
FLIGHT = 0.08  # both feet this long off the ground: a jump [s]
LONGEST_REST = 0.3  # a foot on a box rests this long at some time [s]

LEVEL = 0.75  # hip above knee, of the thigh's length: more is no sitting
CALM = 0.15  # a pelvis slower than this is at rest [m/s]
SITTING = 0.25  # shortest rest on a seat [s]
BESIDE = 0.03  # a zero-moment point further than this from the soles is not theirs [m]
SEAT = "seat"  # name of the support
REACH = 0.12  # of buttocks and thighs on a seat, before and behind the ischia, of stature
GIVE = 0.03  # the seat lets go when the ischia are this much above their rest [m]


@dataclass(frozen=True)
class Loading:
    """What carries a person, and when.

    Attributes:
        contacts: When each foot may carry load, and when a seat does (:data:`SEAT`).
        supports: The seat, where there is one.
        flies: Whether the person runs or jumps, so that load comes and goes fast.
    """

    contacts: tuple[ContactInterval, ...]
    supports: tuple[Support, ...]
    flies: bool

    @property
    def walks(self) -> bool:
        """Whether feet roll as in walking."""
        return any(contact.rolls for contact in self.contacts)

    @property
    def pace(self) -> float:
        """How many times higher the frequencies of the motion are than in walking.

        Those of running go with the inverse of the time on the ground.
        """
        if not self.flies:
            return 1.0
        return FASTER * (RUNNING_STANCE / usual_length(self.contacts) if self.walks else 1.0)


def find_loading(human: Human, motion: Motion, ground: Ground = LEVEL_GROUND) -> Loading:
    """Return when feet and seat may carry in a motion.

    Args:
        human: The person.
        motion: Their motion, filtered; accelerations tell of a seat.
        ground: What the feet stand on.
    """
    time, soles = motion.time, sole_paths(human, motion.qpos, ground)
    seat = seat_intervals(human, motion)
    supports = (seat_support(human),) if seat else ()
    if motion.events and is_running(motion.events):
        steps = walking_intervals(motion, early=EARLY / FASTER, late=LATE / FASTER)
        return Loading((*steps, *seat), supports, True)
    loaded, levels = on_the_ground(time, soles)
    found = [step for step in walking_intervals(motion) if step.rolls]
    for k, side in enumerate(SIDES):
        if not any(step.side == side for step in found):
            low = soles.position[:, soles.of(side), 2].min(axis=1)
            found += _intervals(time, loaded[:, k], low - levels[:, k], side, "sole")
    flies = not motion.events and leaves_the_ground(time, soles)
    return Loading((*found, *seat), supports, flies)


def seat_support(human: Human) -> Support:
    """Return the seat: between the ischia, with the reach of buttocks and thighs around it."""
    right, left = seat_sites(human)
    middle = 0.5 * (np.array(right.position) + np.array(left.position))
    middle -= right.radius * np.array([np.sin(SEATED_PELVIS_TILT), 0.0, np.cos(SEATED_PELVIS_TILT)])
    x, y, z = (float(each) for each in middle)
    reach = REACH * human.height, ISCHIAL_DISTANCE * human.height
    return Support(SEAT, "pelvis", (x, y, z), reach)


def leaves_the_ground(time: Float[Array, " n_frames"], soles: SolePaths) -> bool:
    """Return whether both feet are in the air together at some time, as in a jump."""
    return bool(flights(time, soles))


def flights(time: Float[Array, " n_frames"], soles: SolePaths) -> tuple[tuple[float, float], ...]:
    """Return from when to when both feet are in the air together, as in a jump [s]."""
    loaded, _ = on_the_ground(time, soles)
    air = runs(np.asarray(~loaded.any(axis=1)))
    spans = ((float(time[run.start]), float(time[run.stop - 1])) for run in air)
    return tuple((start, stop) for start, stop in spans if stop - start >= FLIGHT)


def on_the_ground(
    time: Float[Array, " n_frames"], soles: SolePaths
) -> tuple[Bool[Array, "n_frames 2"], Float[Array, "n_frames 2"]]:
    """Return when the soles tell that a foot is loaded (right, left), and the level under it [m].

    Args:
        time: Time of each frame [s].
        soles: The soles over the motion.
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
        near = np.abs(low[:, k]) < NEAR
        level = float(np.median(low[near, k])) if near.any() else 0.0
        ground[:, k] = level
        air = low[:, k] - level > CLEAR
        for run in runs(air):
            air[run] = low[run, k].max() - level > HIGH
        loaded[:, k] = _without_short(time, ~air)
    floor = loaded.copy()
    for k in (0, 1):
        for run in runs((speed[:, k] < SLOW) & ~floor[:, k]):
            rests = runs(speed[run, k] < STILL)
            longest = max((time[run][r.stop - 1] - time[run][r.start] for r in rests), default=0.0)
            alone = ~floor[run, 1 - k]
            if longest >= LONGEST_REST and alone.sum() > 0.5 * len(alone):
                loaded[run, k], ground[run, k] = True, np.median(low[run, k])
    return loaded, ground


def seat_intervals(human: Human, motion: Motion) -> tuple[ContactInterval, ...]:
    """Return when a seat carries; see the module's text.

    Args:
        human: The person.
        motion: Their motion, with accelerations; without them nobody is told to sit.
    """
    time = motion.time
    if motion.qacc is None or len(time) < 4:
        return ()
    joints = PointSet(human, ["femur_r", "femur_l", "tibia_r", "tibia_l"], np.zeros((4, 3)))
    hip, knee = np.split(joints.path(motion.qpos), 2, axis=1)
    rise = (hip[..., 2] - knee[..., 2]).max(axis=1)
    calm = point_speed(time, hip.mean(axis=1)) < CALM
    rests = [
        run
        for run in runs((rise < LEVEL * human.dimensions.thigh) & calm)
        if time[run.stop - 1] - time[run.start] >= SITTING
    ]
    if not rests:
        return ()
    outside = _beyond_feet(human, motion, sole_paths(human, motion.qpos))
    ischia = SitePoints(human, seat_sites(human))
    height = (ischia.path(motion.qpos)[..., 2] - ischia.radius).mean(axis=1)
    found: list[ContactInterval] = []
    for run in rests:
        above = height - float(np.median(height[run])) - GIVE + CLEAR
        low = above <= CLEAR
        for part in runs(low):
            at_rest = slice(max(part.start, run.start), min(part.stop, run.stop))
            low[part] = at_rest.start < at_rest.stop and outside[at_rest].mean() > 0.5
        found += _intervals(time, low, above, "", SEAT)
    return tuple(_joined(found))


def _beyond_feet(human: Human, motion: Motion, soles: SolePaths) -> Bool[Array, " n_frames"]:
    """Return where the zero-moment point is outside the rectangle around both soles."""
    assert motion.qacc is not None
    point = centroid(human, motion.qpos, motion.qvel, motion.qacc).zmp
    assert point is not None
    heading = np.mean([_heading(soles, side) for side in SIDES], axis=0)
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    across = np.stack([-heading[:, 1], heading[:, 0]], axis=1)
    outside = np.zeros(len(point), dtype=bool)
    for axis in (heading, across):
        place = np.einsum("nkj,nj->nk", soles.position[..., :2], axis)
        at = np.einsum("nj,nj->n", point[:, :2], axis)
        with np.errstate(invalid="ignore"):
            outside |= (at < place.min(axis=1) - BESIDE) | (at > place.max(axis=1) + BESIDE)
    return outside


def _heading(soles: SolePaths, side: str) -> Float[Array, "n_frames 2"]:
    """Return where a foot points, from its heel to its toes."""
    toes, heel = (
        soles.position[:, soles.of(side, region), :2].mean(axis=1) for region in ("toes", "heel")
    )
    return toes - heel


def _joined(intervals: list[ContactInterval]) -> Iterator[ContactInterval]:
    """Yield intervals in order, those that overlap as one."""
    for group in grouped(intervals):
        last = max(group, key=lambda c: c.stop)
        yield replace(group[0], stop=last.stop, ends=last.ends)


def _without_short(time, loaded):
    """Return the frames without flights and contacts that are too short."""
    for value in (False, True):
        for run in runs(loaded == value):
            inner = run.start > 0 and run.stop < len(time)
            if inner and time[run.stop] - time[run.start] < SHORTEST:
                loaded[run] = not value
    return loaded


def _intervals(time, loaded, above, side, region) -> Iterator[ContactInterval]:
    """Yield the spans of frames, their ends where the height ``above`` passes :data:`CLEAR`."""
    for run in runs(loaded):
        begins, ends = run.start > 0, run.stop < len(time)
        start, stop = float(time[run.start]), float(time[run.stop - 1])
        if begins and above[run.start - 1] > CLEAR >= above[run.start]:
            start = crossing(time, above, run.start - 1, CLEAR)
        if ends and above[run.stop] > CLEAR >= above[run.stop - 1]:
            stop = crossing(time, above, run.stop - 1, CLEAR)
        if stop > start:
            yield ContactInterval(side, region, start, stop, begins, ends)

"""One stride of a recorded walk, closed so that it can be repeated for ever."""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.distance import cdist

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.kinematics.leg_inverse import LegInverse
from plantigrade.kinematics.sole_paths import lowest, sole_paths
from plantigrade.kinematics.state import BodyState, body_paths
from plantigrade.models import Human
from plantigrade.models.mirror import mirror_sign, mirrored_name
from plantigrade.motion import Motion
from plantigrade.motion.cycles import MAX_CYCLE, MIN_CYCLE, cut_cycles
from plantigrade.motion.filters import runs
from plantigrade.spatial.conventions import (
    about_vertical,
    continuous,
    pelvis_angles_to_quaternion,
    pelvis_rates_to_free_joint,
    quaternion_to_pelvis_angles,
    turned,
)

MIN_RATE = 120.0  # [Hz] minimum frame rate of a stride
SEAM_SMOOTHING = 1.0 / 60.0  # [s] standard deviation of the Gaussian that smooths a closed stride
MAX_OPENING = np.deg2rad(10.0)
"""Maximum RMS difference of the hinges between both ends of a stride [rad]."""
MAX_TURN = np.deg2rad(6.0)
"""Maximum change of the pelvis heading in a straight stride [rad]; its SD over 70 strides of people
recorded walking straight ahead is 2°."""
MAX_SEARCH_DURATION = 10.0
"""Maximum duration of a motion that is searched for a stride without gait events [s]."""
SEARCH_RATE = 100.0  # [Hz] sampling rate of this search
RATE_WEIGHT = 0.1
"""Weight of joint rates relative to joint angles in the comparison of two instants [s]."""
WHOLE_MOTION_RATIO = 1.5
"""Maximum ratio of the distance of the motion's ends to the best pair for the whole motion to count
as a stride [1]."""
MIN_EXCURSION = 0.1  # [rad] minimum distance of the motion from these instants in between
MIN_EXCURSION_RATIO = 3.0  # [1] minimum ratio of this distance to the distance of the two instants
MAX_STANCE_SPEED = 0.25  # [m/s] maximum speed of a sole in stance
MIN_STANCE_TIME = 0.12  # [s] minimum duration of stance
MIN_SWING_TIME = 0.12  # [s] minimum duration of a swing; people's take 0.3 s and longer
MID_SWING = (0.25, 0.75)
"""Part of a swing in which a foot is raised to its clearance: the other foot is passed there, and
both ends stay as they are [1]."""
SOFT_DROP = 0.004
"""Distance by which the centre of mass of a softened stride is lower on average [m]: with 2 mm,
legs of the published mean walk are too short for its feet at toe-off; with 8 mm, knees stay bent by
14° or more (people: 5°)."""
MIN_TRAVEL = 0.2
"""Maximum speed of a motion on a belt [m/s] and minimum displacement with a direction [m]."""


@dataclass(frozen=True, eq=False)
class Stride:
    """Frames of a stride, or of a motion without one, along x from the origin, on level ground."""

    time: Float[Array, " n_rows"]  #: Times of the frames, from zero [s]
    #: Configurations; the last is the first again, a stride further on
    qpos: Float[Array, "n_rows nq"]
    qvel: Float[Array, "n_rows nv"]  #: Velocities
    length: float  #: How far a stride leads; zero where nothing is repeated [m]
    cyclic: bool  #: Whether it goes on for ever

    def motion(self, human: Human) -> Motion:
        """Return it as a motion of a person."""
        return Motion(self.time, self.qpos, self.qvel, human.joint_names)

    def from_single_support(self, human: Human) -> "Stride":
        """Return the same stride, begun where one foot passes the other.

        One foot carries the body there and no touchdown is near: a walk that begins shortly before
        a heel strike falls if that foot lands where the body does not need it. A stride in which
        feet do not pass each other, or that does not go on, is returned as it is.
        """
        feet = human.both("foot")
        right, left = body_paths(human, self.qpos, feet)[0][:, :, 0].T
        passing = np.flatnonzero(np.diff(np.sign(right - left)))
        if not self.cyclic or not len(passing) or passing[0] == 0:
            return self
        first, n = int(passing[0]), len(self.time) - 1
        order = np.concatenate([np.arange(first, n), np.arange(first + 1)])
        qpos = self.qpos[order]
        qpos[n - first :, 0] += self.length
        qpos[:, 0] -= qpos[0, 0]
        if np.sum(qpos[n - first, 3:7] * qpos[n - first - 1, 3:7]) < 0.0:
            qpos[n - first :, 3:7] *= -1.0
        return replace(self, qpos=qpos, qvel=self.qvel[order])

    def cleared(self, human: Human, clearance: float) -> "Stride":
        """Return the stride with the feet raised in mid-swing, by bending the legs.

        Each swing is raised by a squared sine of its course, which leaves toe-off and touchdown as
        they are, until every point of the sole is as high as asked in :data:`MID_SWING`. The toes
        of people pass level ground at 11 ± 6 mm, and ground with hidden obstacles at 27 ± 7 mm
        [Schulz2011]_.

        Args:
            clearance: Least height of the sole in mid-swing [m].

        Raises:
            ParameterError: If the stride is not repeated: its swings may be cut.
        """
        if not self.cyclic:
            raise ParameterError("clearance needs a walk that is repeated, not a motion that ends")
        feet = human.both("foot")
        place, turn = body_paths(human, self.qpos[:-1], feet)
        paths = sole_paths(human, self.qpos)
        for i, side in enumerate(SIDES):
            sole = paths.position[:, paths.of(side)]
            for swing in _swings(sole, float(self.time[1])):
                part = (np.arange(len(swing)) + 0.5) / len(swing)
                shape = np.sin(np.pi * part) ** 2
                lack = (clearance - sole[swing, :, 2].min(axis=1)) / shape
                middle = (part >= MID_SWING[0]) & (part <= MID_SWING[1])
                place[swing, i, 2] += max(float(lack[middle].max()), 0.0) * shape
        return self._repeated(human, LegInverse(human).reach(self.qpos[:-1], place, turn))

    def softened(self, human: Human) -> "Stride":
        """Return the stride with the centre of mass rising and falling as one sine per step.

        Its height keeps the first harmonic alone, lower by :data:`SOFT_DROP`; the feet stay where
        they are, and the legs bend.
        Where a motion consists of mean joint angles, higher harmonics are what the angles do not
        fit in: they would need 1.6 body weights of the standing leg just before touchdown, while
        people's force peaks at 1.2 to 1.4, on both legs.

        Raises:
            ParameterError: If the stride is not repeated.
        """
        if not self.cyclic:
            raise ParameterError("softening needs a walk that is repeated, not a motion that ends")
        qpos = self.qpos[:-1].copy()
        place, turn = body_paths(human, qpos, human.both("foot"))
        height = _com_heights(human, qpos)
        steps = np.exp(4j * np.pi * self.time[:-1] / self.time[-1])  # two in a stride
        sine = 2.0 * np.real(np.mean(height * steps.conj()) * steps)
        target = height.mean() - SOFT_DROP + sine
        for _ in range(2):  # legs that bend move the centre of mass, too
            qpos[:, 2] += target - _com_heights(human, qpos)
            qpos = LegInverse(human).reach(qpos, place, turn)
        return self._repeated(human, qpos)

    def _repeated(self, human: Human, qpos: Float[Array, "n_rows nq"]) -> "Stride":
        """Return the stride with other configurations, of all frames but the last."""
        qpos = np.vstack([qpos, qpos[:1]])
        qpos[-1, 0] += self.length
        _, values = human.to_coordinates(qpos)
        angles = np.unwrap(quaternion_to_pelvis_angles(qpos[:, 3:7]), axis=0)
        values = np.hstack([qpos[:, :3], angles, values[:, 6:]])
        return _stride(human, values, float(self.time[-1]), self.length)


def stride_of(human: Human, motion: Motion) -> Stride:
    """Return the most even stride of a motion, closed; the whole motion if there is none.

    A stride along a bend is the less even the more it turns: closed, it would lead straight on with
    the posture of a turn. Where gait events cut no stride it is what lies between the two instants
    that are most alike, or else a step and its mirror image. A walk on a belt gets the belt's way.
    The ends of the stride are closed by what they differ, spread over all of it, so that no seam is
    left.
    """
    if motion.joint_names != human.joint_names or motion.n_frames < 4:
        raise ParameterError("a reference needs four frames or more of a motion of this person")
    if not np.isfinite(motion.qpos).all():
        raise ParameterError("a reference needs a motion without gaps: qpos has missing values")
    own = motion.time
    motion = off_the_belt(human, motion)
    strides = [(c.start, c.stop) for c in cut_cycles(motion.events)]
    strides = [s for s in strides if s[0] >= own[0] - 1e-9 and s[1] <= own[-1] + 1e-9]
    best = _most_even(_whole(human, motion, *s) for s in strides)
    if not strides and best is None:
        best = _most_even(_whole(human, motion, *s) for s in _alike(human, motion))
    if not strides and best is None:
        best = _most_even(_mirrored(human, motion, *s) for s in _steps(motion))
    if best is not None:
        closed, length = _closed(best.values, best.period)
        return _stride(human, closed, best.period, length)
    values = _coordinates(human, motion, float(own[0]), float(own[-1]))
    values[:, :2] -= values[0, :2]
    return _stride(human, values, motion.duration, None)


@dataclass(frozen=True, eq=False)
class _Cut:
    """A candidate for a stride."""

    values: Float[Array, "n_rows nv"]  #: Place and angles of the pelvis and the hinges
    period: float  #: How long it takes [s]
    #: Root mean square of what its ends differ by in the hinges [rad]; of a step and its mirror
    #: image with rates, by :data:`RATE_WEIGHT`
    opening: float
    turn: float = 0.0  #: Rotation of the pelvis in it [rad]


def _most_even(cuts: Iterable[_Cut]) -> _Cut | None:
    """Return what closes best of all that nearly closes, straight ones first."""
    fine = [cut for cut in cuts if cut.opening < MAX_OPENING]
    return min(fine, key=lambda c: np.hypot(c.opening, max(c.turn - MAX_TURN, 0.0)), default=None)


def _whole(human: Human, motion: Motion, start: float, stop: float) -> _Cut:
    values = _coordinates(human, motion, start, stop)
    apart = values[-1] - values[0]
    opening = float(np.sqrt(np.mean(apart[6:] ** 2)))
    return _Cut(values, stop - start, opening, abs(float(apart[5])))


def _mirrored(human: Human, motion: Motion, start: float, stop: float) -> _Cut:
    """Return a step and its mirror image, the next one.

    The distance between its end and the image of its beginning is spread over the step. The way
    leads where the pelvis looks in the mean of both ends, between which it turns to the other side.
    """
    half = _coordinates(human, motion, start, stop, middle=True)
    names = human.coordinates
    order = [*range(6), *(6 + names.index(mirrored_name(name)) for name in names)]
    sign = np.array([1.0, -1.0, 1.0, 1.0, -1.0, -1.0, *(mirror_sign(name) for name in names)])
    half[:, 1] -= 0.5 * (half[0, 1] + half[-1, 1])
    rates = np.gradient(half, (stop - start) / (len(half) - 1), axis=0)
    gap, faster = (sign * x[0, order] - x[-1] for x in (half, rates))
    gap[0] = 0.0
    u = np.linspace(0.0, 1.0, len(half))[:, None]
    half += 0.5 * (gap * u - (sign * gap[order]) * (1.0 - u))
    other = sign * half[:, order]
    other[:, 0] += half[-1, 0] - half[0, 0]
    opening = float(np.sqrt(np.mean(gap[6:] ** 2 + (RATE_WEIGHT * faster[6:]) ** 2)))
    return _Cut(np.vstack([half[:-1], other]), 2.0 * (stop - start), opening)


def _alike(human: Human, motion: Motion) -> list[tuple[float, float]]:
    """Return the interval after which a motion is most like itself, in posture and in rates.

    All of it, if that is nearly as alike: files of one cycle are meant to be looped.
    """
    if not MIN_CYCLE <= motion.duration <= MAX_SEARCH_DURATION:
        return []
    n = int(motion.duration * SEARCH_RATE) + 1
    time = np.linspace(motion.time[0], motion.time[-1], n)
    hinges = motion.at(time).qpos[:, 7:]
    rates = np.gradient(hinges, time, axis=0)
    seen = np.hstack([hinges, RATE_WEIGHT * rates]) / np.sqrt(hinges.shape[1])
    apart = cdist(seen, seen)
    between = np.maximum.accumulate(np.triu(apart), axis=1)
    lasts = time[None, :] - time[:, None]
    still = between < np.maximum(MIN_EXCURSION, MIN_EXCURSION_RATIO * apart)
    apart[still | (lasts < MIN_CYCLE) | (lasts > MAX_CYCLE)] = np.inf
    i, k = np.unravel_index(np.argmin(apart), apart.shape)
    if apart[0, -1] <= WHOLE_MOTION_RATIO * apart[i, k]:
        i, k = 0, n - 1
    return [(float(time[i]), float(time[k]))] if apart[i, k] < MAX_OPENING else []


def _steps(motion: Motion) -> list[tuple[float, float]]:
    """Return what may be steps: from a strike to that of the other foot; if none, all there is."""
    strikes = sorted((e.time, e.side) for e in motion.events if e.kind == "heel_strike")
    found = [(a, b) for (a, s), (b, t) in zip(strikes, strikes[1:], strict=False) if s != t]
    inside = [s for s in found if s[0] >= motion.time[0] and s[1] <= motion.time[-1]]
    whole = (float(motion.time[0]), float(motion.time[-1]))
    return [s for s in inside or [whole] if MIN_CYCLE <= 2.0 * (s[1] - s[0]) <= MAX_CYCLE]


def stood_apart(human: Human, motion: Motion) -> float:
    """Return how far the places where feet stood are apart in height [m].

    A foot stands where all of its sole is slow; zero where none does twice.
    """
    if motion.n_frames < 3:
        return 0.0
    paths, heights = sole_paths(human, motion.qpos), []
    step = float(np.median(np.diff(motion.time)))
    for side in SIDES:
        sole = paths.position[:, paths.of(side)]
        fast = np.linalg.norm(np.gradient(sole, step, axis=0), axis=2).max(axis=1)
        low = sole[:, :, 2].min(axis=1)
        for run in runs(fast < MAX_STANCE_SPEED):
            if (run.stop - run.start) * step > MIN_STANCE_TIME:
                heights.append(float(np.median(low[run])))
    return max(heights) - min(heights) if heights else 0.0


def off_the_belt(human: Human, motion: Motion) -> Motion:
    """Return a treadmill motion as it would be over the ground; any other one unchanged."""
    if np.linalg.norm(motion.qpos[-1, :2] - motion.qpos[0, :2]) > MIN_TRAVEL * motion.duration:
        return motion
    feet = human.both("foot")
    toes = [max(i for i, b in enumerate(human.body_names, 1) if b[-2:] == f"_{s}") for s in SIDES]
    places, _ = body_paths(human, motion.qpos, [*feet, *toes])
    way = moving_ground(motion.time, places[:, :2], places[:, 2:])
    if not way.any():
        return motion
    qpos, qvel = motion.qpos.copy(), motion.qvel.copy()
    qpos[:, :3] -= way
    qvel[:, :3] -= np.gradient(way, motion.time, axis=0)
    return replace(motion, qpos=qpos, qvel=qvel)


def _com_heights(human: Human, qpos: Float[Array, "n_rows nq"]) -> Float[Array, " n_rows"]:
    """Return the heights of the centre of mass [m]."""
    state = BodyState(human, qpos[0])
    return np.array([state.moved_to(q).com[2] for q in qpos])


def _swings(sole: Float[Array, "n_rows n_sites 3"], step: float) -> list[np.ndarray]:
    """Return the frames of every swing of a foot in a closed stride, in the order of time.

    A foot swings while the lowest point of its sole moves.

    Args:
        sole: Points of the sole, the first frame again as the last [m].
        step: Time between frames [s].
    """
    n = len(sole) - 1
    low = sole[:-1, :, 2].argmin(axis=1)
    speed = np.linalg.norm(np.diff(sole, axis=0), axis=2)[np.arange(n), low] / step
    moves = speed > MAX_STANCE_SPEED
    starts = np.flatnonzero(moves & ~np.roll(moves, 1))
    if not len(starts):
        return []
    order = (np.arange(n) + starts[0]) % n
    whole = [run for run in runs(moves[order]) if (run.stop - run.start) * step > MIN_SWING_TIME]
    return [order[run] for run in whole]


def _coordinates(
    human: Human, motion: Motion, start: float, stop: float, *, middle: bool = False
) -> Float[Array, "n_rows nv"]:
    """Return place and angles of the pelvis and the hinges, walking along x.

    Args:
        start: From when [s].
        stop: Until when [s].
        middle: Whether x is where the pelvis looks in the mean of both ends, not where it gets.
    """
    n = max(int(np.ceil((stop - start) * MIN_RATE)), 8)
    part = motion.at(np.clip(np.linspace(start, stop, n + 1), motion.time[0], motion.time[-1]))
    _, values = human.to_coordinates(part.qpos)
    place = part.qpos[:, :3] - [*part.qpos[0, :2], 0.0]
    way = place[-1, :2]
    turn = float(np.arctan2(way[1], way[0])) if np.linalg.norm(way) > MIN_TRAVEL else 0.0
    if middle:
        turn = float(quaternion_to_pelvis_angles(part.qpos[:, 3:7])[[0, -1], 2].mean())
    place[:, :2] = place[:, :2] @ about_vertical(turn)[:2, :2]
    # As a whole: tilt and list are about axes of the world, which do not turn with the walk.
    angles = quaternion_to_pelvis_angles(turned(part.qpos[:, 3:7], -turn))
    middle = angles[:, 2].mean()
    angles[:, 2] -= 2 * np.pi * np.round(middle / (2 * np.pi))
    return np.hstack([place, angles, values[:, 6:]])


def _closed(
    values: Float[Array, "n_rows nv"], period: float
) -> tuple[Float[Array, "n_rows nv"], float]:
    """Return one stride without its way, both ends alike, and the way [m]."""
    n = len(values) - 1
    u = np.linspace(0.0, 1.0, n + 1)[:, None]
    stride = float(values[-1, 0] - values[0, 0])
    drift = values[-1] - values[0]
    shut = values - drift * (u - 0.5 * (np.arange(values.shape[1]) > 0))
    smooth = gaussian_filter1d(shut[:-1], SEAM_SMOOTHING * n / period, axis=0, mode="wrap")
    smooth[:, 1] -= smooth[:, 1].mean()
    smooth = np.vstack([smooth, smooth[:1]])
    smooth[:, 0] += stride * u[:, 0] - smooth[0, 0]
    return smooth, stride


def _stride(
    human: Human, values: Float[Array, "n_rows nv"], period: float, length: float | None
) -> Stride:
    """Return coordinates as configurations and velocities; a length marks a closed motion."""
    n = len(values) - 1
    time = np.linspace(0.0, period, n + 1)
    way = np.zeros_like(values)
    if length is not None:
        way[:, 0] = (values[-1, 0] - values[0, 0]) * time / period
    ends = "natural" if length is None else "periodic"
    spline = CubicSpline(time, values - way, axis=0, bc_type=ends)
    rate, bend = spline(time, 1), spline(time, 2)
    rate[:, 0] += way[-1, 0] / period
    turn, _ = pelvis_rates_to_free_joint(values[:, 3:6], rate[:, 3:6], bend[:, 3:6])
    quat = continuous(pelvis_angles_to_quaternion(values[:, 3:6]))
    qpos = np.hstack([values[:, :3], quat, values[:, 6:]])
    qpos[:, 2] -= np.median(lowest(human, qpos))
    qvel = np.hstack([rate[:, :3], turn, rate[:, 6:]])
    return Stride(time, qpos, qvel, length or 0.0, length is not None)

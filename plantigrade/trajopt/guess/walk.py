"""First guesses of a walk.

:func:`walking_guess` moves the pelvis from footprint to footprint with published mean joint angles
(:mod:`~plantigrade.models.textbook_gait`); the legs then reach for the feet of the plan by inverse
kinematics. :func:`crude_guess` is a straight line with slightly bent legs. :func:`with_noise` makes
either worse. Coordinates are in the order of :meth:`Human.to_coordinates`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.contact.plan import ContactPlan, Stance
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.textbook_gait import FREE_SPEED
from plantigrade.spatial.conventions import (
    OPENSIM_TO_WORLD,
    about_vertical,
    pelvis_angles_to_quaternion,
    quaternion_to_pelvis_angles,
    rotation_matrix,
    rotation_quaternion,
    within_half_turn,
)
from plantigrade.trajopt.guess.foot_motion import FootMotion, foot_motion, toe_coordinates
from plantigrade.trajopt.guess.legs import Leg
from plantigrade.trajopt.guess.mean_gait import SAGITTAL, MeanGait
from plantigrade.trajopt.guess.postures import foot_stances, standing_hinges
from plantigrade.trajopt.problem.nlp import PeriodicClosure
from plantigrade.trajopt.tasks.gait_parameters import GaitParameters

SWAY_AMPLITUDE = 0.022  # [leg lengths] sway towards the stance foot at free speed; more when slow
HOLD_SHARE = 0.4  # [1] share of a rest with a motionless body


@dataclass(frozen=True)
class DoubleSupport:
    """Both feet on the ground [s]."""

    start: float
    stop: float
    place: Float[Array, " 4"]  #: Between the feet: x, y, ground [m], heading [rad]
    rest: str = ""  #: ``"before"`` or ``"after"`` the walk, or empty in between

    @property
    def held(self) -> float:
        """From or until when the body is still, in a rest [s]."""
        hold = HOLD_SHARE * (self.stop - self.start)
        return self.start + hold if self.rest == "before" else self.stop - hold


def double_supports(plan: ContactPlan, stances: Sequence[Stance]) -> list[DoubleSupport]:
    """Return the double supports of a plan, in order; no two at the same time."""
    out = []
    for k, s in enumerate(stances):
        partners = [
            p
            for p in stances[:k]
            if p.footprint.side != s.footprint.side and p.toe_off >= s.heel_strike >= p.heel_strike
        ]
        if not partners:
            continue
        p = partners[-1]
        start, stop, rest = s.heel_strike, min(p.toe_off, s.toe_off), ""
        if not plan.periodic:
            if max(s.foot_flat, p.foot_flat) <= 0:
                start, rest = 0.0, "before"
            if min(s.heel_off, p.heel_off) >= plan.duration:
                stop, rest = plan.duration, "after"
        out.append(DoubleSupport(start, stop, midway(s, p), rest))
    if not out:
        raise ParameterError("a walk needs a moment with both feet on the ground")
    return out


def phases(
    stances: Sequence[Stance], supports: Sequence[DoubleSupport]
) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
    """Return times of heel strikes and the phase of the right foot's stride at each."""
    begin = supports[0].stop if supports[0].rest == "before" else -np.inf
    strikes = [s for s in stances if s.heel_strike >= begin] or list(stances[-1:])
    first = 0.0 if strikes[0].footprint.side == "r" else 0.5
    return np.array([s.heel_strike for s in strikes]), first + 0.5 * np.arange(len(strikes))


def walking_share(
    supports: Sequence[DoubleSupport],
) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
    """Return times and the share of walking then."""
    knots = [(s.held, 0.0) if s.rest else ((s.start + s.stop) / 2, 1.0) for s in supports]
    return np.array([t for t, _ in knots]), np.array([w for _, w in knots])


class PelvisPath:
    """Path of the pelvis."""

    def __init__(
        self,
        human: Human,
        supports: Sequence[DoubleSupport],
        stances: Sequence[Stance],
        parameters: GaitParameters,
    ):
        from scipy.interpolate import PchipInterpolator

        p = parameters
        self._ahead, self._height = -human.skeleton.origins["foot_r"][0], human.standing()[2]
        times, places = [], []
        for s in supports:
            rest = {"before": [s.start, s.held], "after": [s.held, s.stop]}.get(s.rest, [s.start])
            times += rest
            places += [s.place] * len(rest)
        places = np.array(places)
        places[:, 3] = np.unwrap(places[:, 3])
        step = np.zeros_like(places)
        step[:, :2] = ahead(step[:, :2], places[:, 3], p.step_length)
        if not supports[0].rest:
            times = [times[0] - p.step_time, *times]
            places = np.vstack([places[0] - step[0], places])
        if not supports[-1].rest:
            times = [*times, times[-1] + p.step_time]
            places = np.vstack([places, places[-1] + step[-1]])
        self._span = times[0], times[-1]
        self._place = PchipInterpolator(times, places)
        size = float(
            SWAY_AMPLITUDE * p.leg_length * np.clip(FREE_SPEED / p.relative_speed, 0.6, 2.0)
        )
        sways = [(t, 0.0) for t in times]
        for side, sway in (("r", size), ("l", -size)):
            own = foot_stances(stances, side)
            for a, b in zip(own[:-1], own[1:], strict=True):
                sways.append(((a.toe_off + b.heel_strike) / 2, sway))
        self._sway = PchipInterpolator(*np.array(sorted(sways)).T)

    def pelvis(
        self, gait: MeanGait, times: Float[Array, " n"]
    ) -> tuple[Float[Array, "n 3"], Float[Array, "n 3 3"]]:
        """Return position, at the height of standing, and rotation of the pelvis."""
        t = np.clip(times, *self._span)
        place, sway = self._place(t), self._sway(t)
        heading = place[:, 3]
        position = np.empty((len(t), 3))
        position[:, :2] = ahead(place[:, :2], heading, self._ahead)
        position[:, 0] -= np.sin(heading) * sway
        position[:, 1] += np.cos(heading) * sway
        position[:, 2] = place[:, 2] + self._height
        own = rotation_matrix(pelvis_angles_to_quaternion(gait.pelvis_angles(times)))
        return position, about_vertical(heading) @ own


def midway(a: Stance, b: Stance) -> Float[Array, " 4"]:
    """Return the place between two footprints: x, y, ground [m], heading [rad]."""
    middle = (np.array(a.footprint.position) + np.array(b.footprint.position)) / 2
    turn = within_half_turn(b.footprint.heading - a.footprint.heading)
    return np.array([*middle, a.footprint.heading + turn / 2])


def ahead(
    place: Float[Array, "n 2"], heading: Float[Array, " n"], distance: float
) -> Float[Array, "n 2"]:
    """Return places some distance ahead [m]."""
    return place + distance * np.stack([np.cos(heading), np.sin(heading)], axis=1)


MAX_LEG_EXTENSION = 0.997  # [1] maximum leg extension; 9° of knee flexion
_RATE = 100.0  # [Hz] rate of the grid for the pelvis height
_SMOOTHING = 0.06  # [s] standard deviation of the filter of that height; chosen
_REACH = 6  # samples to either side over which the pelvis is kept low; chosen
NOISE_LEVER = 0.3  # [m/rad] noise of pelvis translations relative to that of angles; chosen
HARMONICS = 4  # number of waves that make up the noise; chosen


def walking_guess(
    human: Human, plan: ContactPlan, parameters: GaitParameters, times: Float[Array, " n_times"]
) -> Float[Array, "n_times n_coordinates"]:
    """Return the coordinates of a walk whose feet follow a plan, at times [s].

    Times may lie some steps before or after a periodic plan.
    """
    if len(times) == 0:
        raise ParameterError("a guess needs at least one time")
    times = np.asarray(times, dtype=float)
    laps = 2 + int(np.ceil(max(-times.min(), times.max() - plan.duration, 0.0) / plan.duration))
    stances = plan.unrolled(before=laps, after=laps)
    supports = double_supports(plan, stances)
    gait = MeanGait(human, parameters, phases(stances, supports), walking_share(supports))
    path = PelvisPath(human, supports, stances, parameters)
    curves = gait.foot_curves(parameters)
    ground = Ground.of_plan(plan)
    begin, end = min(0.0, float(times.min())), max(plan.duration, float(times.max()))
    margin = plan.duration if plan.periodic else 0.0
    n = int(np.ceil((end - begin + 2 * margin) * _RATE)) + 1
    grid = np.linspace(begin - margin, end + margin, n)

    def feet(at: np.ndarray) -> dict[str, FootMotion]:
        return {s: foot_motion(human, foot_stances(stances, s), at, curves, ground) for s in SIDES}

    legs = {side: Leg(human, side) for side in SIDES}
    heights = _height(legs, *path.pelvis(gait, grid), feet(grid))
    position, rotation = path.pelvis(gait, times)
    position[:, 2] = np.interp(times, grid, heights)
    hinges = gait.hinges(times)
    for side, motion in feet(times).items():
        for name, values in toe_coordinates(human, motion.toes).items():
            hinges[:, human.hinge(f"{name}_{side}")] = values
        hinges = legs[side].reach(position, rotation, hinges, motion.ankle, motion.rotations())
    return np.hstack([_angles(rotation), position @ OPENSIM_TO_WORLD, hinges])


def crude_guess(
    human: Human, plan: ContactPlan, times: Float[Array, " n_times"]
) -> Float[Array, "n_times n_coordinates"]:
    """Return a body that glides straight from the first to the last footprints of a plan.

    Knees are bent by 17°, hips and ankles by 9°; nothing else moves.
    """
    times = np.asarray(times, dtype=float)
    stances = plan.unrolled()
    begin, end = _between(stances, 0.0), _between(stances, plan.duration)
    end[3] = begin[3] + within_half_turn(end[3] - begin[3])
    place = begin + (times / plan.duration)[:, None] * (end - begin)
    hinges = standing_hinges(human, len(times))
    for side in SIDES:
        for name, bend in zip(SAGITTAL, (9.0, 17.0, 9.0), strict=True):
            hinges[:, human.hinge(f"{name}_{side}")] = np.deg2rad(bend)
    ankle, _, _ = Leg(human, "r").forward(np.zeros((1, 3)), np.eye(3)[None], hinges[:1])
    position = ahead(place[:, :2], place[:, 3], -ankle[0, 0])
    height = place[:, 2] + human.dimensions.ankle_height - ankle[0, 2]
    position = np.column_stack([position, height])
    rotation = about_vertical(place[:, 3])
    return np.hstack([_angles(rotation), position @ OPENSIM_TO_WORLD, hinges])


def with_noise(
    c: Float[Array, "n n_coordinates"],
    *,
    seed: int,
    size: float,
    closure: PeriodicClosure | None = None,
) -> Float[Array, "n n_coordinates"]:
    """Return spline coefficients, or samples, with smooth noise added to every coordinate.

    Args:
        c: Coefficients or samples.
        size: Root mean square of the noise of angles [rad].
        closure: How a periodic motion goes on; the noise goes on in the same way.
    """
    if not size >= 0:
        raise ParameterError(f"{size=} must be zero or more")
    rng = np.random.default_rng(seed)
    n, n_coordinates = c.shape
    span = n if closure is None else 2 * n
    # Half waves where the motion ends, so that its ends need not be moved alike.
    waves = np.arange(1, HARMONICS + 1) * (0.5 if closure is None else 1.0)
    angle = 2 * np.pi * waves[:, None] * np.arange(span) / span
    a, b = rng.normal(size=(2, n_coordinates, HARMONICS)) / np.sqrt(HARMONICS)
    noise = (a @ np.cos(angle) + b @ np.sin(angle)).T
    if closure is not None:
        noise = (noise + closure.sign * np.roll(noise[:, closure.source], n, axis=0)) / np.sqrt(2)
    scale = np.full(n_coordinates, float(size))
    scale[3:6] *= NOISE_LEVER
    return c + scale * noise[:n]


def _height(
    legs: dict[str, Leg],
    position: Float[Array, "n 3"],
    rotation: Float[Array, "n 3 3"],
    feet: dict[str, FootMotion],
) -> Float[Array, " n"]:
    """Return a smooth height of the pelvis at which both legs reach their feet [m]."""
    limits = []
    for side, leg in legs.items():
        hip = rotation @ leg.hip
        gap = position[:, :2] + hip[:, :2] - feet[side].ankle[:, :2]
        most = MAX_LEG_EXTENSION * leg.length
        above = np.sqrt(np.maximum(most**2 - np.sum(gap**2, axis=1), (0.5 * most) ** 2))
        limits.append(feet[side].ankle[:, 2] + above - hip[:, 2])
    limit = np.min(limits, axis=0)
    smooth = partial(gaussian_filter1d, sigma=_SMOOTHING * _RATE, mode="nearest")
    height = smooth(limit)
    for _ in range(6):
        lacking = np.maximum(height - limit, 0.0)
        height -= smooth(maximum_filter1d(lacking, 2 * _REACH + 1, mode="nearest"))
    return height


def _between(stances: Sequence[Stance], time: float) -> Float[Array, " 4"]:
    """Return the place between the footprints of both feet nearest in time."""

    def away(s: Stance) -> float:
        return max(s.heel_strike - time, time - s.toe_off, 0.0)

    return midway(*(min(foot_stances(stances, side), key=away) for side in SIDES))


def _angles(rotation: Float[Array, "n 3 3"]) -> Float[Array, "n 3"]:
    """Return pelvis tilt, list and rotation of rotations to world axes [rad]."""
    return quaternion_to_pelvis_angles(rotation_quaternion(rotation))

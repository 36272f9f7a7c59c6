r"""First guesses: a walk that is roughly right, a crude one, and noise to make either worse.

:func:`walking_guess` puts published mean angles (:mod:`~plantigrade.models.textbook_gait`) on a
pelvis that goes from footprint to footprint, and bends the legs until the feet are where the plan
has them. :func:`crude_guess` knows nothing of walking: a straight line and a slight bend.

Both return coordinates in the order of :meth:`Human.to_coordinates`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.contact.plan import ContactPlan, Stance
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.models.textbook_gait import FREE, textbook_gait
from plantigrade.spatial.conventions import (
    OPENSIM_TO_WORLD,
    PELVIS,
    pelvis_angles_to_quaternion,
    quaternion_to_pelvis_angles,
    rotation_matrix,
    xyzw_to_wxyz,
)
from plantigrade.synthesize.guess.foot_motion import (
    OFF,
    STRIKE,
    FootCurves,
    FootMotion,
    foot_motion,
    toe_coordinates,
)
from plantigrade.synthesize.guess.legs import Leg
from plantigrade.synthesize.problem.nlp import PeriodicClosure
from plantigrade.synthesize.tasks.gait_parameters import GaitParameters

STRETCH = 0.997  # how far a leg is stretched at most: 9° in the knee
SWAY = 0.022  # of leg length, to the standing foot at free speed; more when slow
_RATE = 100.0  # of the grid on which the pelvis' height is found [Hz]
MOST = float(np.deg2rad(65.0))  # heel-up angle in swing [rad]
HOLD = 0.4  # of a rest in which the body stays where it is
_SAGITTAL = ("hip_flexion", "knee_angle", "ankle_angle")


def walking_guess(
    human: Human,
    plan: ContactPlan,
    parameters: GaitParameters,
    times: Float[Array, " n_times"],
) -> Float[Array, "n_times n_coordinates"]:
    """Return a walk whose feet are where the plan has them.

    Args:
        human: The person.
        plan: When and where the feet stand; feet in turns.
        parameters: How the person walks.
        times: When [s]; of a periodic plan also some steps before and after it.

    Returns:
        Coordinates [rad, m]. Pelvis angles go on past 180° in a turn.

    Raises:
        ParameterError: If a foot has no stance, or there are no times.
    """
    if len(times) == 0:
        raise ParameterError("a guess needs at least one time")
    times = np.asarray(times, dtype=float)
    laps = 2 + int(np.ceil(max(-times.min(), times.max() - plan.duration, 0.0) / plan.duration))
    stances = plan.unrolled(before=laps, after=laps)
    supports = _supports(plan, stances)
    way = _Way(human, supports, stances, parameters)
    book = _Book(human, parameters, _phases(stances, supports), _walking(supports))
    curves = book.foot_curves(parameters)
    begin, end = min(0.0, float(times.min())), max(plan.duration, float(times.max()))
    margin = plan.duration if plan.periodic else 0.0
    n = int(np.ceil((end - begin + 2 * margin) * _RATE)) + 1
    grid = np.linspace(begin - margin, end + margin, n)

    def feet(at: np.ndarray) -> dict[str, FootMotion]:
        out = {}
        for side in ("r", "l"):
            own = [s for s in stances if s.footprint.side == side]
            if not own:
                raise ParameterError(f"the {'right' if side == 'r' else 'left'} foot has no stance")
            out[side] = foot_motion(human, own, at, curves=curves)
        return out

    legs = {side: Leg(human, side) for side in ("r", "l")}
    heights = _height(legs, *way.pelvis(book, grid), feet(grid))
    position, turned = way.pelvis(book, times)
    position[:, 2] = np.interp(times, grid, heights)
    hinges = book.hinges(times)
    for side, motion in feet(times).items():
        for name, values in toe_coordinates(human, motion.toes).items():
            hinges[:, human.hinge(f"{name}_{side}")] = values
        hinges = legs[side].reach(position, turned, hinges, motion.ankle, motion.rotations())
    return np.hstack([_angles(turned), position @ OPENSIM_TO_WORLD, hinges])


def crude_guess(
    human: Human, plan: ContactPlan, times: Float[Array, " n_times"]
) -> Float[Array, "n_times n_coordinates"]:
    """Return a body that glides along a straight line with slightly bent legs.

    Knees are bent by 17°, hips and ankles by 9°; nothing else moves.

    Args:
        human: The person.
        plan: Its first and last footprints say from where to where.
        times: When [s].
    """
    times = np.asarray(times, dtype=float)
    stances = plan.unrolled()
    begin, end = _between(stances, 0.0), _between(stances, plan.duration)
    end[3] = begin[3] + _wrapped(end[3] - begin[3])
    place = begin + (times / plan.duration)[:, None] * (end - begin)
    standing = human.standing()
    hinges = np.tile(standing[7:], (len(times), 1))
    for side in ("r", "l"):
        for name, bend in (("hip_flexion", 9.0), ("knee_angle", 17.0), ("ankle_angle", 9.0)):
            hinges[:, human.hinge(f"{name}_{side}")] = np.deg2rad(bend)
    upright = np.eye(3)[None]
    ankle, _, _ = Leg(human, "r").forward(np.zeros((1, 3)), upright, hinges[:1])
    position = _ahead(place[:, :2], place[:, 3], -ankle[0, 0])
    height = place[:, 2] + human.dimensions.ankle_height - ankle[0, 2]
    position = np.column_stack([position, height])
    return np.hstack([_angles(_headed(place[:, 3])), position @ OPENSIM_TO_WORLD, hinges])


def perturbed(
    c: Float[Array, "n n_coordinates"],
    *,
    seed: int,
    size: float,
    reach: float = 0.3,
    harmonics: int = 4,
    closure: PeriodicClosure | None = None,
) -> Float[Array, "n n_coordinates"]:
    """Return coefficients, or samples, with smooth noise added to every coordinate.

    Args:
        c: Coefficients, coordinates in the order of :meth:`Human.to_coordinates`.
        seed: Of the noise.
        size: Root mean square of the noise of angles [rad].
        reach: Of that of the pelvis' translations, for each radian [m/rad].
        harmonics: Waves along all coefficients at most; the noise is made of 1 to so many.
        closure: How the motion goes on; noise that goes on in the same way is then made.

    Raises:
        ParameterError: If the size is negative or there are no harmonics.
    """
    if not size >= 0 or not harmonics >= 1:
        raise ParameterError(f"{size=} must be zero or more and {harmonics=} one or more")
    rng = np.random.default_rng(seed)
    n, n_coordinates = c.shape
    span = n if closure is None else 2 * n
    # Half waves where the motion ends, so that its ends need not be moved alike.
    waves = np.arange(1, harmonics + 1) * (0.5 if closure is None else 1.0)
    angle = 2 * np.pi * waves[:, None] * np.arange(span) / span
    a, b = rng.normal(size=(2, n_coordinates, harmonics)) / np.sqrt(harmonics)
    noise = (a @ np.cos(angle) + b @ np.sin(angle)).T
    if closure is not None:
        noise = (noise + closure.sign * np.roll(noise[:, closure.source], n, axis=0)) / np.sqrt(2)
    scale = np.full(n_coordinates, float(size))
    scale[3:6] *= reach
    return c + scale * noise[:n]


class _Book:
    """Published mean angles over the time of a plan, standing where it stands."""

    def __init__(
        self,
        human: Human,
        parameters: GaitParameters,
        phase: tuple[Array, Array],
        walking: tuple[Array, Array],
    ):
        slowest, fastest = np.array([0.101, 0.799]) * np.sqrt(GRAVITY * parameters.leg_length)
        speed = float(np.clip(parameters.speed, slowest, fastest))
        gait = textbook_gait(speed, parameters.leg_length, rate=400.0, cycles=1)
        self.human, self.foot_off = human, gait.foot_off
        self.step_length = gait.stride_length / 2
        self._share = gait.time / gait.stride_time
        self._curves = gait.coordinates
        self._phase, self._walking, self._stride = phase, walking, parameters.stride_time

    def curve(self, name: str, phase: Float[Array, " n"]) -> Float[Array, " n"]:
        """Return a coordinate of the walk at phases of the right foot [rad]."""
        return np.interp(phase % 1.0, self._share, self._curves[name], period=1.0)

    def phase(self, times: Float[Array, " n"]) -> Float[Array, " n"]:
        """Return strides of the right foot at times."""
        t, p = self._phase
        before, after = np.minimum(times - t[0], 0.0), np.maximum(times - t[-1], 0.0)
        return np.interp(times, t, p) + (before + after) / self._stride

    def walking(self, times: Float[Array, " n"]) -> Float[Array, " n"]:
        """Return how much of a walk it is at times, 0 standing to 1."""
        share = np.interp(times, *self._walking)
        return share * share * (3 - 2 * share)

    def pelvis(self, times: Float[Array, " n"]) -> Float[Array, "n 3"]:
        """Return pelvis tilt, list and rotation [rad]."""
        phase, share = self.phase(times), self.walking(times)
        return np.stack([share * self.curve(name, phase) for name in PELVIS[:3]], axis=1)

    def hinges(self, times: Float[Array, " n"]) -> Float[Array, "n n_hinges"]:
        """Return all hinges of the person [rad]."""
        phase, share = self.phase(times), self.walking(times)
        hinges = np.tile(self.human.standing()[7:], (len(times), 1))
        for i, name in enumerate(self.human.coordinates):
            if name in self._curves:
                hinges[:, i] += share * (self.curve(name, phase) - hinges[:, i])
        return hinges

    def foot_curves(self, parameters: GaitParameters) -> FootCurves:
        """Return how a foot goes; it turns more in longer steps."""
        d = self.human.dimensions
        swing = np.linspace(self.foot_off, 1.0, 61)
        phase = np.where(swing < 1.0, swing, 0.0)
        tilt, hip, knee, ankle = (
            self.curve(name, phase) for name in ("pelvis_tilt", *(f"{n}_r" for n in _SAGITTAL))
        )
        thigh, shank = hip + tilt, hip + tilt - knee  # ahead of the vertical
        heel_up = -(shank + ankle)
        heel_up *= min(parameters.step_length / self.step_length, MOST / float(heel_up.max()))
        forward = d.thigh * np.sin(thigh) + d.shank * np.sin(shank)
        forward += 2 * self.step_length * swing
        return FootCurves(
            strike=float(np.clip(-heel_up[-1], *STRIKE)),
            off=float(np.clip(heel_up[0], *OFF)),
            pitch=heel_up,
            forward=(forward - forward[0]) / (forward[-1] - forward[0]),
            up=-(d.thigh * np.cos(thigh) + d.shank * np.cos(shank)),
        )


@dataclass(frozen=True)
class _Support:
    """Both feet on the ground.

    Attributes:
        start: [s].
        stop: [s].
        place: Between the feet: x, y, ground [m], heading [rad].
        rest: ``"before"`` or ``"after"`` the walk, or empty in between.
    """

    start: float
    stop: float
    place: Float[Array, " 4"]
    rest: str = ""

    @property
    def middle(self) -> float:
        """[s]."""
        return (self.start + self.stop) / 2


def _supports(plan: ContactPlan, stances: Sequence[Stance]) -> list[_Support]:
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
        out.append(_Support(start, stop, _midway(s, p), rest))
    if not out:
        raise ParameterError("a walk needs a moment with both feet on the ground")
    return out


class _Way:
    """Where the pelvis goes."""

    def __init__(
        self,
        human: Human,
        supports: Sequence[_Support],
        stances: Sequence[Stance],
        parameters: GaitParameters,
    ):
        from scipy.interpolate import PchipInterpolator

        standing = human.standing()
        ankle = human.skeleton.origins["foot_r"]
        self._forward = float(-ankle[0])
        knots: list[tuple[float, np.ndarray]] = []
        for s in supports:
            if s.rest == "before":
                knots += [(s.start, s.place), (s.start + HOLD * (s.stop - s.start), s.place)]
            elif s.rest == "after":
                knots += [(s.stop - HOLD * (s.stop - s.start), s.place), (s.stop, s.place)]
            else:
                knots.append((s.start, s.place))
        times = np.array([t for t, _ in knots])
        places = np.array([p for _, p in knots])
        places[:, 3] = np.unwrap(places[:, 3])
        forward = parameters.step_length * np.array([np.cos(places[:, 3]), np.sin(places[:, 3])])
        if not supports[0].rest:
            before = places[0] - [*forward[:, 0], 0.0, 0.0]
            times, places = (
                np.r_[times[0] - parameters.step_time, times],
                np.vstack([before, places]),
            )
        if not supports[-1].rest:
            after = places[-1] + [*forward[:, -1], 0.0, 0.0]
            times, places = (
                np.r_[times, times[-1] + parameters.step_time],
                np.vstack([places, after]),
            )
        self._span = times[0], times[-1]
        self._place = PchipInterpolator(times, places)
        size = SWAY * parameters.leg_length * np.clip(FREE / parameters.relative_speed, 0.6, 2.0)
        swings = [(t, 0.0) for t in times]
        for side, sign in (("r", 1.0), ("l", -1.0)):
            own = [s for s in stances if s.footprint.side == side]
            for a, b in zip(own[:-1], own[1:], strict=True):
                swings.append(((a.toe_off + b.heel_strike) / 2, sign * float(size)))
        swings = sorted(swings)
        self._sway = PchipInterpolator([t for t, _ in swings], [y for _, y in swings])
        self._height = float(standing[2])

    def pelvis(
        self, book: _Book, times: Float[Array, " n"]
    ) -> tuple[Float[Array, "n 3"], Float[Array, "n 3 3"]]:
        """Return where the pelvis is, its height still that of standing, and how it is turned."""
        t = np.clip(times, *self._span)
        place, sway = self._place(t), self._sway(t)
        heading = place[:, 3]
        position = np.empty((len(t), 3))
        position[:, :2] = _ahead(place[:, :2], heading, self._forward)
        position[:, 0] -= np.sin(heading) * sway
        position[:, 1] += np.cos(heading) * sway
        position[:, 2] = place[:, 2] + self._height
        own = rotation_matrix(pelvis_angles_to_quaternion(book.pelvis(times)))
        return position, _headed(heading) @ own


def _phases(
    stances: Sequence[Stance], supports: Sequence[_Support]
) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
    """Return times of heel strikes and the phase of the right foot's stride at each."""
    begin = supports[0].stop if supports[0].rest == "before" else -np.inf
    strikes = [s for s in stances if s.heel_strike >= begin] or list(stances[-1:])
    first = 0.0 if strikes[0].footprint.side == "r" else 0.5
    return np.array([s.heel_strike for s in strikes]), first + 0.5 * np.arange(len(strikes))


def _walking(supports: Sequence[_Support]) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
    """Return times and how much of a walk it is then."""
    middle = [s.middle for s in supports if not s.rest]
    knots = [(t, 1.0) for t in middle]
    first, last = supports[0], supports[-1]
    if first.rest == "before":
        knots.insert(0, (first.start + HOLD * (first.stop - first.start), 0.0))
    if last.rest == "after":
        knots.append((last.stop - HOLD * (last.stop - last.start), 0.0))
    knots = knots or [(0.0, 0.0)]
    return np.array([t for t, _ in knots]), np.array([w for _, w in knots])


def _height(
    legs: dict[str, Leg],
    position: Float[Array, "n 3"],
    turned: Float[Array, "n 3 3"],
    feet: dict[str, FootMotion],
) -> Float[Array, " n"]:
    """Return a smooth height of the pelvis at which both legs reach their feet [m]."""
    limits = []
    for side, leg in legs.items():
        hip = turned @ leg.hip
        gap = position[:, :2] + hip[:, :2] - feet[side].ankle[:, :2]
        most = STRETCH * leg.length
        above = np.sqrt(np.maximum(most**2 - np.sum(gap**2, axis=1), (0.5 * most) ** 2))
        limits.append(feet[side].ankle[:, 2] + above - hip[:, 2])
    limit = np.min(limits, axis=0)
    height = _smooth(limit)
    for _ in range(6):
        height -= _smooth(_widest(np.maximum(height - limit, 0.0)))
    return height


def _smooth(x: Float[Array, " n"], width: float = 0.06) -> Float[Array, " n"]:
    """Return a curve on the grid without its fast parts; ``width`` is that of a Gaussian [s]."""
    reach = int(np.ceil(4 * width * _RATE))
    kernel = np.exp(-0.5 * (np.arange(-reach, reach + 1) / (width * _RATE)) ** 2)
    return np.convolve(np.pad(x, reach, mode="edge"), kernel / kernel.sum(), mode="valid")


def _widest(x: Float[Array, " n"], reach: int = 6) -> Float[Array, " n"]:
    """Return the largest value within some samples of each."""
    padded = np.pad(x, reach, mode="edge")
    return np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1).max(axis=1)


def _between(stances: Sequence[Stance], time: float) -> Float[Array, " 4"]:
    """Return the place between the footprints of both feet nearest in time."""

    def away(s: Stance) -> float:
        return max(s.heel_strike - time, time - s.toe_off, 0.0)

    nearest = []
    for side in ("r", "l"):
        own = [s for s in stances if s.footprint.side == side]
        if not own:
            raise ParameterError(f"the {'right' if side == 'r' else 'left'} foot has no stance")
        nearest.append(min(own, key=away))
    return _midway(*nearest)


def _midway(a: Stance, b: Stance) -> Float[Array, " 4"]:
    """Return the place between two footprints: x, y, ground [m], heading [rad]."""
    middle = (np.array(a.footprint.position) + np.array(b.footprint.position)) / 2
    turn = _wrapped(b.footprint.heading - a.footprint.heading)
    return np.array([*middle, a.footprint.heading + turn / 2])


def _wrapped(angle: float) -> float:
    """Return an angle between -180° and 180°."""
    return float((angle + np.pi) % (2 * np.pi) - np.pi)


def _ahead(
    place: Float[Array, "n 2"], heading: Float[Array, " n"], distance: float
) -> Float[Array, "n 2"]:
    """Return places some distance ahead [m]."""
    return place + distance * np.stack([np.cos(heading), np.sin(heading)], axis=1)


def _headed(heading: Float[Array, " n"]) -> Float[Array, "n 3 3"]:
    """Return rotations about the vertical."""
    out = np.tile(np.eye(3), (len(heading), 1, 1))
    out[:, 0, 0] = out[:, 1, 1] = np.cos(heading)
    out[:, 1, 0] = np.sin(heading)
    out[:, 0, 1] = -out[:, 1, 0]
    return out


def _angles(turned: Float[Array, "n 3 3"]) -> Float[Array, "n 3"]:
    """Return pelvis tilt, list and rotation of rotations to world axes [rad]."""
    from scipy.spatial.transform import Rotation

    return quaternion_to_pelvis_angles(xyzw_to_wxyz(Rotation.from_matrix(turned).as_quat()))

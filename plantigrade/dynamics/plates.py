r"""Measured ground reactions on the frames of a motion: which plate holds which foot, and when.

**Which foot.** A loading of a plate belongs to the foot whose sole is at its centre of pressure;
a plate that names its side is believed. One plate may hold one foot after the other. While both
feet are on the same plate, or a foot is partly beside its plate, nobody can say what each foot
felt: these frames are reported and left out, as are frames in which a foot rests on the ground
without any plate under it.

**Filter.** Every loading is filtered by itself: the wrench about a fixed point, force
:math:`F` and moment :math:`M`, with the cut-off used for the motion, reflected at the ends of the
contact so that no force leaks out of it; the centre of pressure and the free moment follow from
the smoothed wrench,

.. math:: c_x = \frac{z F_x - M_y}{F_z}, \quad c_y = \frac{z F_y + M_x}{F_z}, \quad
    T = M_z - c_x F_y + c_y F_x,

with :math:`z` the height at which the plate gives its centre of pressure. Smoothing the centre of
pressure itself would drag it towards where the force is small and its place is noise.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.dynamics.carriers import SIDES, Carriers
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import PointSet
from plantigrade.models import Human
from plantigrade.motion.events import contact_events, ground_velocity
from plantigrade.motion.filters import derivative, lowpass, runs
from plantigrade.motion.recording import ForcePlate, rate_of

NEAR = 0.20  # furthest a centre of pressure may be from the sole it is given to [m]
SHARED = 0.06  # centre of pressure this far off a foot whose fellow also stands: both carry [m]
LOW = 0.03  # height above the ground below which a point of the sole may touch it [m]
SLOW = 0.35  # speed relative to the ground below which it does [m/s]
BESIDE = 0.02  # how far a point of the sole must rest outside a plate to count as beside it [m]
EDGE = 0.10  # a foot that rests this much longer than its plate is loaded is partly beside it [s]
MARGIN = 0.05  # a foot beside the plates may carry this long before and after it looks at rest [s]
SHORTEST_REST = 0.06  # shorter rests of a foot are a low pass in swing [s]


@dataclass(frozen=True)
class PlateUse:
    """One loading of a plate and whose it was.

    Attributes:
        plate: Name of the plate.
        side: ``"r"`` or ``"l"``; empty where no foot was at the centre of pressure.
        start: First frame.
        stop: One after the last frame.
        peak: Greatest vertical force [N].
        problem: Why frames of it are not used; empty where all are.
    """

    plate: str
    side: str
    start: int
    stop: int
    peak: float
    problem: str = ""


@dataclass(frozen=True)
class FootForces:
    """Ground reaction on each foot, on the frames of a motion; sides in the order r, l.

    Attributes:
        force: Force on the foot, world [N]; zero where it carries none.
        point: Centre of pressure, world [m]; NaN where the force is zero.
        torque: Free moment at that point, world, vertical [N m].
        valid_side: Frames in which the force on that foot is known (zero in swing is known).
        valid: Frames in which both are.
        uses: Every loading of every plate.
        warnings: What the user should know, one sentence each.
        sides: Names of the sides, in the order of the second axis.
    """

    force: Float[Array, "n_frames 2 3"]
    point: Float[Array, "n_frames 2 3"]
    torque: Float[Array, "n_frames 2 3"]
    valid_side: Bool[Array, "n_frames 2"]
    valid: Bool[Array, " n_frames"]
    uses: tuple[PlateUse, ...] = ()
    warnings: tuple[str, ...] = ()
    sides: tuple[str, str] = SIDES


@dataclass
class _Loading:
    """One loading of one plate on the frames: wrench at the centre of pressure, and its owner."""

    plate: ForcePlate
    frames: np.ndarray
    force: np.ndarray
    cop: np.ndarray
    free: np.ndarray
    peak: float
    owner: np.ndarray  # side index per frame, -1 for nobody
    problem: str = ""


def assign_plates(
    plates: tuple[ForcePlate, ...],
    frame_time: Float[Array, " n_frames"],
    foot_points: Mapping[str, Float[Array, "n_frames n_points 3"]],
    *,
    cutoff: float | None = None,
    threshold: float = 20.0,
) -> FootForces:
    """Return the ground reaction on each foot.

    Args:
        plates: Measured ground reactions, at any rate.
        frame_time: Time of each frame of the motion [s], on the plates' clock.
        foot_points: For ``"r"`` and ``"l"`` the world positions of points on that foot's sole,
            heel first, toes last (:func:`sole_points`) [m].
        cutoff: Zero-lag fourth-order low-pass of the wrenches [Hz], the motion's own; None for
            none. Where the plates' rate cannot hold it, it is left out.
        threshold: Vertical force that counts as contact [N].

    Raises:
        ParameterError: If a side is missing or the points are not on the frames.
    """
    n = len(frame_time)
    points = _check(frame_time, foot_points)
    notes: list[str] = []
    loadings = [
        loading for plate in plates for loading in _loadings(plate, frame_time, cutoff, threshold)
    ]
    level = _plate_level(loadings)
    resting = _resting(frame_time, points, level)
    touch = np.stack([resting[k].any(axis=1) for k in (0, 1)], axis=1)
    touch = np.stack([_longer(frame_time, touch[:, k], SHORTEST_REST) for k in (0, 1)], axis=1)
    for loading in loadings:
        _own(loading, points, touch)
    excluded = np.zeros((n, 2), dtype=bool)
    for loading in loadings:
        _exclude_shared(loading, loadings, points, resting, touch, excluded)
        _exclude_partial(loading, plates, points, resting, excluded)

    force, moment = np.zeros((n, 2, 3)), np.zeros((n, 2, 3))
    height, weight = np.zeros((n, 2)), np.zeros((n, 2))
    measured = np.zeros((n, 2), dtype=bool)
    for loading in loadings:
        for k in (0, 1):
            mine = loading.owner == k
            at = loading.frames[mine]
            f, c = loading.force[mine], loading.cop[mine]
            force[at, k] += f
            moment[at, k] += np.cross(c, f) + loading.free[mine, None] * [0.0, 0.0, 1.0]
            height[at, k] += f[:, 2] * c[:, 2]
            weight[at, k] += f[:, 2]
            measured[at, k] = True
    point = np.full((n, 2, 3), np.nan)
    torque = np.zeros((n, 2, 3))
    with np.errstate(invalid="ignore", divide="ignore"):
        z = height / weight
    carried = measured & (force[..., 2] > 0)
    point[carried], torque[carried, 2] = _cop(force[carried], moment[carried], z[carried])
    force[~carried] = 0.0

    unmeasured = _unmeasured(frame_time, touch, measured)
    seen = _clock(plates, frame_time)
    valid_side = ~unmeasured & ~excluded & seen[:, None]
    valid = np.array([bool(both.all()) for both in valid_side], dtype=bool)
    _describe(notes, frame_time, loadings, unmeasured, seen, bool(plates))
    uses = tuple(
        PlateUse(
            loading.plate.name,
            _owner_name(loading.owner),
            int(loading.frames[0]),
            int(loading.frames[-1]) + 1,
            loading.peak,
            loading.problem,
        )
        for loading in loadings
    )
    return FootForces(force, point, torque, valid_side, valid, uses, tuple(notes))


def over_plates(
    plates: tuple[ForcePlate, ...], foot_points: Mapping[str, Float[Array, "n_frames n_points 3"]]
) -> Bool[Array, " n_frames"]:
    """Return the frames in which both soles are over plates whole, so that nothing escapes them.

    Args:
        plates: Force plates; those whose corners are not known do not count.
        foot_points: As for :func:`assign_plates`.
    """
    points = np.concatenate([foot_points[side] for side in SIDES], axis=1)
    outside = [_outside(p.corners, points) for p in plates if p.corners is not None]
    if not outside:
        return np.zeros(len(points), dtype=bool)
    return (np.min(outside, axis=0) < BESIDE).all(axis=1)


def sole_points(
    human: Human, qpos: Float[Array, "n_frames nq"]
) -> dict[str, Float[Array, "n_frames n_points 3"]]:
    """Return points of each foot's sole over a motion, heel first [m].

    They are the lowest points of the contact spheres.
    """
    model = human.model
    carriers = Carriers(human)
    result = {}
    for side in SIDES:
        geoms = carriers.geoms[side]
        bodies = [human.body_names[b - 1] for b in model.geom_bodyid[geoms]]
        spheres = PointSet(human, bodies, model.geom_pos[geoms])
        order = np.argsort(spheres.path(human.standing()[None])[0, :, 0], kind="stable")
        places = spheres.path(qpos)
        places[..., 2] -= model.geom_size[geoms, 0]
        result[side] = places[:, order]
    return result


# ------------------------------------------------------------------------------------- loadings


def _loadings(
    plate: ForcePlate,
    frame_time: np.ndarray,
    cutoff: float | None,
    threshold: float,
) -> list[_Loading]:
    """Return a plate's contacts, smoothed and on the frames."""
    found = []
    for contact in contact_events(plate.time, plate.force[:, 2], threshold):
        start = plate.time[0] if contact.start is None else contact.start
        stop = plate.time[-1] if contact.stop is None else contact.stop
        inside = np.flatnonzero((plate.time >= start) & (plate.time <= stop))
        frames = np.flatnonzero((frame_time >= start - 1e-9) & (frame_time <= stop + 1e-9))
        if len(inside) < 2 or len(frames) == 0:
            continue
        force, cop = plate.force[inside], plate.cop[inside]
        known = np.isfinite(cop).all(axis=1) & np.isfinite(force).all(axis=1)
        if known.sum() < 2:
            continue
        inside, force, cop = inside[known], force[known], cop[known]
        time = plate.time[inside]
        about = cop.mean(axis=0)  # the fixed point: near the foot, for the sake of round-off
        moment = np.cross(cop - about, force)
        moment[:, 2] += plate.free_moment[inside]
        load = (force[:, 2] * (cop[:, 2] - about[2]))[:, None]
        signal = np.hstack([force, moment, load])
        even = np.arange(inside[0], inside[-1] + 1)
        if len(even) != len(inside):  # samples without centre of pressure inside a contact
            signal = np.stack(
                [np.interp(plate.time[even], time, column) for column in signal.T], axis=1
            )
            time = plate.time[even]
        if cutoff is not None and len(time) >= 4 and cutoff < 0.4 * rate_of(time):
            signal = lowpass(time, signal, cutoff=cutoff)
        wanted = frame_time[frames]
        signal = np.stack([np.interp(wanted, time, column) for column in signal.T], axis=1)
        force, moment, load = signal[:, :3], signal[:, 3:6], signal[:, 6]
        up = force[:, 2] > 0.05 * threshold
        if not up.any():
            continue
        frames, force, moment, load = frames[up], force[up], moment[up], load[up]
        cop, free = _cop(force, moment, load / force[:, 2])
        found.append(
            _Loading(
                plate, frames, force, cop + about, free, contact.peak, np.full(len(frames), -1)
            )
        )
    return found


def _cop(force, moment, height) -> tuple[np.ndarray, np.ndarray]:
    """Return centre of pressure at ``height`` and free moment of wrenches about the origin."""
    x = (height * force[:, 0] - moment[:, 1]) / force[:, 2]
    y = (height * force[:, 1] + moment[:, 0]) / force[:, 2]
    free = moment[:, 2] - (x * force[:, 1] - y * force[:, 0])
    return np.stack([x, y, height], axis=1), free


def _plate_level(loadings: list[_Loading]) -> float:
    """Return the height of the plates [m]; NaN without any."""
    heights = [np.median(loading.cop[:, 2]) for loading in loadings]
    return float(np.median(heights)) if heights else float("nan")


def _clock(plates, frame_time) -> np.ndarray:
    """Return the frames that every plate covers."""
    seen = np.ones(len(frame_time), dtype=bool)
    for plate in plates:
        if len(plate.time):
            step = 1.0 / rate_of(plate.time) if len(plate.time) > 1 else 0.0
            seen &= frame_time >= plate.time[0] - step
            seen &= frame_time <= plate.time[-1] + step
    return seen


# ----------------------------------------------------------------------------------------- feet


def _resting(time, points: list[np.ndarray], level: float) -> list[np.ndarray]:
    """Return per side which points of the sole rest on the ground, (n_frames, n_points)."""
    ends = [np.stack([p[:, i] for p in points[::-1]], axis=1) for i in (0, -1)]  # left, right
    ground = ground_velocity(time, *ends)
    resting = []
    for p in points:
        z = p[..., 2]
        if len(time) >= 4:
            smooth = lowpass(time, p, cutoff=12.0) if rate_of(time) > 60 else p
            speed = np.linalg.norm(derivative(time, smooth) - ground[:, None], axis=-1)
        else:
            speed = np.zeros(p.shape[:2])
        # The level at which the sole comes to rest takes up what the model's foot is off the real
        # one's, but no more than a foot can be off: a foot that stays in the air does not rest.
        still = speed.min(axis=1) < SLOW / 2
        lowest = z.min(axis=1)
        floor = float(np.median(lowest[still])) if still.any() else float(lowest.min())
        if np.isfinite(level):
            floor = float(np.clip(floor, level - 0.05, level + 0.05))
        resting.append((z < floor + LOW) & (speed < SLOW))
    return resting


def _longer(time, flags, shortest) -> np.ndarray:
    """Return the flags without runs shorter than ``shortest`` seconds."""
    result = flags.copy()
    for run in runs(flags):
        if time[run.stop - 1] - time[run.start] < shortest:
            result[run] = False
    return result


def _distance(sole: np.ndarray, cop: np.ndarray) -> np.ndarray:
    """Return the horizontal distance of each point from a sole, (n_frames,) [m].

    A sole is the set of all lines between its points: dense enough for a foot.
    """
    p, c = sole[..., :2], cop[:, None, :2]
    i, j = np.triu_indices(p.shape[1], 1)
    if len(i) == 0:
        return np.linalg.norm(p[:, 0] - c[:, 0], axis=-1)
    a, edge = p[:, i], p[:, j] - p[:, i]
    square = np.maximum((edge**2).sum(axis=-1), 1e-12)
    along = np.clip(((c - a) * edge).sum(axis=-1) / square, 0.0, 1.0)
    return np.linalg.norm(c - a - along[..., None] * edge, axis=-1).min(axis=1)


def _own(loading: _Loading, points: list[np.ndarray], touch: np.ndarray) -> None:
    """Find whose foot is at the centre of pressure, frame by frame where it changes."""
    frames = loading.frames
    if loading.plate.side in SIDES:
        loading.owner[:] = SIDES.index(loading.plate.side)
        return
    far = np.stack([_distance(p[frames], loading.cop) for p in points], axis=1)
    load = loading.force[:, 2]
    typical = np.array([_weighted_median(far[:, k], load) for k in (0, 1)])
    best = int(np.argmin(typical))
    other = 1 - best
    loading.owner[:] = best
    # One foot after the other without the plate coming free in between: a belt, a long plate.
    changes = (far[:, other] < NEAR / 2) & (far[:, best] > NEAR / 2) & touch[frames, other]
    if load[changes].sum() > 0.1 * load.sum():
        nearer = np.where(far[:, best] <= far[:, other], best, other)
        stands = touch[frames]
        nearer = np.where(stands[:, best] & ~stands[:, other], best, nearer)
        nearer = np.where(stands[:, other] & ~stands[:, best], other, nearer)
        loading.owner[:] = np.where(far[np.arange(len(frames)), nearer] < NEAR, nearer, -1)
    elif not typical[best] < NEAR:
        loading.owner[:] = -1
        loading.problem = "no foot was at the centre of pressure"


def _weighted_median(values, weights) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, 0.5 * total[-1])])


def _exclude_shared(loading, loadings, points, resting, touch, excluded) -> None:
    """Mark frames in which the other foot also stands on this plate."""
    nobody = loading.owner < 0
    excluded[loading.frames[nobody]] = True
    if loading.plate.side in SIDES:
        return
    shared = np.zeros(len(loading.frames), dtype=bool)
    for k in (0, 1):
        frames = loading.frames
        elsewhere = np.isin(
            frames,
            np.concatenate(
                [o.frames[o.owner == 1 - k] for o in loadings if o.plate is not loading.plate]
                or [np.empty(0, dtype=int)]
            ),
        )
        mine = (loading.owner == k) & touch[frames, 1 - k]
        if loading.plate.corners is not None:
            inside = _outside(loading.plate.corners, points[1 - k][frames]) < -0.01
            on = (inside & resting[1 - k][frames]).any(axis=1)
            # Beside a second plate that also carries it, a foot on the edge is no third case.
            shared |= mine & on & ~(elsewhere & (_distance(points[k][frames], loading.cop) < 0.02))
        else:
            off = _distance(points[k][frames], loading.cop) > SHARED
            shared |= mine & ~elsewhere & off
    # The instants around heel strike and toe off, where low and slow is not yet carrying, hurt
    # nobody; a real double support lasts longer.
    if shared.sum() >= 3:
        excluded[loading.frames[shared]] = True
        loading.problem = loading.problem or "both feet were on it"


def _exclude_partial(loading, plates, points, resting, excluded) -> None:
    """Mark a loading during which its foot rests partly beside every plate."""
    if loading.plate.corners is None or loading.plate.side in SIDES:
        return
    for k in (0, 1):
        frames = loading.frames[loading.owner == k]
        if len(frames) == 0:
            continue
        outside = [_outside(p.corners, points[k][frames]) for p in plates if p.corners is not None]
        beside = np.min(outside, axis=0) > BESIDE
        partly = (beside & resting[k][frames]).any(axis=1)
        if partly.mean() > 0.1:
            excluded[frames, k] = True
            loading.problem = loading.problem or "the foot was partly beside it"


def _outside(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return how far points are outside a plate, negative inside, (n_frames, n_points) [m]."""
    c = corners[:, :2]
    centre = c.mean(axis=0)
    far = np.full(points.shape[:2], -np.inf)
    for a, b in zip(c, np.roll(c, -1, axis=0), strict=True):
        edge = b - a
        length = np.linalg.norm(edge)
        if length < 1e-9:
            continue
        normal = np.array([edge[1], -edge[0]]) / length
        normal = -normal if normal @ (centre - a) > 0 else normal
        far = np.maximum(far, (points[..., :2] - a) @ normal)
    return far


def _unmeasured(time, touch: np.ndarray, measured: np.ndarray) -> np.ndarray:
    """Return frames in which a foot rests on the ground and no plate says with what force.

    Where a foot was on a plate the plate knows best when: the part of a rest before and after
    the loading is forgiven up to :data:`EDGE`. Where it was on none, :data:`MARGIN` is added,
    unless that reaches into a loading.
    """
    missing = np.zeros_like(touch)
    for k in (0, 1):
        for run in runs(touch[:, k]):
            frames = np.arange(run.start, run.stop)
            on = measured[frames, k]
            if not on.any():
                missing[:, k] |= (time >= time[run.start] - MARGIN) & (
                    time <= time[run.stop - 1] + MARGIN
                )
                continue
            for gap in runs(~on):
                a, b = frames[gap.start], frames[gap.stop - 1]
                if time[b] - time[a] > EDGE:
                    missing[a : b + 1, k] = True
    return missing & ~measured


# -------------------------------------------------------------------------------------- wording


def _owner_name(owner: np.ndarray) -> str:
    known = owner[owner >= 0]
    if len(known) == 0:
        return ""
    return "".join(SIDES[k] for k in (0, 1) if (known == k).any())


def _describe(notes, time, loadings, unmeasured, seen, any_plate) -> None:
    for loading in loadings:
        if loading.problem:
            span = f"{time[loading.frames[0]]:.2f} to {time[loading.frames[-1]]:.2f} s"
            notes.append(
                f"force plate {loading.plate.name}, {span}: {loading.problem}; its frames are left "
                "out of the moments."
            )
    names = {"r": "right", "l": "left"}
    for k, side in enumerate(SIDES):
        share = float(unmeasured[:, k].mean()) if len(unmeasured) else 0.0
        if share > 0 and any_plate:
            notes.append(
                f"the {names[side]} foot stands without a force plate under it in {share:.0%} of "
                "the frames; its moments are not known there."
            )
    if not seen.all():
        notes.append(f"forces were measured in {seen.mean():.0%} of the frames only.")


def _check(time, foot_points) -> list[np.ndarray]:
    missing = [s for s in SIDES if s not in foot_points]
    if missing:
        raise ParameterError(f"foot_points lacks side {missing[0]!r}; give 'r' and 'l'")
    points = [np.asarray(foot_points[s], dtype=float) for s in SIDES]
    for side, p in zip(SIDES, points, strict=True):
        if p.ndim != 3 or p.shape[0] != len(time) or p.shape[2] != 3 or p.shape[1] == 0:
            raise ParameterError(
                f"points of foot {side} have shape {p.shape}; {len(time)} frames need "
                f"({len(time)}, n_points, 3)"
            )
    return points

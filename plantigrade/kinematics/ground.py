"""Feet and the ground: where contact points are, when they rest, and how to keep them there.

The ground is the plane z = 0. A foot is in contact region by region: heel, ball (metatarsal
heads) and toes come down and leave one after another. A region rests while its lowest point is
near the ground and nearly still; :func:`plant_feet` then holds it at one spot of the ground and
changes the rest of the body as little as it can.
"""

from dataclasses import dataclass

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import FitError
from plantigrade.kinematics.inverse import InverseKinematics
from plantigrade.kinematics.terms import Terms, follow
from plantigrade.models import Human
from plantigrade.motion.filters import lowpass, runs
from plantigrade.motion.ground_velocity import ground_velocity
from plantigrade.motion.recording import even_clock
from plantigrade.spatial.conventions import rotation_matrix

SIDES = ("r", "l")
NEAR = 0.035  # a region higher above the ground than this does not rest [m]
SLOW = 0.35  # a region faster than this does not come to rest [m/s] …
STILL = 0.22  # … and one slower than this rests
SHORTEST = 0.06  # shortest rest [s]
LANDING = 0.12  # time over which a foot comes to its spot on the ground and leaves it [s]
STEEPEST = 0.035  # a slope of the ground steeper than this is no fault of the recording
LEVELS = 0.04  # heights of rest that differ by less belong to one level [m]
SMOOTH = 10.0  # low-pass of the points before their speed is taken [Hz]

_REGIONS = {"heel": "heel", "metatarsal": "ball", "toe": "toes", "base": "middle"}
SLIDES = 0.03  # a foot that rests for a second and strays further slides or pivots indeed [m]
SINKS = 0.002  # a point this deep in the ground is lifted in another pass [m]
PASSES = 4

_PLANTED = 1.0  # weight of the foot's points
_HELD = {"pelvis": 0.06, "knee": 0.01}  # weights of points that stay where they were
_POSTURE = 4e-4  # pull of each hinge to where it was [m^2/rad^2]
_FOOT_POSTURE = 2e-3  # the same of joints within the foot


@dataclass(frozen=True)
class ContactPoints:
    """The points of a Human's soles over a motion.

    Attributes:
        position: Touching point of each contact sphere: straight below its centre [m].
        centre: Its centre in the frame of its body [m].
        body: Its body's name.
        radius: Its radius [m].
        side: ``"r"`` or ``"l"`` of each point.
        region: ``"heel"``, ``"ball"``, ``"toes"`` or ``"middle"`` of each point.
    """

    position: Float[Array, "n_frames n_points 3"]
    centre: Float[Array, "n_points 3"]
    body: tuple[str, ...]
    radius: Float[Array, " n_points"]
    side: tuple[str, ...]
    region: tuple[str, ...]

    def of(self, side: str, region: str | None = None) -> np.ndarray:
        """Return the indices of a foot's points, of one region or of all."""
        return np.array(
            [
                i
                for i, (s, r) in enumerate(zip(self.side, self.region, strict=True))
                if s == side and region in (None, r)
            ],
            dtype=int,
        )


@dataclass(frozen=True)
class Rest:
    """One rest of a region of a foot on the ground: frames ``start`` to before ``stop``."""

    side: str
    region: str
    start: int
    stop: int


def contact_points(human: Human, qpos: Float[Array, "n_frames nq"]) -> ContactPoints:
    """Return where the points of the soles are in every frame."""
    model = human.model
    data = mujoco.MjData(model)
    geoms = np.array([model.geom(name).id for name, _, _ in human.contact_points])
    radius = model.geom_size[geoms, 0].copy()
    position = np.empty((len(qpos), len(geoms), 3))
    for k, q in enumerate(qpos):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        position[k] = data.geom_xpos[geoms]
    position[..., 2] -= radius
    names = [name for name, _, _ in human.contact_points]
    plain = [
        name.removeprefix(f"contact_{segment}_")
        for name, (_, _, segment) in zip(names, human.contact_points, strict=True)
    ]
    return ContactPoints(
        position,
        model.geom_pos[geoms].copy(),
        tuple(human.body_names[model.geom_bodyid[g] - 1] for g in geoms),
        radius,
        tuple(side for _, side, _ in human.contact_points),
        tuple(next(r for word, r in _REGIONS.items() if p.startswith(word)) for p in plain),
    )


def lowest(human: Human, qpos: Float[Array, "n_frames nq"]) -> Float[Array, " n_frames"]:
    """Return the height of the lowest point of the soles in every frame [m]."""
    return contact_points(human, qpos).position[..., 2].min(axis=1)


def find_rests(
    contact: ContactPoints,
    rate: float,
    *,
    way: Float[Array, "n_frames 3"] | None = None,
    stance: Bool[Array, "n_frames 2"] | None = None,
) -> list[Rest]:
    """Return when each region of each foot rests on the ground.

    Args:
        contact: The points of the soles.
        rate: Frames per second [Hz].
        way: Path of the ground itself (a treadmill's belt) [m].
        stance: Where the foot stands at all (right, left), if that is known.
    """
    n = len(contact.position)
    position = contact.position - (0.0 if way is None else way[:, None])
    time = np.arange(n) / rate
    rests = []
    for s, side in enumerate(SIDES):
        for region in ("heel", "ball", "toes"):
            index = contact.of(side, region)
            if not len(index):
                continue
            height = position[:, index, 2].min(axis=1)
            speed = _speed(time, position[:, index].mean(axis=1))
            near = height < NEAR
            calm = _hysteresis(speed, STILL, SLOW) & near
            if stance is not None:
                calm &= stance[:, s]
            for run in runs(calm):
                if run.stop - run.start >= max(2, SHORTEST * rate):
                    rests.append(Rest(side, region, run.start, run.stop))
    return rests


def moving_ground(
    time: Float[Array, " n_frames"],
    heel: Float[Array, "n_frames 2 3"],
    toe: Float[Array, "n_frames 2 3"],
) -> Float[Array, "n_frames 3"]:
    """Return the path of the ground under the feet [m]: zero overground, the belt's on a treadmill.

    Args:
        time: Time of each frame [s].
        heel: Heels (or ankles), left then right [m].
        toe: Toes (or toe bases), left then right [m].
    """
    velocity = ground_velocity(time, heel, toe)
    velocity[:, 2] = 0.0
    time = even_clock(time)
    return np.cumsum(velocity * np.diff(time, prepend=time[0])[:, None], axis=0)


def _speed(time: np.ndarray, path: np.ndarray) -> np.ndarray:
    if len(time) < 3:
        return np.zeros(len(time))
    rate = (len(time) - 1) / (time[-1] - time[0])
    if len(time) > 15 and rate > 2.5 * SMOOTH:
        path = lowpass(time, path, cutoff=SMOOTH)
    return np.linalg.norm(np.gradient(path, time, axis=0), axis=-1)


def _hysteresis(value: np.ndarray, low: float, high: float) -> np.ndarray:
    """Return where the value is below ``high`` in a run that is somewhere below ``low``."""
    below = value < high
    for run in runs(below):
        if value[run].min() >= low:
            below[run] = False
    return below


def stance_of(rests: list[Rest], n_frames: int) -> Bool[Array, "n_frames 2"]:
    """Return which foot (right, left) stands in which frame."""
    stance = np.zeros((n_frames, 2), dtype=bool)
    for rest in rests:
        stance[rest.start : rest.stop, SIDES.index(rest.side)] = True
    return stance


def ground_under(
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    rate: float,
    *,
    way: Float[Array, "n_frames 3"] | None = None,
) -> Float[Array, " n_frames"] | None:
    """Return the height of the ground under the body in every frame [m]; None if no foot rests.

    The heights at which the feet come to rest tell the level of the ground; of several levels (a
    stair, a box, a foot held still in the air) the lowest with a tenth of the time counts. Where
    feet rest at more than two places, a slope of at most :data:`STEEPEST` is taken too: the
    floor of a capture volume is rarely level to a degree.
    """
    places = _resting_places(human, qpos, rate, way)
    if places is None:
        return None
    level, weight, spots = places
    low = _quantile(level, weight, 0.1)
    near = np.abs(level - low) <= LEVELS
    plane = np.array([_quantile(level[near], weight[near], 0.5), 0.0, 0.0])
    centre = spots[near].mean(axis=0)
    for _ in range(5):
        slope = np.hypot(*plane[1:])
        if np.ptp(spots, axis=0).max() < 1.0 or slope > STEEPEST:
            break
        here = plane[0] + (spots - centre) @ plane[1:]
        near = np.abs(level - here) <= LEVELS
        if near.sum() < 3:
            break
        # Slopes across the path rest on little: they are held near zero.
        w = np.sqrt(weight[near] / weight[near].sum())
        A = np.column_stack([np.ones(near.sum()), spots[near] - centre])
        spread = np.array([1e-4, 0.15, 0.15])  # [m]: spots closer than this tell no slope
        system = np.vstack([A * w[:, None], np.diag(spread)])
        right = np.concatenate([level[near] * w, [1e-4 * plane[0], 0.0, 0.0]])
        plane = np.linalg.lstsq(system, right, rcond=None)[0]
    if np.hypot(*plane[1:]) > STEEPEST:
        plane = np.array([_quantile(level[near], weight[near], 0.5), 0.0, 0.0])
    here = qpos[:, :2] - (0.0 if way is None else way[:, :2])
    low, high = spots.min(axis=0), spots.max(axis=0)
    return plane[0] + (np.clip(here, low, high) - centre) @ plane[1:]


def _resting_places(human, qpos, rate, way):
    """Return height, duration and spot on the ground of every rest of the feet, None if none."""
    contact = contact_points(human, qpos)
    position = contact.position - (0.0 if way is None else way[:, None])
    time = np.arange(len(qpos)) / rate
    levels, weights, spots = [], [], []
    for side in SIDES:
        index = contact.of(side)
        height = position[:, index, 2]
        which = height.argmin(axis=1)
        every = np.arange(len(qpos))
        speed = np.stack([_speed(time, position[:, i]) for i in index], axis=1)
        still = speed[every, which] < STILL
        for run in runs(still):
            if run.stop - run.start >= max(2, SHORTEST * rate):
                levels.append(float(np.median(height[run].min(axis=1))))
                weights.append(float(run.stop - run.start))
                spots.append(np.median(position[run][:, index, :2].mean(axis=1), axis=0))
    if not levels:
        return None
    return np.array(levels), np.array(weights), np.array(spots)


def _quantile(values: np.ndarray, weights: np.ndarray, share: float) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    at = min(int(np.searchsorted(total, share * total[-1])), len(values) - 1)
    return float(values[order][at])


def level(
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    rate: float,
    *,
    way: Float[Array, "n_frames 3"] | None = None,
) -> tuple[Float[Array, "n_frames nq"], Float[Array, " n_frames"]]:
    """Return the motion moved vertically so that standing feet are on the ground, and by how much.

    Where no foot ever rests, the lowest point of the whole motion is put on the ground.

    Args:
        human: The person.
        qpos: The motion.
        rate: Frames per second [Hz].
        way: Path of the ground itself (a treadmill's belt) [m].
    """
    ground = ground_under(human, qpos, rate, way=way)
    if ground is None:
        ground = np.full(len(qpos), lowest(human, qpos).min())
    result = qpos.copy()
    result[:, 2] -= ground
    return result, -ground


def plant_feet(
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    stance: Bool[Array, "n_frames 2"] | None = None,
    *,
    rate: float,
    rests: list[Rest] | None = None,
    way: Float[Array, "n_frames 3"] | None = None,
    progress=None,
) -> Float[Array, "n_frames nq"]:
    """Return the motion with feet that neither slide nor sink, changed as little as possible.

    Every region of a foot that rests is held where it rests on the mean; before and after, the
    correction fades in and out. Points that would sink into the ground are lifted onto it. The
    legs and, less, the pelvis follow; all else keeps its joint angles.

    Args:
        human: The person.
        qpos: The motion.
        stance: Which foot (right, left) stands when; found from the motion where not given.
        rate: Frames per second [Hz].
        rests: What rests when; found from the motion where not given.
        way: Path of the ground itself (a treadmill's belt) [m].
        progress: Called with the number of frames done, now and then.
    """
    n = len(qpos)
    if n < 2:
        return qpos.copy()
    path = np.zeros((n, 3)) if way is None else way
    contact = contact_points(human, qpos)
    if rests is None:
        rests = find_rests(contact, rate, way=path, stance=stance)
    solver, held = _planting_solver(human, contact)
    fade = max(2, round(LANDING * rate))
    wanted, weight = _wanted(contact, rests, path, fade)
    # The pelvis and knees follow the feet's common lift, so that legs keep their angles.
    lift = ((wanted - contact.position)[..., 2] * weight).sum(axis=1) / weight.sum(axis=1)
    result = qpos
    for attempt in range(PASSES):
        values = np.empty((n, len(held), 3))
        for k, q in enumerate(qpos):
            values[k] = solver.points.at(q)[-len(held) :]
        values[..., 2] += lift[:, None]
        goal = wanted.copy()
        goal[..., 2] += contact.radius
        result = follow(
            solver,
            np.concatenate([goal, values], axis=1),
            result if attempt else qpos,
            weights=np.concatenate([_PLANTED * weight, np.tile(held, (n, 1))], axis=1),
            rest=qpos[:, 7:],
            progress=progress if attempt == 0 else None,
        )
        # Points that sink all the same are asked for again, above the ground by as much.
        depth = np.maximum(0.0, -contact_points(human, result).position[..., 2])
        sunk = depth > SINKS
        if not sunk.any():
            break
        wanted[..., 2] += np.where(depth > 0.5 * SINKS, np.minimum(depth, 0.02), 0.0)
        weight = np.where(sunk, np.minimum(4.0 * weight, 16.0), weight)
    return result


def _planting_solver(human: Human, contact: ContactPoints):
    """Return inverse kinematics on soles, pelvis and knees, and the weights of the last two."""
    points = list(zip(contact.body, contact.centre, strict=True))
    held = []
    for offset in np.vstack([np.zeros(3), 0.25 * np.eye(3)]):
        points.append(("pelvis", offset))
        held.append(_HELD["pelvis"])
    for side in SIDES:
        body, position = human.skeleton.parts[f"tibia_{side}"]
        points.append((body, np.asarray(position)))
        held.append(_HELD["knee"])
    terms = Terms(human, points, [(i, -1) for i in range(len(points))])
    solver = InverseKinematics(terms, tolerance=1e-4, max_iterations=12)
    solver.posture = np.full(len(solver.rest), _POSTURE)
    words = ("mtp", "cuboid", "heel")
    inner = [i for i, c in enumerate(human.coordinates) if c.startswith(words)]
    solver.posture[inner] = _FOOT_POSTURE
    return solver, np.array(held)


def _wanted(contact: ContactPoints, rests: list[Rest], way: np.ndarray, fade: int):
    """Return where each point of the soles should be, and how much that matters.

    A region at rest is moved as a whole: horizontally to its mean place, each of its points down
    (or up) to the ground. The correction of a point fades out over ``fade`` frames, and crosses
    over to the next one where two are closer than that.
    """
    n, m = contact.position.shape[:2]
    position = contact.position - way[:, None]
    shift = np.full((n, m, 3), np.nan)
    for rest, core in _cores(rests):
        index = contact.of(rest.side, rest.region)
        frames = slice(rest.start, rest.stop)
        path = position[frames, index]
        centre = path.mean(axis=1)[:, :2]
        spot = np.median(position[core][:, index, :2].mean(axis=1), axis=0)
        if len(centre) > 8 * fade and np.linalg.norm(centre - spot, axis=1).max() > SLIDES:
            spot = _slow(centre, fade)
        shift[frames, index, :2] = (spot - centre)[:, None]
        shift[frames, index, 2] = -path[..., 2]
    offset = np.zeros((n, m, 3))
    for all_points in (contact.of(side) for side in SIDES):
        resting = np.isfinite(shift[:, all_points, 0])
        # What a free point of a foot takes over from the regions of it that rest.
        common = np.zeros((n, 3))
        some = np.asarray(resting.any(axis=1))
        common[some] = np.nanmean(shift[some][:, all_points], axis=1)
        common = _faded(common, some, fade)
        for i in all_points:
            own = np.isfinite(shift[:, i, 0])
            near = _nearness(own, fade)[:, None]
            filled = _held(np.nan_to_num(shift[:, i]), own) - common
            offset[:, i] = common + near * filled
    wanted = position + offset
    weight = np.full((n, m), 0.3)
    for i in range(m):
        weight[:, i] = 0.3 + 0.7 * _nearness(np.isfinite(shift[:, i, 0]), fade)
    sunk = wanted[..., 2] < 0
    wanted[..., 2] = np.where(sunk, 0.0, wanted[..., 2])
    weight[sunk] = np.maximum(weight[sunk], 1.0)
    return wanted + way[:, None], weight


def _slow(path: np.ndarray, fade: int) -> np.ndarray:
    """Return the path without what is faster than some ``fade`` frames."""
    k = np.arange(-4 * fade, 4 * fade + 1)
    window = np.exp(-0.5 * (k / (1.5 * fade)) ** 2)
    padded = np.pad(path, ((4 * fade, 4 * fade), (0, 0)), mode="edge")
    return np.stack([np.convolve(x, window / window.sum(), "valid") for x in padded.T], axis=1)


def _cores(rests: list[Rest]) -> list[tuple[Rest, np.ndarray]]:
    """Return each rest with the frames that tell its place.

    Regions of a foot that rest at the same time are parts of one thing: their places are taken
    from the same frames, those in which most of them rest, so that they fit together.
    """
    result = []
    for side in SIDES:
        mine = sorted((r for r in rests if r.side == side), key=lambda r: r.start)
        groups: list[list[Rest]] = []
        for rest in mine:
            if groups and rest.start < max(r.stop for r in groups[-1]):
                groups[-1].append(rest)
            else:
                groups.append([rest])
        for group in groups:
            start, stop = group[0].start, max(r.stop for r in group)
            count = np.zeros(stop - start, int)
            for r in group:
                count[r.start - start : r.stop - start] += 1
            for r in group:
                own = count[r.start - start : r.stop - start]
                result.append((r, r.start + np.flatnonzero(own == own.max())))
    return result


def _nearness(inside: np.ndarray, fade: int) -> np.ndarray:
    """Return 1 where ``inside``, falling smoothly to 0 over ``fade`` frames around it."""
    if not inside.any():
        return np.zeros(len(inside))
    k = np.arange(len(inside))
    where = np.flatnonzero(inside)
    after = np.searchsorted(where, k)
    gap = np.minimum(
        np.abs(k - where[np.clip(after, 0, len(where) - 1)]),
        np.abs(k - where[np.clip(after - 1, 0, len(where) - 1)]),
    )
    s = np.clip(1 - gap / fade, 0, 1)
    return s * s * (3 - 2 * s)


def _held(values: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Return values carried over gaps: linear between two runs, constant at the ends."""
    if not inside.any():
        return np.zeros_like(values)
    k = np.arange(len(values))
    where = np.flatnonzero(inside)
    return np.stack([np.interp(k, where, values[where, i]) for i in range(values.shape[1])], 1)


def _faded(values: np.ndarray, inside: np.ndarray, fade: int) -> np.ndarray:
    return _held(values, inside) * _nearness(inside, fade)[:, None]


def drift_of(
    contact: ContactPoints, rests: list[Rest], way: Float[Array, "n_frames 3"] | None = None
) -> Float[Array, " n_rests"]:
    """Return how far each resting region strays from its mean place on the ground [m]."""
    position = contact.position - (0.0 if way is None else way[:, None])
    result = []
    for rest in rests:
        index = contact.of(rest.side, rest.region)
        centre = position[rest.start : rest.stop, index, :2].mean(axis=1)
        result.append(float(np.linalg.norm(centre - centre.mean(axis=0), axis=1).max()))
    return np.array(result)


def penetration_of(contact: ContactPoints) -> Float[Array, " n_frames"]:
    """Return how deep the lowest point of the soles lies below the ground in every frame [m]."""
    return np.maximum(0.0, -contact.position[..., 2].min(axis=1))


def forward_path(
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    stance: Bool[Array, "n_frames 2"] | None = None,
    *,
    rate: float,
    vertical: bool = True,
) -> Float[Array, "n_frames nq"]:
    """Return the motion with a root path on which the standing foot stays where it is.

    For motions that say nothing of where the pelvis goes. In every step of time the points of
    the soles nearest to the ground stand still on the mean; in flight the velocity is kept. Where
    nobody says which foot stands, it is the lower one; of two feet that pass one another near the
    ground it is the one that falls behind the pelvis (in walking backward: that gets ahead of it),
    for a swinging foot may come as near to the ground as the standing one.

    Args:
        human: The person.
        qpos: The motion; its horizontal root position is replaced.
        stance: Which foot (right, left) stands when.
        rate: Frames per second [Hz].
        vertical: Whether the height is replaced too: lowest point of the standing foot at 0.

    Raises:
        FitError: If ``stance`` is given and no foot ever stands.
    """
    n = len(qpos)
    if stance is not None and not stance.any():
        raise FitError("no foot ever stands, so the path of the body cannot be told from the feet")
    result = qpos.copy()
    result[:, :2] = 0.0
    contact = contact_points(human, result)
    position, sides = contact.position, np.array([SIDES.index(s) for s in contact.side])
    may = np.ones((n, len(sides)), bool) if stance is None else stance[:, sides]
    height = np.where(may, position[..., 2], np.inf)
    bottom = height.min(axis=1)
    flying = ~np.isfinite(bottom)
    close = np.exp(-((np.where(may, height - np.where(flying, 0, bottom)[:, None], 1.0)) / 0.006))
    close[flying] = 0.0
    if stance is None:
        close = close * _falls_behind(result, position, sides, rate)
    step = np.zeros((n, 2))
    for k in range(n - 1):
        w = close[k] + close[k + 1]
        if flying[k] and flying[k + 1] or w.sum() < 1e-6:
            step[k + 1] = step[k]
        else:
            moved = position[k + 1, :, :2] - position[k, :, :2]
            step[k + 1] = -(w @ moved) / w.sum()
    result[:, :2] = np.cumsum(step, axis=0)
    if vertical:
        k = np.arange(n)
        result[:, 2] -= np.interp(k, k[~flying], bottom[~flying])
    return result


PASSING = 0.3  # feet that move apart faster than this along the way pass one another [m/s]
AS_LOW = 0.04  # a foot higher than this above the other does not stand [m]


def _falls_behind(qpos, position, sides, rate: float) -> Float[Array, "n_frames n_points"]:
    """Return 1 for points of feet that may stand, nearly 0 for those of a foot that swings past.

    Args:
        qpos: The motion with the pelvis on one spot.
        position: Points of the soles in it [m].
        sides: Foot of each point.
        rate: Frames per second [Hz].
    """
    ahead = rotation_matrix(qpos[:, 3:7])[:, :2, 0]
    ahead = ahead / np.maximum(np.linalg.norm(ahead, axis=1), 1e-9)[:, None]
    speed, low = np.empty((len(qpos), 2)), np.empty((len(qpos), 2))
    for k in (0, 1):
        mine = position[:, sides == k]
        moved = np.gradient(mine[..., :2].mean(axis=1), axis=0) * rate
        speed[:, k] = np.einsum("nd,nd->n", moved, ahead)
        low[:, k] = mine[..., 2].min(axis=1)
    near = np.abs(low[:, 0] - low[:, 1]) < AS_LOW
    passing = near & (np.abs(speed[:, 0] - speed[:, 1]) > PASSING)
    behind = speed.argmin(axis=1)
    # Walking forward, the foot that falls behind is the lower one on the mean; backward, the other.
    rows = np.arange(len(qpos))
    apart = np.abs(speed[:, 0] - speed[:, 1]) > PASSING
    if np.sum((low[rows, behind] - low[rows, 1 - behind])[apart]) > 0:
        behind = 1 - behind
    may = np.ones(position.shape[:2])
    may[passing[:, None] & (sides[None] != behind[:, None])] = 1e-3
    return may


__all__ = [
    "ContactPoints",
    "Rest",
    "contact_points",
    "drift_of",
    "find_rests",
    "forward_path",
    "ground_under",
    "level",
    "lowest",
    "moving_ground",
    "penetration_of",
    "plant_feet",
    "stance_of",
]

"""Feet that neither slide nor sink: regions at rest are held, the body changes as little as it can.

The ground is the plane z = 0.
"""

from collections.abc import Mapping

import numpy as np
from scipy.ndimage import distance_transform_cdt

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.inverse import InverseKinematics, Terms, follow
from plantigrade.kinematics.sole_paths import SolePaths, sole_paths
from plantigrade.kinematics.sole_rests import ContactFrames, find_rests
from plantigrade.models import Human
from plantigrade.motion.blends import cubic_rise
from plantigrade.motion.filters import bridged_gaps
from plantigrade.side_names import split_side

FADE_TIME = 0.12  # [s] time of a foot to settle on the ground and to leave it
MAX_DRIFT = 0.03  # [m] maximum drift of a foot at rest for a second; more is sliding or pivoting
MAX_DEPTH = 0.002  # [m] depth of a point that causes another pass
MAX_PASSES = 4  # [1] maximum number of passes of planting and lifting
_FOOT_WEIGHT = 1.0  # [1] weight of the foot's points
_BODY_WEIGHTS = {"pelvis": 0.06, "knee": 0.01}  # [1] weights of points that keep their position
_PELVIS_WEIGHT = 3.0  # [1] weight of points on a pelvis that keeps its position
_SOLE_ERROR = 0.006  # [m] sole error equivalent to a joint angle's spread
_POSTURE_WEIGHT = 4e-4  # [m²/rad²] weight of each hinge's change
_FOOT_POSTURE_WEIGHT = 2e-3  # [m²/rad²] weight of changes of joints within the foot


def plant_feet(
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    stance: Bool[Array, "n_frames 2"] | None = None,
    *,
    rate: float,
    rests: list[ContactFrames] | None = None,
    way: Float[Array, "n_frames 3"] | None = None,
    spread: Mapping[str, float] | None = None,
) -> Float[Array, "n_frames nq"]:
    """Return the motion with feet that neither slide nor sink, changed as little as possible.

    Every region of a foot that rests is held where it rests on the mean; before and after, the
    correction fades in and out. Points that would sink into the ground are lifted onto it. The
    legs and, less, the pelvis follow; all else keeps its joint angles.

    Args:
        stance: Frames of stance (right, left); found from the motion if absent.
        rate: Frames per second [Hz].
        rests: Rests of the regions of the soles; found from the motion if absent.
        way: Path of the ground itself (a treadmill's belt) [m].
        spread: Standard deviation of the change of each joint angle, named without its side [rad];
            with it the pelvis keeps its height and soles may be some millimetres off.
    """
    n = len(qpos)
    if n < 2:
        return qpos.copy()
    path = np.zeros((n, 3)) if way is None else way
    contact = sole_paths(human, qpos)
    if rests is None:
        rests = find_rests(contact, rate, way=path, stance=stance)
    solver, held = _planting_solver(human, contact, spread)
    fade = max(2, round(FADE_TIME * rate))
    desired, weight = _wanted(contact, rests, path, fade)
    # The pelvis and knees follow the feet's common lift, so that legs keep their angles.
    lift = ((desired - contact.position)[..., 2] * weight).sum(axis=1) / weight.sum(axis=1)
    if spread is not None:
        lift = np.zeros(n)
    result = qpos
    for attempt in range(MAX_PASSES):
        values = np.array([solver.values(q)[-len(held) :] for q in qpos])
        values[..., 2] += lift[:, None]
        goal = desired.copy()
        goal[..., 2] += contact.radius
        result = follow(
            solver,
            np.concatenate([goal, values], axis=1),
            result if attempt else qpos,
            weights=np.concatenate([_FOOT_WEIGHT * weight, np.tile(held, (n, 1))], axis=1),
            rest=qpos[:, 7:],
        )
        # Points that still sink get a target as far above the ground.
        depth = np.maximum(0.0, -sole_paths(human, result).position[..., 2])
        sunk = depth > MAX_DEPTH
        if not sunk.any():
            break
        desired[..., 2] += np.where(depth > 0.5 * MAX_DEPTH, np.minimum(depth, 0.02), 0.0)
        weight = np.where(sunk, np.minimum(4.0 * weight, 16.0), weight)
    return result


def lead_pelvis(
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    shift: Float[Array, "n_frames 2"],
    spread: Mapping[str, float],
) -> Float[Array, "n_frames nq"]:
    """Return the motion with the pelvis shifted over feet that keep their positions.

    Args:
        shift: Shift of the pelvis forward and to the left [m].
        spread: Standard deviation of the change of each joint angle, named without its side [rad].
    """
    contact = sole_paths(human, qpos)
    solver, held = _planting_solver(human, contact, spread)
    goal = np.array([solver.values(q) for q in qpos])
    goal[:, len(contact.sites) :, :2] += shift[:, None]
    weights = np.concatenate([np.full(len(contact.sites), _FOOT_WEIGHT), held])
    return follow(solver, goal, qpos, weights=np.tile(weights, (len(qpos), 1)), rest=qpos[:, 7:])


def _planting_solver(human: Human, contact: SolePaths, spread: Mapping[str, float] | None):
    """Return inverse kinematics on soles, pelvis and knees, and the weights of the last two."""
    points = [(site.body, np.array(site.position)) for site in contact.sites]
    points += [("pelvis", offset) for offset in (np.zeros(3), *(0.25 * np.eye(3)))]
    points += [human.skeleton.parts[f"tibia_{side}"] for side in SIDES]
    held = [_BODY_WEIGHTS["pelvis"]] * 4 + [_BODY_WEIGHTS["knee"]] * 2
    terms = Terms(human, points, [(i, -1) for i in range(len(points))])
    solver = InverseKinematics(terms, tolerance=1e-4, max_iterations=12)
    inner = [c.startswith(("mtp", "cuboid", "heel")) for c in human.coordinates]
    solver.posture = np.where(inner, _FOOT_POSTURE_WEIGHT, _POSTURE_WEIGHT)
    if spread is not None:
        held = [_PELVIS_WEIGHT] * 4 + [0.0] * 2
        usual = float(np.deg2rad(5.0))
        plain = [split_side(c)[0] for c in human.coordinates]
        wide = np.array([spread.get(name, usual) for name in plain])
        solver.posture = (_SOLE_ERROR / wide) ** 2
    return solver, np.array(held)


def _wanted(contact: SolePaths, rests: list[ContactFrames], way: np.ndarray, fade: int):
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
        if len(centre) > 8 * fade and np.linalg.norm(centre - spot, axis=1).max() > MAX_DRIFT:
            spot = _slow(centre, fade)
        shift[frames, index, :2] = (spot - centre)[:, None]
        shift[frames, index, 2] = -path[..., 2]
    offset = np.zeros((n, m, 3))
    for all_points in (contact.of(side) for side in SIDES):
        resting = np.isfinite(shift[:, all_points, 0])
        # Share that a free point of a foot takes over from its resting regions.
        common = np.zeros((n, 3))
        some = np.asarray(resting.any(axis=1))
        common[some] = np.nanmean(shift[some][:, all_points], axis=1)
        common = bridged_gaps(common, some) * _nearness(some, fade)[:, None]
        for i in all_points:
            own = np.isfinite(shift[:, i, 0])
            near = _nearness(own, fade)[:, None]
            filled = bridged_gaps(shift[:, i], own) - common
            offset[:, i] = common + near * filled
    desired = position + offset
    resting = np.isfinite(shift[..., 0]).T
    weight = 0.3 + 0.7 * np.stack([_nearness(own, fade) for own in resting], axis=1)
    sunk = desired[..., 2] < 0
    desired[..., 2] = np.where(sunk, 0.0, desired[..., 2])
    weight[sunk] = np.maximum(weight[sunk], 1.0)
    return desired + way[:, None], weight


def _slow(path: np.ndarray, fade: int) -> np.ndarray:
    """Return the path without what is faster than some ``fade`` frames."""
    k = np.arange(-4 * fade, 4 * fade + 1)
    window = np.exp(-0.5 * (k / (1.5 * fade)) ** 2)
    padded = np.pad(path, ((4 * fade, 4 * fade), (0, 0)), mode="edge")
    return np.stack([np.convolve(x, window / window.sum(), "valid") for x in padded.T], axis=1)


def _cores(rests: list[ContactFrames]) -> list[tuple[ContactFrames, np.ndarray]]:
    """Return each rest with the frames that determine its position.

    Regions of a foot that rest at the same time are parts of one contact: their positions are taken
    from the same frames, those in which most of them rest, so that they fit together.
    """
    result = []
    for side in SIDES:
        mine = sorted((r for r in rests if r.side == side), key=lambda r: r.start)
        groups: list[list[ContactFrames]] = []
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
    gap = np.asarray(distance_transform_cdt(~inside))
    return cubic_rise(1 - gap / fade)

"""Height and motion of the ground under a motion, from the feet in stance."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.sole_paths import lowest, sole_paths
from plantigrade.kinematics.sole_rests import MIN_REST_TIME, STILL_SPEED, point_speed
from plantigrade.models import Human
from plantigrade.motion import Recording
from plantigrade.motion.filters import runs
from plantigrade.motion.ground_velocity import ground_velocity
from plantigrade.motion.recording import even_clock

MAX_FLOOR_SLOPE = 0.035  # [1] maximum slope attributed to a tilted laboratory
MIN_LEVEL_DIFFERENCE = 0.04  # [m] minimum difference of separate ground levels


def ground_height(recording: Recording) -> float:
    """Return the height of the ground of a recording [m]: that of its plates, or the lab's origin.

    Plates whose corners do not lie in one level are ignored.
    """
    corners = [plate.corners[:, 2] for plate in recording.plates if plate.corners is not None]
    if not corners or not np.isfinite(corners).all() or np.ptp(corners) > MIN_LEVEL_DIFFERENCE:
        return 0.0
    return float(np.mean(corners))


def moving_ground(
    time: Float[Array, " n_frames"],
    heel: Float[Array, "n_frames 2 3"],
    toe: Float[Array, "n_frames 2 3"],
) -> Float[Array, "n_frames 3"]:
    """Return the path of the ground under the feet [m]: zero overground, the belt's on a treadmill.

    Args:
        time: Time of each frame [s].
        heel: Heels (or ankles) of both feet [m].
        toe: Toes (or toe bases) of both feet [m].
    """
    velocity = ground_velocity(time, heel, toe)
    velocity[:, 2] = 0.0
    time = even_clock(time)
    return np.cumsum(velocity * np.diff(time, prepend=time[0])[:, None], axis=0)


def ground_under(
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    rate: float,
    *,
    way: Float[Array, "n_frames 3"] | None = None,
) -> Float[Array, " n_frames"] | None:
    """Return the height of the ground under the body in every frame [m]; None if no foot rests.

    The heights at which the feet come to rest determine the level of the ground; of several levels
    (a stair, a box, a foot held still in the air) the lowest with a tenth of the time counts. Where
    feet rest at more than two places, a slope of at most :data:`MAX_FLOOR_SLOPE` is taken too: the
    floor of a capture volume is rarely level to a degree.
    """
    places = _resting_places(human, qpos, rate, way)
    if places is None:
        return None
    level, weight, spots = places
    low = _quantile(level, weight, 0.1)
    near = np.abs(level - low) <= MIN_LEVEL_DIFFERENCE
    plane = np.array([_quantile(level[near], weight[near], 0.5), 0.0, 0.0])
    centre = spots[near].mean(axis=0)
    for _ in range(5):
        slope = np.hypot(*plane[1:])
        if np.ptp(spots, axis=0).max() < 1.0 or slope > MAX_FLOOR_SLOPE:
            break
        here = plane[0] + (spots - centre) @ plane[1:]
        near = np.abs(level - here) <= MIN_LEVEL_DIFFERENCE
        if near.sum() < 3:
            break
        # Slopes across the path rest on little: they are held near zero.
        w = np.sqrt(weight[near] / weight[near].sum())
        A = np.column_stack([np.ones(near.sum()), spots[near] - centre])
        spread = np.array([1e-4, 0.15, 0.15])  # [m]: spots closer than this determine no slope
        system = np.vstack([A * w[:, None], np.diag(spread)])
        right = np.concatenate([level[near] * w, [1e-4 * plane[0], 0.0, 0.0]])
        plane = np.linalg.lstsq(system, right, rcond=None)[0]
    if np.hypot(*plane[1:]) > MAX_FLOOR_SLOPE:
        plane = np.array([_quantile(level[near], weight[near], 0.5), 0.0, 0.0])
    here = qpos[:, :2] - (0.0 if way is None else way[:, :2])
    low, high = spots.min(axis=0), spots.max(axis=0)
    return plane[0] + (np.clip(here, low, high) - centre) @ plane[1:]


def _resting_places(human, qpos, rate, way):
    """Return height, duration and spot on the ground of every rest of the feet, None if none."""
    contact = sole_paths(human, qpos)
    position = contact.position - (0.0 if way is None else way[:, None])
    time = np.arange(len(qpos)) / rate
    levels, weights, spots = [], [], []
    for side in SIDES:
        index = contact.of(side)
        height = position[:, index, 2]
        which = height.argmin(axis=1)
        every = np.arange(len(qpos))
        speed = np.stack([point_speed(time, position[:, i]) for i in index], axis=1)
        still = speed[every, which] < STILL_SPEED
        for run in runs(still):
            if run.stop - run.start >= max(2, MIN_REST_TIME * rate):
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
        rate: Frames per second [Hz].
        way: Path of the ground itself (a treadmill's belt) [m].
    """
    ground = ground_under(human, qpos, rate, way=way)
    if ground is None:
        ground = np.full(len(qpos), lowest(human, qpos).min())
    result = qpos.copy()
    result[:, 2] -= ground
    return result, -ground

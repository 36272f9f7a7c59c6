"""Assignment of plate loadings to feet."""

import numpy as np

from plantigrade.constants import GRAVITY, SIDES
from plantigrade.dynamics.plate_loadings import PlateLoading
from plantigrade.motion.filters import derivative, lowpass, runs
from plantigrade.motion.ground_velocity import ground_velocity
from plantigrade.motion.recording import rate_of

MAX_SOLE_DISTANCE = 0.03  # [m] maximum distance of the centre of pressure from a single foot's sole
MIN_PEAK_SHARE = 0.1  # [1] minimum load relative to the peak for a reliable centre of pressure
CHANGE_DISTANCE = 0.10  # [m] distance to both soles (below, above) that marks a change of feet
MAX_FOOT_DISTANCE = 0.30  # [m] maximum distance of the centre of pressure from a foot
MAX_CONTACT_HEIGHT = 0.03  # [m] maximum height above the ground of a sole point in contact
MAX_CONTACT_SPEED = 0.35  # [m/s] maximum speed relative to the ground of a sole point in contact
MIN_ALONE_TIME = 0.06  # [s] minimum time for which a foot loads the plate of the other one alone
MAX_UNLOADED_REST = 0.10  # [s] maximum rest of a foot before and after its plate is loaded
UNMEASURED_MARGIN = 0.05  # [s] possible load of an unmeasured foot before and after its rest
MIN_CARRIED = 0.25
"""Least vertical force that a motion requires for its person to be carried [body weights]. Chosen:
in flight the motion of a measured drop jump requires up to .3, for less than the following time."""
MIN_CARRIED_TIME = 0.06  # [s] minimum duration of it


def resting_points(time, points: list[np.ndarray], level: float) -> list[np.ndarray]:
    """Return which sole points are at rest on the ground, per side (n_frames, n_points)."""
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
        # The rest level compensates for the model's error of the foot, within a limit, so that a
        # foot in the air is not at rest.
        still = speed.min(axis=1) < MAX_CONTACT_SPEED / 2
        lowest = z.min(axis=1)
        floor = float(np.median(lowest[still])) if still.any() else float(lowest.min())
        if np.isfinite(level):
            floor = float(np.clip(floor, level - 0.05, level + 0.05))
        resting.append((z < floor + MAX_CONTACT_HEIGHT) & (speed < MAX_CONTACT_SPEED))
    return resting


def longer(time, flags, shortest) -> np.ndarray:
    """Return the flags without runs shorter than ``shortest`` seconds."""
    result = flags.copy()
    for run in runs(flags):
        if time[run.stop - 1] - time[run.start] < shortest:
            result[run] = False
    return result


def distance(sole: np.ndarray, cop: np.ndarray) -> np.ndarray:
    """Return the horizontal distance of each point from a sole, (n_frames,) [m].

    A sole is represented by all lines between its points, which is dense enough for a foot.
    """
    p, c = sole[..., :2], cop[:, None, :2]
    i, j = np.triu_indices(p.shape[1], 1)
    if len(i) == 0:
        return np.linalg.norm(p[:, 0] - c[:, 0], axis=-1)
    a, edge = p[:, i], p[:, j] - p[:, i]
    square = np.maximum((edge**2).sum(axis=-1), 1e-12)
    along = np.clip(((c - a) * edge).sum(axis=-1) / square, 0.0, 1.0)
    return np.linalg.norm(c - a - along[..., None] * edge, axis=-1).min(axis=1)


def find_owner(
    time: np.ndarray, loading: PlateLoading, points: list[np.ndarray], touch: np.ndarray
) -> None:
    """Assign the foot at the centre of pressure, frame by frame if it changes."""
    frames = loading.frames
    if loading.plate.side in SIDES:
        loading.owner[:] = SIDES.index(loading.plate.side)
        return
    far = np.stack([distance(p[frames], loading.cop) for p in points], axis=1)
    load = loading.force[:, 2]
    typical = np.array([_weighted_median(far[:, k], load) for k in (0, 1)])
    best = int(np.argmin(typical))
    other = 1 - best
    loading.owner[:] = best
    # one foot after the other without an unloaded interval, as on a belt or a long plate
    changes = (
        (far[:, other] < CHANGE_DISTANCE) & (far[:, best] > CHANGE_DISTANCE) & touch[frames, other]
    )
    if load[changes].sum() > 0.1 * load.sum():
        nearer = np.where(far[:, best] <= far[:, other], best, other)
        stands = touch[frames]
        nearer = np.where(stands[:, best] & ~stands[:, other], best, nearer)
        nearer = np.where(stands[:, other] & ~stands[:, best], other, nearer)
        apart = far[np.arange(len(frames)), nearer]
        between = (apart > MAX_SOLE_DISTANCE) & (load > MIN_PEAK_SHARE * loading.peak)
        loading.owner[:] = np.where(between, -1, nearer)
        if between.any():
            loading.problem = "both feet were on it"
    elif not typical[best] < MAX_FOOT_DISTANCE:
        loading.owner[:] = -1
        loading.problem = "no foot was at the centre of pressure"
    else:
        _give_to_other(time, loading, best, far, touch)


def _give_to_other(
    time: np.ndarray, loading: PlateLoading, best: int, far: np.ndarray, touch: np.ndarray
) -> None:
    """Give to the other foot what it carries alone on the plate of a foot that left.

    It stands across the gap between two plates, as on a treadmill with two belts. While both feet
    stood, each carried an unknown part, and these frames belong to none.
    """
    other, stands = 1 - best, touch[loading.frames]
    alone = stands[:, other] & ~stands[:, best]
    alone &= (far[:, other] < MAX_SOLE_DISTANCE) & (far[:, best] > MAX_SOLE_DISTANCE)
    alone = longer(time[loading.frames], alone, MIN_ALONE_TIME)
    if not alone.any():
        return
    for run in runs(stands[:, other]):
        if alone[run].any():
            loading.owner[run] = -1
            loading.problem = "both feet were on it"
    loading.owner[alone] = other


def _weighted_median(values, weights) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, 0.5 * total[-1])])


def unmeasured_frames(time, touch: np.ndarray, measured: np.ndarray) -> np.ndarray:
    """Return frames in which a foot rests on the ground without a measured force.

    For a foot on a plate, rest before and after the loading counts only beyond
    :data:`MAX_UNLOADED_REST`. For a foot on no plate, :data:`UNMEASURED_MARGIN` is added, except
    within a loading.
    """
    missing = np.zeros_like(touch)
    for k in (0, 1):
        for run in runs(touch[:, k]):
            frames = np.arange(run.start, run.stop)
            on = measured[frames, k]
            if not on.any():
                missing[:, k] |= (time >= time[run.start] - UNMEASURED_MARGIN) & (
                    time <= time[run.stop - 1] + UNMEASURED_MARGIN
                )
                continue
            for gap in runs(~on):
                a, b = frames[gap.start], frames[gap.stop - 1]
                if time[b] - time[a] > MAX_UNLOADED_REST:
                    missing[a : b + 1, k] = True
    return missing & ~measured


def carried_elsewhere(
    time: np.ndarray, touch: np.ndarray, measured: np.ndarray, lift: np.ndarray | None
) -> np.ndarray:
    """Return frames in which a box carries a person whose feet are above the plates, (n_frames,).

    The plates measure nothing, no foot is on their level, and yet the person does not fall.

    Args:
        touch: Frames in which each foot touches the ground, (n_frames, 2).
        measured: Frames in which a plate measured a force on each foot, (n_frames, 2).
        lift: Vertical acceleration of the centre of mass and gravity [m/s²].
    """
    if lift is None:
        return np.zeros(len(time), dtype=bool)
    above = ~touch.any(axis=1) & ~measured.any(axis=1)
    return longer(time, above & (lift > MIN_CARRIED * GRAVITY), MIN_CARRIED_TIME)

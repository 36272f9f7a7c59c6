"""Which foot a loading of a force plate belongs to."""

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.dynamics.plate_loadings import PlateLoading
from plantigrade.motion.filters import derivative, lowpass, runs
from plantigrade.motion.ground_velocity import ground_velocity
from plantigrade.motion.recording import rate_of

OUTSIDE = 0.03  # a centre of pressure further outside the sole is not that of the foot alone [m]
HEAVY = 0.1  # a centre of pressure counts where a plate carries this fraction of the greatest load
CHANGE = 0.10  # this near one sole and this far from the other, a load changed feet [m]
NOBODY = 0.30  # a centre of pressure further from both feet is that of something else [m]
LOW = 0.03  # height above the ground below which a point of the sole may touch it [m]
SLOW = 0.35  # speed relative to the ground below which it does [m/s]
EDGE = 0.10  # a foot that rests this much longer than its plate is loaded is partly beside it [s]
MARGIN = 0.05  # a foot beside the plates may carry this long before and after it looks at rest [s]


def resting_points(time, points: list[np.ndarray], level: float) -> list[np.ndarray]:
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


def longer(time, flags, shortest) -> np.ndarray:
    """Return the flags without runs shorter than ``shortest`` seconds."""
    result = flags.copy()
    for run in runs(flags):
        if time[run.stop - 1] - time[run.start] < shortest:
            result[run] = False
    return result


def distance(sole: np.ndarray, cop: np.ndarray) -> np.ndarray:
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


def find_owner(loading: PlateLoading, points: list[np.ndarray], touch: np.ndarray) -> None:
    """Find whose foot is at the centre of pressure, frame by frame where it changes."""
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
    # One foot after the other without the plate coming free in between: a belt, a long plate.
    changes = (far[:, other] < CHANGE) & (far[:, best] > CHANGE) & touch[frames, other]
    if load[changes].sum() > 0.1 * load.sum():
        nearer = np.where(far[:, best] <= far[:, other], best, other)
        stands = touch[frames]
        nearer = np.where(stands[:, best] & ~stands[:, other], best, nearer)
        nearer = np.where(stands[:, other] & ~stands[:, best], other, nearer)
        apart = far[np.arange(len(frames)), nearer]
        between = (apart > OUTSIDE) & (load > HEAVY * loading.peak)
        loading.owner[:] = np.where(between, -1, nearer)
        if between.any():
            loading.problem = "both feet were on it"
    elif not typical[best] < NOBODY:
        loading.owner[:] = -1
        loading.problem = "no foot was at the centre of pressure"


def _weighted_median(values, weights) -> float:
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, 0.5 * total[-1])])


def unmeasured_frames(time, touch: np.ndarray, measured: np.ndarray) -> np.ndarray:
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

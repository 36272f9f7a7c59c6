"""Which foot a loading of a force plate belongs to, and in which frames this is unknown."""

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.dynamics.plate_loadings import Loading
from plantigrade.motion.filters import derivative, lowpass, runs
from plantigrade.motion.ground_velocity import ground_velocity
from plantigrade.motion.recording import rate_of

NEAR = 0.20  # furthest a centre of pressure may be from the sole it is given to [m]
SHARED = 0.06  # centre of pressure this far off a foot whose fellow also stands: both carry [m]
LOW = 0.03  # height above the ground below which a point of the sole may touch it [m]
SLOW = 0.35  # speed relative to the ground below which it does [m/s]
BESIDE = 0.02  # how far a point of the sole must rest outside a plate to count as beside it [m]
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


def find_owner(loading: Loading, points: list[np.ndarray], touch: np.ndarray) -> None:
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


def exclude_shared(loading, loadings, points, resting, touch, excluded) -> None:
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
            inside = outside_of(loading.plate.corners, points[1 - k][frames]) < -0.01
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


def exclude_partial(loading, plates, points, resting, excluded) -> None:
    """Mark a loading during which its foot rests partly beside every plate."""
    if loading.plate.corners is None or loading.plate.side in SIDES:
        return
    for k in (0, 1):
        frames = loading.frames[loading.owner == k]
        if len(frames) == 0:
            continue
        outside = [
            outside_of(p.corners, points[k][frames]) for p in plates if p.corners is not None
        ]
        beside = np.min(outside, axis=0) > BESIDE
        partly = (beside & resting[k][frames]).any(axis=1)
        if partly.mean() > 0.1:
            excluded[frames, k] = True
            loading.problem = loading.problem or "the foot was partly beside it"


def outside_of(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
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

r"""What is wrong with a loading of a force plate: frames whose force is not that of one foot.

A contact is held against three things that are known without the plate: where the feet are, what
the plate covers, and how much force the motion of the whole body needs, :math:`m\,(g + \ddot z)`.
"""

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.dynamics.plate_loadings import PlateLoading
from plantigrade.dynamics.plate_owner import HEAVY, OUTSIDE, distance, longer

MOST_OUTSIDE = 0.1  # part of a contact's impulse that may lie there: the first and last instants
SHORTEST_JUDGED = 0.06  # a foot that has just landed is not judged [s]
LANDING = 0.1  # a foot may carry this long before and after it looks at rest [s]
BESIDE = 0.02  # how far a point of the sole must rest outside a plate to count as beside it [m]
LIGHT = 0.85  # a foot that stands alone on its plate carries at least this fraction of the weight
WHOLE = 0.9  # two feet on one plate carry at least this fraction of it throughout
SHORTEST_ALONE = 0.1  # shortest single support that is weighed [s]
SHORTEST_SHARED = 0.06  # feet that land and leave at the same time are not both carrying [s]


def needed_force(
    time: np.ndarray,
    loadings: list[PlateLoading],
    touch: np.ndarray,
    lift: np.ndarray | None,
    mass: float | None,
) -> np.ndarray:
    """Return the vertical force that the motion of the body needs, (n_frames,) [N]; NaN if unknown.

    The mass is the largest that a foot standing alone carries on any plate: less arrives where a
    plate carries a part only. With a single such contact it is the given one.

    Args:
        time: Time of each frame [s].
        loadings: Contacts with their owners.
        touch: Frames in which each foot touches the ground, (n_frames, 2).
        lift: Vertical acceleration of the centre of mass and gravity [m/s²].
        mass: Body mass, where it is known [kg].
    """
    if lift is None:
        return np.full(len(time), np.nan)
    carried = [carried_alone(time, loading, k, touch, lift) for loading in loadings for k in (0, 1)]
    seen = [each for each in carried if np.isfinite(each)]
    largest = max(seen) if len(seen) > 1 else mass
    return lift * (np.nan if largest is None else largest)


def carried_alone(time, loading, k, touch, lift) -> float:
    """Return the mass that foot ``k`` carries on a plate while the other is in the air [kg]."""
    frames = loading.frames
    alone = (loading.owner == k) & ~touch[frames, 1 - k] & touch[frames, k] & (lift[frames] > 1.0)
    if alone.sum() * np.median(np.diff(time)) < SHORTEST_ALONE:
        return float("nan")
    return float(loading.force[alone, 2].sum() / lift[frames[alone]].sum())


def exclude_light(time, loading, touch, lift, need, excluded) -> None:
    """Mark a contact that carries too little while the other foot is in the air."""
    if lift is None:
        return
    mass = float(np.nanmedian(need / lift)) if np.isfinite(need).any() else float("nan")
    for k in (0, 1):
        share = carried_alone(time, loading, k, touch, lift) / mass
        if share < LIGHT:
            excluded[loading.frames[loading.owner == k], k] = True
            loading.problem = loading.problem or (
                f"it carries {100 * share:.0f} % of the weight while the other foot is in the air "
                "(the foot partly beside it, or something else carries the person)"
            )


def leave_out_far(time, loading, loadings, points, touch, excluded) -> None:
    """Leave out a contact whose centre of pressure lies outside the sole.

    Frames in which it lies between both feet while the other one lands, stands or leaves are no
    reason: they are those of two feet on the plate.
    """
    for k in (0, 1):
        mine = loading.owner == k
        load = loading.force[:, 2]
        heavy = mine & _heavy(loading, loadings) & ~excluded[loading.frames, k]
        if heavy.sum() * np.median(np.diff(time)) < SHORTEST_JUDGED:
            continue
        far = distance(points[k][loading.frames], loading.cop)
        out = heavy & (far > OUTSIDE)
        soles = np.concatenate([p[loading.frames] for p in points], axis=1)
        step = int(round(LANDING / np.median(np.diff(time))))
        other = np.convolve(touch[:, 1 - k], np.ones(2 * step + 1), "same") > 0.5
        both = out & (distance(soles, loading.cop) < OUTSIDE) & other[loading.frames]
        if loading.plate.side not in SIDES and both.sum() >= 3:
            excluded[loading.frames[both]] = True
            loading.problem = loading.problem or "both feet were on it"
            out, heavy = out & ~both, heavy & ~both
        if load[out].sum() <= MOST_OUTSIDE * load[heavy].sum():
            continue
        excluded[loading.frames[mine], k] = True
        loading.left_out = True
        foot = {"r": "right", "l": "left"}[SIDES[k]]
        loading.problem = (
            f"its centre of pressure lies up to {100 * far[out].max():.0f} cm outside the sole of "
            f"the {foot} foot"
        )


def exclude_shared(time, loading, loadings, points, resting, touch, need, excluded) -> None:
    """Mark frames in which the other foot also stands on this plate.

    ``need`` is the vertical force that the motion of the body needs [N]; NaN where it is unknown.
    """
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
            shared |= mine & on & ~(elsewhere & (distance(points[k][frames], loading.cop) < 0.02))
        else:
            far = distance(points[k][frames], loading.cop)
            off = (far > OUTSIDE) & _heavy(loading, loadings)
            # The foot behind hands its load over within a double support, unless to the same plate.
            whole = mine & ~elsewhere & (loading.force[:, 2] > WHOLE * need[frames])
            whole = longer(time[frames], whole, SHORTEST_SHARED)
            shared |= mine & ~elsewhere & (off | whole)
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


def _heavy(loading, loadings) -> np.ndarray:
    """Return the frames in which a plate carries enough for its centre of pressure to be known."""
    return loading.force[:, 2] > HEAVY * max(each.peak for each in loadings)


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

r"""Checks of plate loadings for frames whose force is not that of one foot.

A contact is compared with the positions of the feet, the area of the plate, and the force that the
motion of the whole body requires, :math:`m\,(g + \ddot z)`.
"""

import numpy as np

from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.dynamics.plate_loadings import PlateLoading
from plantigrade.dynamics.plate_owner import MAX_SOLE_DISTANCE, MIN_PEAK_SHARE, distance, longer
from plantigrade.motion.plate_events import outside_of

MAX_OUTSIDE_IMPULSE = 0.1  # [1] share of a contact's impulse outside the sole at start and end
MIN_CHECKED_TIME = 0.06  # [s] minimum duration of contact for a check
LANDING_MARGIN = 0.1  # [s] possible load before and after the foot appears at rest
MIN_OVERHANG = 0.02  # [m] distance of a sole point outside a plate that counts as off it
MIN_SINGLE_LOAD = 0.85  # [1] minimum load of a foot standing alone on its plate, of the weight
MIN_SHARED_LOAD = 0.9  # [1] minimum load of two feet on one plate, of the weight
MIN_SINGLE_TIME = 0.1  # [s] minimum duration of a single support for the load check
MIN_SHARED_TIME = 0.06  # [s] minimum duration of two feet on one plate


def needed_force(
    time: np.ndarray,
    loadings: list[PlateLoading],
    touch: np.ndarray,
    lift: np.ndarray | None,
    mass: float | None,
) -> np.ndarray:
    """Return the vertical force that the motion requires, (n_frames,) [N]; NaN if unknown.

    The mass is the largest load of a foot standing alone on any plate, because partial contacts
    have less. With a single such contact the given mass is used.

    Args:
        time: Time of each frame [s].
        loadings: Contacts with their owners.
        touch: Frames in which each foot touches the ground, (n_frames, 2).
        lift: Vertical acceleration of the centre of mass and gravity [m/s²].
        mass: Body mass, if known [kg].
    """
    if lift is None:
        return np.full(len(time), np.nan)
    masses = [
        carried_alone(time, loading, loadings, k, touch, lift)
        for loading in loadings
        for k in (0, 1)
    ]
    seen = [each for each in masses if np.isfinite(each)]
    largest = max(seen) if len(seen) > 1 else mass
    return lift * (np.nan if largest is None else largest)


def carried_alone(time, loading, loadings, k, touch, lift) -> float:
    """Return the mass that foot ``k`` carries on one plate while the other is in the air [kg]."""
    frames = loading.frames
    alone = (loading.owner == k) & ~touch[frames, 1 - k] & touch[frames, k] & (lift[frames] > 1.0)
    alone &= ~_elsewhere(loading, loadings, k)
    if alone.sum() * np.median(np.diff(time)) < MIN_SINGLE_TIME:
        return float("nan")
    return float(loading.force[alone, 2].sum() / lift[frames[alone]].sum())


def exclude_light(time, loading, loadings, touch, lift, need, excluded) -> None:
    """Exclude a contact with too little load in single support."""
    if lift is None:
        return
    mass = float(np.nanmedian(need / lift)) if np.isfinite(need).any() else float("nan")
    for k in (0, 1):
        share = carried_alone(time, loading, loadings, k, touch, lift) / mass
        if share < MIN_SINGLE_LOAD:
            excluded[loading.frames[loading.owner == k], k] = True
            loading.problem = loading.problem or (
                f"it carries {100 * share:.0f} % of the weight while the other foot is in the air "
                "(the foot partly off it, or something else carries the person)"
            )


def leave_out_far(time, loading, loadings, points, touch, excluded) -> None:
    """Exclude a contact with its centre of pressure outside the sole.

    Frames with the centre of pressure between both feet while the other one lands, stands or leaves
    are attributed to two feet on the plate.
    """
    for k in (0, 1):
        mine = loading.owner == k
        load = loading.force[:, 2]
        heavy = mine & _heavy(loading, loadings) & ~excluded[loading.frames, k]
        if heavy.sum() * np.median(np.diff(time)) < MIN_CHECKED_TIME:
            continue
        far = distance(points[k][loading.frames], loading.cop)
        out = heavy & (far > MAX_SOLE_DISTANCE)
        soles = np.concatenate([p[loading.frames] for p in points], axis=1)
        step = int(round(LANDING_MARGIN / np.median(np.diff(time))))
        other = np.convolve(touch[:, 1 - k], np.ones(2 * step + 1), "same") > 0.5
        both = out & (distance(soles, loading.cop) < MAX_SOLE_DISTANCE) & other[loading.frames]
        if loading.plate.side not in SIDES and both.sum() >= 3:
            excluded[loading.frames[both]] = True
            loading.problem = loading.problem or "both feet were on it"
            out, heavy = out & ~both, heavy & ~both
        if load[out].sum() <= MAX_OUTSIDE_IMPULSE * load[heavy].sum():
            continue
        excluded[loading.frames[mine], k] = True
        loading.left_out = True
        foot = SIDE_NAMES[SIDES[k]]
        loading.problem = (
            f"its centre of pressure lies up to {100 * far[out].max():.0f} cm outside the sole of "
            f"the {foot} foot"
        )


def exclude_shared(time, loading, loadings, points, resting, touch, need, excluded) -> None:
    """Exclude frames in which the other foot also stands on this plate.

    ``need`` is the vertical force that the motion requires [N]; NaN if unknown.
    """
    without_foot = loading.owner < 0
    excluded[loading.frames[without_foot]] = True
    if loading.plate.side in SIDES:
        return
    shared = np.zeros(len(loading.frames), dtype=bool)
    for k in (0, 1):
        frames = loading.frames
        elsewhere = _elsewhere(loading, loadings, 1 - k)
        mine = (loading.owner == k) & touch[frames, 1 - k]
        if loading.plate.corners is not None:
            inside = outside_of(loading.plate.corners, points[1 - k][frames]) < -0.01
            on = (inside & resting[1 - k][frames]).any(axis=1)
            # a foot at the edge with load on a second plate is no third case
            shared |= mine & on & ~(elsewhere & (distance(points[k][frames], loading.cop) < 0.02))
        else:
            far = distance(points[k][frames], loading.cop)
            off = (far > MAX_SOLE_DISTANCE) & _heavy(loading, loadings)
            # the trailing foot transfers its load within a double support, unless to the same plate
            whole = mine & ~elsewhere & (loading.force[:, 2] > MIN_SHARED_LOAD * need[frames])
            whole = longer(time[frames], whole, MIN_SHARED_TIME)
            shared |= mine & ~elsewhere & (off | whole)
    # Instants around heel strike and toe-off, low and slow but unloaded, are harmless; a real
    # double support lasts longer.
    if shared.sum() >= 3:
        excluded[loading.frames[shared]] = True
        loading.problem = loading.problem or "both feet were on it"


def exclude_partial(loading, plates, points, resting, excluded) -> None:
    """Exclude a loading with its foot partly outside every plate."""
    if loading.plate.corners is None or loading.plate.side in SIDES:
        return
    for k in (0, 1):
        frames = loading.frames[loading.owner == k]
        if len(frames) == 0:
            continue
        outside = [
            outside_of(p.corners, points[k][frames]) for p in plates if p.corners is not None
        ]
        off_plate = np.min(outside, axis=0) > MIN_OVERHANG
        partly = (off_plate & resting[k][frames]).any(axis=1)
        if partly.mean() > 0.1:
            excluded[frames, k] = True
            loading.problem = loading.problem or "the foot was partly off it"


def _elsewhere(loading, loadings, k) -> np.ndarray:
    """Return the frames of a contact in which foot ``k`` loads another plate."""
    others = [o.frames[o.owner == k] for o in loadings if o.plate is not loading.plate]
    return np.isin(loading.frames, np.concatenate([*others, np.empty(0, dtype=int)]))


def _heavy(loading, loadings) -> np.ndarray:
    """Return the frames with enough load for a reliable centre of pressure."""
    return loading.force[:, 2] > MIN_PEAK_SHARE * max(each.peak for each in loadings)

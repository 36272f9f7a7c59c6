r"""Centres of pressure against the base of support.

The required wrench of the ground follows from the motion alone. Its centre of pressure, the point
where the wrench has no moment in the plane of the ground,

.. math:: p = O + \frac{n \times M_O}{n^T F},

must lie in the convex hull of the sites in stance. Below body weight its distance is scaled with
the load, because the fault is a missing moment.
"""

import numpy as np

from plantigrade.analyze.sweep import Sweep
from plantigrade.arrays import Array, Bool, Float
from plantigrade.record import Record
from plantigrade.spatial.conventions import cross, surface_axes


def centre_of_pressure(record: Record, s: Sweep, least: float) -> Float[Array, "n 3"]:
    """Return the centre of pressure that a motion requires, world [m]; NaN without load.

    Args:
        s: Its sweep.
        least: Normal force below which there is no centre of pressure [N].
    """
    normal, feet = record.ground.normal, _feet(record)
    pushed = np.einsum("nki,nki->nk", s.force, s.normal)
    load = np.where(feet, np.maximum(pushed, 0.0), 0.0)
    # Wrench required from the feet: that of the motion less that of other supports.
    other = np.where(feet[:, None], 0.0, s.force)
    force = s.root[:, :3] - other.sum(axis=1)
    moment = s.root[:, 3:] - cross(s.point - s.com[:, None], other).sum(axis=1)
    # With feet at different heights, friction acts at the height of each.
    level = s.point @ normal
    share = load + 1e-9 * feet * (1.0 + 1e6 * s.standing)
    total = share.sum(axis=1, keepdims=True)
    mean = (share * level).sum(axis=1, keepdims=True) / np.where(total > 0, total, 1.0)
    lever = np.where(feet, level - mean, 0.0)
    friction = np.where(feet[:, None], s.force - pushed[..., None] * s.normal, 0.0)
    moment = moment - (lever[..., None] * cross(normal, friction)).sum(axis=1)
    origin = s.com + (mean - s.com @ normal[:, None]) * normal
    moment = moment + cross(s.com - origin, force)
    up = force @ normal
    centre = origin + cross(normal, moment) / np.where(up > least, up, np.nan)[:, None]
    return centre


def outside_support(
    record: Record, s: Sweep, centre: Float[Array, "n 3"], least: float
) -> Float[Array, "n 3"]:
    """Return distances of centres of pressure outside the base of support, scaled with load [m].

    Columns are the required centre under both feet, and those of the forces under the right and the
    left foot. Values are negative inside, and NaN without stance.
    """
    plane = surface_axes(record.ground.normal).T[:2]
    flat = s.point @ plane.T  # (n, k, 2)
    pushed = np.einsum("nki,nki->nk", s.force, s.normal)
    up = (s.root[:, :3] - np.where(_feet(record)[:, None], 0.0, s.force).sum(axis=1)) @ (
        record.ground.normal
    )
    out = distance_outside_hull(centre @ plane.T, flat, s.standing & _feet(record))
    columns = [out * np.clip(up / s.weight, 0.0, 1.0)]
    for side in ("r", "l"):
        mine = np.array([site.side == side for site in record.sites], bool)
        own = np.where(mine, pushed, 0.0)
        up = own.sum(axis=1)
        safe = np.where(up > least, up, np.nan)[:, None]
        out = distance_outside_hull(
            (own[..., None] * flat).sum(axis=1) / safe, flat, s.standing & mine
        )
        columns.append(out * np.clip(up / s.weight, 0.0, 1.0))
    return np.stack(columns, axis=1)


def _feet(record: Record) -> Bool[Array, " k"]:
    """Return which sites belong to a foot."""
    return np.array([site.side != "" for site in record.sites], bool)


def distance_outside_hull(
    point: Float[Array, "n 2"], corners: Float[Array, "n k 2"], there: np.ndarray
) -> Float[Array, " n"]:
    r"""Return distances of points outside convex hulls; negative inside, NaN without corners.

    The distance is :math:`\max_d\; d^T p - \max_i d^T x_i` over unit directions :math:`d`; the
    maximum is at the normal of a side, or in the direction from a corner to the point.

    Args:
        point: Point of every frame [m].
        corners: Corners of the hulls [m].
        there: Whether each corner counts (n, k).
    """
    n, k = there.shape
    result = np.full(n, np.nan)
    use = there.any(axis=1) & np.isfinite(point).all(axis=1)
    if not use.any():
        return result
    patterns, kind = np.unique(there[use], axis=0, return_inverse=True)
    frames = np.flatnonzero(use)
    for i, pattern in enumerate(patterns):
        mine = frames[kind.ravel() == i]
        result[mine] = _outside(point[mine], corners[mine][:, pattern])
    return result


def _outside(p: Float[Array, "n 2"], x: Float[Array, "n k 2"]) -> Float[Array, " n"]:
    """Return the distances outside hulls of which all corners count [m]."""
    i, j = np.triu_indices(x.shape[1], 1)
    side = x[:, j] - x[:, i]
    normal = np.stack([side[..., 1], -side[..., 0]], axis=2)
    directions = np.concatenate([normal, -normal, p[:, None] - x], axis=1)
    length = np.linalg.norm(directions, axis=2, keepdims=True)
    directions = directions / np.where(length > 1e-12, length, np.inf)
    support = (directions @ x.transpose(0, 2, 1)).max(axis=2)
    distance = np.einsum("ndc,nc->nd", directions, p) - support
    distance = np.where(length[..., 0] > 1e-12, distance, -np.inf).max(axis=1)
    return np.where(np.isfinite(distance), distance, 0.0)

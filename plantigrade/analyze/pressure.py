r"""Centres of pressure against the base of support.

What the ground must supply follows from the motion alone. Its centre of pressure, the point where
that wrench has no moment in the plane of the ground,

.. math:: p = O + \frac{n \times M_O}{n^T F},

must lie in the hull of what stands. Below body weight its distance counts in proportion to the
load, as what is missing is a moment.
"""

import numpy as np

from plantigrade.analyze.sweep import Sweep, cross
from plantigrade.arrays import Array, Bool, Float
from plantigrade.record import Record


def centre_of_pressure(record: Record, s: Sweep, least: float) -> Float[Array, "n 3"]:
    """Return where the feet must push for a motion, world [m]; NaN where they need not.

    Args:
        record: The motion.
        s: Its sweep.
        least: Normal force below which there is no centre of pressure [N].
    """
    normal, feet = record.ground.normal, _feet(record)
    pushed = np.einsum("nki,nki->nk", s.force, s.normal)
    load = np.where(feet, np.maximum(pushed, 0.0), 0.0)
    # What the feet must supply: all that the motion demands, less what other supports give.
    other = np.where(feet[:, None], 0.0, s.force)
    force = s.root[:, :3] - other.sum(axis=1)
    moment = s.root[:, 3:] - cross(s.point - s.com[:, None], other).sum(axis=1)
    # Feet on different levels: friction acts at the height of each.
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
    """Return how far centres of pressure are outside the base of support, scaled with load [m].

    Columns: that of the motion under both feet, then that of the forces under the right and the
    left foot. Negative inside; NaN where nothing stands.
    """
    plane = _tangents(record.ground.normal)
    flat = s.point @ plane.T  # (n, k, 2)
    pushed = np.einsum("nki,nki->nk", s.force, s.normal)
    up = (s.root[:, :3] - np.where(_feet(record)[:, None], 0.0, s.force).sum(axis=1)) @ (
        record.ground.normal
    )
    out = outside_hull(centre @ plane.T, flat, s.standing & _feet(record))
    columns = [out * np.clip(up / s.weight, 0.0, 1.0)]
    for side in ("r", "l"):
        mine = np.array([site.side == side for site in record.sites], bool)
        own = np.where(mine, pushed, 0.0)
        up = own.sum(axis=1)
        safe = np.where(up > least, up, np.nan)[:, None]
        out = outside_hull((own[..., None] * flat).sum(axis=1) / safe, flat, s.standing & mine)
        columns.append(out * np.clip(up / s.weight, 0.0, 1.0))
    return np.stack(columns, axis=1)


def _feet(record: Record) -> Bool[Array, " k"]:
    """Return which sites belong to a foot."""
    return np.array([site.side != "" for site in record.sites], bool)


def _tangents(normal: Float[Array, " 3"]) -> Float[Array, "2 3"]:
    """Return two axes along the plane."""
    first = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.9 else np.array([0.0, 1.0, 0.0])
    first = first - (first @ normal) * normal
    first = first / np.linalg.norm(first)
    return np.stack([first, np.cross(normal, first)])


def outside_hull(
    point: Float[Array, "n 2"], corners: Float[Array, "n k 2"], there: np.ndarray
) -> Float[Array, " n"]:
    r"""Return how far points are outside of hulls; negative inside, NaN where nothing stands.

    The distance is :math:`\max_d\; d^T p - \max_i d^T x_i` over unit directions :math:`d`; the
    greatest is at the normal of a side, or points from a corner to the point.

    Args:
        point: Point of every frame [m].
        corners: Places whose hull is meant [m].
        there: Which of them count (n, k).
    """
    n, k = there.shape
    result = np.full(n, np.nan)
    use = there.any(axis=1) & np.isfinite(point).all(axis=1)
    if not use.any():
        return result
    every = np.flatnonzero(there[use].any(axis=0))
    p, x, there = point[use], corners[use][:, every], there[use][:, every]
    i, j = np.triu_indices(len(every), 1)
    side = x[:, j] - x[:, i]
    normal = np.stack([side[..., 1], -side[..., 0]], axis=2)
    directions = np.concatenate([normal, -normal, p[:, None] - x], axis=1)
    length = np.linalg.norm(directions, axis=2, keepdims=True)
    directions = directions / np.where(length > 1e-12, length, np.inf)
    support = np.einsum("ndc,nkc->ndk", directions, x)
    support = np.where(there[:, None], support, -np.inf).max(axis=2)
    distance = np.einsum("ndc,nc->nd", directions, p) - support
    distance = np.where(length[..., 0] > 1e-12, distance, -np.inf).max(axis=1)
    result[use] = np.where(np.isfinite(distance), distance, 0.0)
    return result

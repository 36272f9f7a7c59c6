"""Steps of the ground: swinging feet are led over their edges, and land on one side of them.

A plan may pass an edge by a millimetre. A person who is a centimetre off it would stumble.
"""

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.ground import Ground

CLEAR = 0.02
"""Clearance over an edge [m]."""
NEAR = 0.08
"""An edge this near along x is passed [m]."""
AWAY = 0.15
"""From where a sphere was lifted and to where it lands, clearance comes and goes [m]."""
SMOOTH = 0.06
"""The lift is spread over this time to either side [s]."""
MARGIN = 0.02
"""A sphere stands at least this far from an edge [m]."""
SEARCHED = np.array(sorted(np.arange(-20, 21) * 0.02, key=abs))
"""How far a landing place is moved along the way, the shortest first [m]."""


def lifts(
    ground: Ground, low: Float[Array, "n k 3"], stands: Bool[Array, " n"], step: float
) -> Float[Array, " n"]:
    """Return how much higher than planned a foot is to be while it swings over an edge [m].

    Args:
        ground: With its steps.
        low: Lowest points of the foot's spheres, world.
        stands: Whether the foot stands.
        step: Of the grid [s].
    """
    lift = np.zeros(len(low))
    edges = np.flatnonzero(np.diff(stands.astype(int))) + 1
    for a, b in zip([0, *edges], [*edges, len(low)], strict=True):
        if stands[a]:
            continue
        x = low[a:b] @ ground.to_world
        last, first = x[-1:, :, 0], x[:1, :, 0]
        fades = np.minimum(np.abs(x[..., 0] - first), np.abs(x[..., 0] - last)) / AWAY
        below, above = ground.along(x[..., 0]), ground.along(x[..., 0], NEAR)
        wanted = below + (above - below + CLEAR * (above > below)) * np.minimum(fades, 1.0)
        needed = np.where(above > below, wanted - x[..., 2], 0.0)
        lift[a:b] = np.maximum(needed.max(axis=1), 0.0)
    if not lift.any():
        return lift
    n = round(SMOOTH / step)
    wide = np.pad(lift, n)
    widest = np.lib.stride_tricks.sliding_window_view(wide, 2 * n + 1).max(axis=1)
    window = np.hanning(2 * n + 3)[1:-1]
    smooth = np.convolve(np.pad(widest, n, mode="edge"), window / window.sum(), mode="valid")
    return np.where(stands, 0.0, smooth)


def on_one_side(
    ground: Ground,
    low: Float[Array, "k 3"],
    offset: Float[Array, " 2"],
    ahead: Float[Array, " 2"],
) -> Float[Array, " 2"]:
    """Return an offset with which a foot lands wholly on the level it is planned to.

    Args:
        ground: With its steps.
        low: Lowest points of the foot's spheres at touchdown, as planned, world.
        offset: Wanted [m].
        ahead: Direction of the way.

    Returns:
        The nearest such offset along the way; the wanted one if none is near.
    """
    planned = ground.along(np.asarray(low.mean(axis=0) @ ground.to_world[:, 0]))
    tried = offset + SEARCHED[:, None] * ahead
    there = low[None] + np.pad(tried, ((0, 0), (0, 1)))[:, None]
    x = (there @ ground.to_world)[..., 0]
    level = np.stack([ground.along(x - MARGIN), ground.along(x + MARGIN)])
    good = (np.abs(level - planned) < 1e-9).all(axis=(0, 2))
    return tried[int(np.argmax(good))] if good.any() else offset

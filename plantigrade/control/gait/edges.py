"""Swing feet clear the edges of steps in the ground, and land on one side of them.

A plan may clear an edge by a millimetre; with an error of a centimetre a person would stumble.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import maximum_filter1d

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.ground import Ground
from plantigrade.motion.filters import runs

SEARCHED = np.array(sorted(np.arange(-20, 21) * 0.02, key=abs))  # [m] shifts tried, shortest first


@dataclass(frozen=True, kw_only=True)
class EdgeSettings:
    """How feet pass the edges of steps in the ground."""

    clearance: float = 0.02
    """Clearance of a swing foot over an edge, and least distance from it of a contact sphere at
    touchdown [m]. Chosen (±20 %: deviation 8 %, by loads of recordings)."""
    passing_distance: float = 0.08
    """Horizontal distance from which a swing foot passes an edge; over twice as much from lift-off
    and touchdown its clearance fades [m]. Chosen (±20 %: not met)."""
    smoothing_time: float = 0.05
    """Time by which the lift is spread to either side [s]. Chosen."""


def lifts(
    ground: Ground,
    low: Float[Array, "n k 3"],
    stands: Bool[Array, " n"],
    step: float,
    settings: EdgeSettings | None = None,
) -> Float[Array, " n"]:
    """Return the lift of a foot above its plan while it swings over an edge [m].

    Args:
        low: Lowest points of the foot's contact spheres, world [m].
        stands: Whether the foot is in stance.
        step: Time step of the grid [s].
    """
    settings = settings or EdgeSettings()
    lift = np.zeros(len(low))
    for swing in runs(~stands):
        x = low[swing] @ ground.to_world
        last, first = x[-1:, :, 0], x[:1, :, 0]
        fades = np.minimum(np.abs(x[..., 0] - first), np.abs(x[..., 0] - last))
        fades = np.minimum(fades / (2.0 * settings.passing_distance), 1.0)
        below, above = ground.along(x[..., 0]), ground.along(x[..., 0], settings.passing_distance)
        desired = below + (above - below + settings.clearance * (above > below)) * fades
        needed = np.where(above > below, desired - x[..., 2], 0.0)
        lift[swing] = np.maximum(needed.max(axis=1), 0.0)
    if not lift.any():
        return lift
    n = round(settings.smoothing_time / step)
    widest = maximum_filter1d(lift, 2 * n + 1, mode="constant")
    window = np.hanning(2 * n + 3)[1:-1]
    smooth = np.convolve(np.pad(widest, n, mode="edge"), window / window.sum(), mode="valid")
    return np.where(stands, 0.0, smooth)


def on_one_side(
    ground: Ground,
    low: Float[Array, "k 3"],
    offset: Float[Array, " 2"],
    ahead: Float[Array, " 2"],
    settings: EdgeSettings | None = None,
) -> Float[Array, " 2"]:
    """Return an offset with which a foot lands wholly on the level it is planned to.

    Args:
        low: Lowest points of the foot's contact spheres at touchdown, as planned, world [m].
        offset: Desired offset [m].

    Returns:
        The nearest such offset along the path; the desired one if none is near.
    """
    margin = (settings or EdgeSettings()).clearance
    planned = ground.along(np.asarray(low.mean(axis=0) @ ground.to_world[:, 0]))
    tried = offset + SEARCHED[:, None] * ahead
    there = low[None] + np.pad(tried, ((0, 0), (0, 1)))[:, None]
    x = (there @ ground.to_world)[..., 0]
    level = np.stack([ground.along(x - margin), ground.along(x + margin)])
    good = (np.abs(level - planned) < 1e-9).all(axis=(0, 2))
    return tried[int(np.argmax(good))] if good.any() else offset

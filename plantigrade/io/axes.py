"""Rotate file axes to world axes: x forward, y left, z up.

The rotation brings the file's vertical to z; it never mirrors and never changes the heading.
"""

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import ParameterError

# Rows are the new axes x, y, z expressed in the file's axes; each is a proper rotation.
_TO_WORLD = {
    "+z": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "+y": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),  # OpenSim and ISB: x forward, y up, z right
    "+x": ((0, 1, 0), (0, 0, 1), (1, 0, 0)),
    "-z": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
    "-y": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "-x": ((0, 1, 0), (0, 0, -1), (-1, 0, 0)),
}

MIN_CERTAINTY = 1.4
"""Least extent of an upright body along the vertical, over the next largest extent [1]."""
UP_AXES = tuple(_TO_WORLD)
"""Names of the vertical: ``"+z"``, ``"+y"``, ``"+x"``, ``"-z"``, ``"-y"``, ``"-x"``."""


def rotation_to_world(up: str) -> Float[Array, "3 3"]:
    """Return the rotation that maps vectors of a file whose vertical is ``up`` to world axes."""
    try:
        return np.array(_TO_WORLD[up], dtype=float)
    except KeyError:
        raise ParameterError(f"{up=} is not an axis; choose one of {', '.join(UP_AXES)}") from None


def to_world(vectors: Float[Array, "*shape 3"], up: str) -> Float[Array, "*shape 3"]:
    """Return vectors of a file whose vertical is ``up`` in world axes."""
    rotation_to_world(up)
    return _permute(vectors, _TO_WORLD[up])


def from_world(vectors: Float[Array, "*shape 3"], up: str) -> Float[Array, "*shape 3"]:
    """Return world vectors in the axes of a file whose vertical is ``up``."""
    return _permute(vectors, tuple(zip(*rotation_to_world(up).astype(int).tolist(), strict=True)))


def is_seen(positions: Float[Array, "*shape 3"]) -> Bool[Array, "*shape"]:
    """Return which points were seen: files write NaN, or exactly the origin, where one was not."""
    return np.isfinite(positions).all(axis=-1) & (positions != 0).any(axis=-1)


def up_axis_of_points(positions: Float[Array, "n_frames n_markers 3"]) -> tuple[str, float]:
    """Estimate the vertical from the markers of an upright person.

    Within one frame an upright body is taller than it is wide or than its step is long; the
    ground is near zero, so the body lies on the positive side.

    Returns:
        The axis, as in :data:`UP_AXES`, and its certainty: extent along it over the next largest
        extent (1: undecided, above :data:`MIN_CERTAINTY`: an upright body).
    """
    seen = np.all(np.isfinite(positions), axis=2)
    frames = np.flatnonzero(seen.sum(axis=1) >= 4)
    if frames.size == 0:
        return "+z", 1.0
    frames = frames[:: max(1, len(frames) // 50)]
    part = positions[frames].astype(float)
    part[~seen[frames]] = np.nan
    part = np.sort(part, axis=1)  # NaN last
    last = seen[frames].sum(axis=1) - 1
    rows = np.arange(len(frames))
    # The 5th to 95th percentile is robust against a stray marker.
    low = part[rows, np.rint(0.05 * last).astype(int)]
    high = part[rows, np.rint(0.95 * last).astype(int)]
    extent = np.median(high - low, axis=0)
    middle = np.median(part[rows, last // 2], axis=0)
    order = np.argsort(extent)
    axis, next_axis = int(order[-1]), int(order[-2])
    sure = float(extent[axis] / extent[next_axis]) if extent[next_axis] > 0 else 1.0
    return ("+" if middle[axis] >= 0 else "-") + "xyz"[axis], sure


def _permute(vectors: np.ndarray, rows: tuple) -> np.ndarray:
    """Apply a signed permutation exactly: no rounding, NaN stays in its own component."""
    vectors = np.asarray(vectors)
    out = np.empty_like(vectors, dtype=float)
    for new, row in enumerate(rows):
        old = next(i for i, value in enumerate(row) if value)
        out[..., new] = vectors[..., old] * row[old]
    return out

"""Outlines of surfaces as smooth closed curves, and their path data for an SVG.

The triangles of a part are filled on a fine grid, whose border is followed and resampled to a given
number of points. The points control a quadratic B-spline: one command of path data each. In a
motion, outlines begin at corresponding points, so that a browser can interpolate them.
"""

import numpy as np
from scipy.ndimage import gaussian_filter

from plantigrade.arrays import Array, Float, Int

FILL_STEP = 0.7
"""Distance of the points that fill a triangle, in steps of the grid: no gaps. Chosen."""
LEVEL = 0.4
"""Level of the smoothed mask on the border; below one half, which makes up for the spline's
shrinking at bends. Chosen."""
MARGIN = 3
"""Empty cells about a mask."""

# From which side of a cell to which a border goes, by the corners inside: bits 1, 2, 4, 8 for upper
# left, upper right, lower right, lower left. Sides 0 to 3 are top, right, bottom, left.
_TOP, _RIGHT, _BOTTOM, _LEFT = range(4)
_WAYS = {
    1: ((_LEFT, _TOP),), 2: ((_TOP, _RIGHT),), 3: ((_LEFT, _RIGHT),), 4: ((_RIGHT, _BOTTOM),),
    5: ((_LEFT, _TOP), (_RIGHT, _BOTTOM)), 6: ((_TOP, _BOTTOM),), 7: ((_LEFT, _BOTTOM),),
    8: ((_BOTTOM, _LEFT),), 9: ((_BOTTOM, _TOP),), 10: ((_TOP, _RIGHT), (_BOTTOM, _LEFT)),
    11: ((_BOTTOM, _RIGHT),), 12: ((_RIGHT, _LEFT),), 13: ((_RIGHT, _TOP),), 14: ((_TOP, _LEFT),),
}  # fmt: skip


def silhouette(
    points: Float[Array, "n 2"], faces: Int[Array, "n_faces 3"], count: int, grain: float
) -> Float[Array, "count 2"]:
    """Return the outline of projected triangles as control points of a closed spline.

    The longest border is taken: of several pieces the largest, and holes do not count.

    Args:
        points: Projected vertices [m].
        faces: Triangles.
        count: Number of control points.
        grain: Step of the grid [m].
    """
    mask, low = _filled(points[faces], grain)
    border = _longest(_borders(gaussian_filter(mask.astype(float), 1.0) - LEVEL))
    return _controls(_resampled(low + grain * border, count))


def aligned(outlines: Float[Array, "n count 2"]) -> Float[Array, "n count 2"]:
    """Return outlines that begin at corresponding points: nearest to the outline before."""
    found = [outlines[0]]
    for outline in outlines[1:]:
        before, here = (np.fft.fft(each @ [1.0, 1.0j]) for each in (found[-1], outline))
        shift = int(np.argmax(np.fft.ifft(here * before.conj()).real))
        found.append(np.roll(outline, -shift, axis=0))
    return np.array(found)


def spline_data(outlines: Float[Array, "n count 2"], *, per_metre: float) -> list[str]:
    """Return closed quadratic B-splines as path data with equal commands, one string per frame.

    A curve runs through the midpoints of its control points, which makes each control point the
    mirror image of the one before: path data need nothing but the midpoints (command ``T``).
    Controls are rounded to even numbers, so that midpoints are whole and errors do not add up.
    """
    controls = 2 * np.round(outlines * per_metre / 2).astype(int)
    middles = (controls + np.roll(controls, -1, axis=1)) // 2
    found = []
    for control, middle in zip(controls, middles, strict=True):
        start = middle[-1]
        steps = np.diff(middle, axis=0)
        data = f"M{_pair(start)}q{_pair(control[0] - start)} {_pair(middle[0] - start)}t"
        found.append(data + " ".join(_pair(step) for step in steps).replace(" -", "-") + "z")
    return found


def _pair(values: Int[Array, " 2"]) -> str:
    x, y = int(values[0]), int(values[1])
    return f"{x}{y}" if y < 0 else f"{x} {y}"


def _filled(corners: Float[Array, "n_faces 3 2"], grain: float) -> tuple[Array, Array]:
    """Return the mask of triangles and the place of its first cell."""
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    needed = np.maximum(1.0, sides / (FILL_STEP * grain))
    parts = (2 ** np.ceil(np.log2(needed))).astype(
        int
    )  # a few sizes: triangles are filled together
    low = corners.min(axis=(0, 1)) - MARGIN * grain
    size = np.ceil((corners.max(axis=(0, 1)) - low) / grain).astype(int) + MARGIN + 1
    mask = np.zeros(size[::-1], dtype=bool)
    for k in np.unique(parts):
        i, j = np.triu_indices(k + 1)
        shares = np.stack([i, j - i, k - j], axis=1) / k
        places = shares @ ((corners[parts == k] - low) / grain)
        column, row = np.round(places).astype(int).reshape(-1, 2).T
        mask[row, column] = True
    return mask, low


def _borders(values: Float[Array, "rows columns"]) -> list[Float[Array, "n 2"]]:
    """Return the closed curves along which a grid is zero, in columns and rows of it."""
    inside = values > 0
    upper, lower = inside[:-1].astype(int), inside[1:].astype(int)
    kinds = upper[:, :-1] + 2 * upper[:, 1:] + 4 * lower[:, 1:] + 8 * lower[:, :-1]
    width = 2 * values.shape[1]
    after: dict[int, int] = {}
    for row, column in np.argwhere((kinds > 0) & (kinds < 15)).tolist():
        first = row * width + 2 * column
        # An edge of the grid has the number of its first node, twice, and one more if vertical.
        side = (first, first + 3, first + width, first + 1)
        for start, end in _WAYS[int(kinds[row, column])]:
            after[side[start]] = side[end]
    curves = []
    while after:
        start, here = after.popitem()
        edges = [start]
        while here != start:
            edges.append(here)
            here = after.pop(here)
        curves.append(_crossings(values, np.array(edges), width))
    return curves


def _crossings(values: Array, edges: Int[Array, " n"], width: int) -> Float[Array, "n 2"]:
    """Return where a grid is zero on its edges."""
    row, rest = np.divmod(edges, width)
    column, upright = np.divmod(rest, 2)
    first, second = values[row, column], values[row + upright, column + 1 - upright]
    share = first / (first - second)
    return np.stack([column + share * (1 - upright), row + share * upright], axis=1)


def _longest(curves: list[Float[Array, "n 2"]]) -> Float[Array, "n 2"]:
    return max(curves, key=lambda curve: len(curve))


def _resampled(curve: Float[Array, "n 2"], count: int) -> Float[Array, "count 2"]:
    """Return points at equal distances along a closed curve."""
    closed = np.concatenate([curve, curve[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    wanted = along[-1] * np.arange(count) / count
    return np.stack([np.interp(wanted, along, each) for each in closed.T], axis=1)


def _controls(points: Float[Array, "n 2"]) -> Float[Array, "n 2"]:
    """Return control points whose spline passes near points: it flattens bends by an eighth."""
    return points - (np.roll(points, 1, axis=0) - 2 * points + np.roll(points, -1, axis=0)) / 8

"""Outlines of surfaces as smooth closed curves, and their path data for an SVG.

The triangles of a part are filled on a fine grid, whose border is followed and resampled to a given
number of points. The points control a quadratic B-spline: one command of path data each. In a
motion, outlines begin at corresponding points, so that a browser can interpolate them.
"""

from functools import cache

import numpy as np
from scipy.ndimage import gaussian_filter

from plantigrade.arrays import Array, Float, Int
from plantigrade.motion.filters import interpolate
from plantigrade.pages.outlines import pair

FILL_STEP = 1.0  # Distance of the points that fill a triangle, in steps of the grid. Chosen.
BORDER_LEVEL = 0.4
"""Level of the smoothed mask on the border; below one half, which makes up for the spline's
shrinking at bends. Chosen."""
MARGIN = 3  # Empty cells about a mask, for its smoothing. Chosen.

_NONE, _TOP, _RIGHT, _BOTTOM, _LEFT = -1, 0, 1, 2, 3
# From which side of a cell to which a border goes, by the corners inside: bits 1, 2, 4, 8 for upper
# left, upper right, lower right, lower left. Two cases have a second border.
_FROM = np.array([_NONE, _LEFT, _TOP, _LEFT, _RIGHT, _LEFT, _TOP, _LEFT, _BOTTOM, _BOTTOM, _TOP,
                  _BOTTOM, _RIGHT, _RIGHT, _TOP, _NONE])  # fmt: skip
_TO = np.array([_NONE, _TOP, _RIGHT, _RIGHT, _BOTTOM, _TOP, _BOTTOM, _BOTTOM, _LEFT, _TOP, _RIGHT,
                _RIGHT, _LEFT, _TOP, _LEFT, _NONE])  # fmt: skip
_SECOND = {5: (_RIGHT, _BOTTOM), 10: (_BOTTOM, _LEFT)}


def silhouettes(
    points: Float[Array, "n n_points 2"], faces: Int[Array, "n_faces 3"], count: int, grain: float
) -> Float[Array, "n count 2"]:
    """Return outlines of projected triangles as control points of closed splines, frame by frame.

    Triangles that face away, clockwise seen from the reader, are left out. The longest border is
    taken: of several pieces the largest, and holes do not count.

    Args:
        points: Projected vertices in every frame [m].
        grain: Step of the grid [m].
    """
    moved = np.r_[True, (points[1:] != points[:-1]).any(axis=(1, 2))]
    if not moved.all():  # what rests has the outline of the frame before
        return silhouettes(points[moved], faces, count, grain)[np.cumsum(moved) - 1]
    masks, low = _filled(points, faces, grain)
    values = gaussian_filter(masks.astype(np.float32), (0.0, 1.0, 1.0)) - BORDER_LEVEL
    found = []
    for each, place in zip(values, low, strict=True):
        border = max(_borders(each), key=lambda curve: len(curve))
        found.append(_controls(_resampled(place + grain * border, count)))
    return aligned(np.array(found))


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
        data = f"M{pair(start)}q{pair(control[0] - start)} {pair(middle[0] - start)}t"
        found.append(data + " ".join(pair(step) for step in steps).replace(" -", "-") + "z")
    return found


def _filled(
    points: Float[Array, "n n_points 2"], faces: Int[Array, "n_faces 3"], grain: float
) -> tuple[Array, Array]:
    """Return masks of triangles, ``(n, rows, columns)``, and the places of their first cells."""
    low = points.min(axis=1) - MARGIN * grain
    # Which cell a point fills takes no more than single precision, and the points are many.
    cells = ((points - low[:, None]) / grain).astype(np.float32)
    columns, rows = np.ceil(cells.max(axis=(0, 1))).astype(int) + MARGIN + 1
    x, y = (cells[:, faces, axis] for axis in range(2))
    ahead = [each[..., 1:] - each[..., :1] for each in (x, y)]
    front = ahead[0][..., 0] * ahead[1][..., 1] <= ahead[1][..., 0] * ahead[0][..., 1]
    x, y = x[front], y[front]  # the others face away, and these lie before them
    first = np.nonzero(front)[0] * (rows * columns)
    wide, high = (each.max(axis=1) - each.min(axis=1) for each in (x, y))
    sides = np.maximum(wide, high) * np.float32(np.sqrt(2.0))
    parts = (2 ** np.ceil(np.log2(np.maximum(1.0, sides / FILL_STEP)))).astype(int)
    masks = np.zeros(len(points) * rows * columns, dtype=bool)
    for k in np.unique(parts):  # a few sizes: triangles of one size are filled together
        shares = _shares(int(k))
        own = parts == k
        column, row = (np.rint(each[own] @ shares).astype(np.int32) for each in (x, y))
        masks[first[own, None] + (row * np.int32(columns) + column)] = True
    return masks.reshape(len(points), rows, columns), low


@cache
def _shares(k: int) -> Float[Array, "3 n"]:
    """Return the shares of corners in points that divide each side of a triangle into k parts."""
    i, j = np.triu_indices(k + 1)
    return np.stack([i, j - i, k - j]).astype(np.float32) / np.float32(k)


def _borders(values: Float[Array, "rows columns"]) -> list[Float[Array, "n 2"]]:
    """Return the closed curves along which a grid is zero, in columns and rows of it."""
    inside = values > 0
    upper, lower = inside[:-1].astype(int), inside[1:].astype(int)
    kinds = upper[:, :-1] + 2 * upper[:, 1:] + 4 * lower[:, 1:] + 8 * lower[:, :-1]
    width = 2 * values.shape[1]
    row, column = np.nonzero((kinds > 0) & (kinds < 15))
    kind, first = kinds[row, column], row * width + 2 * column
    # An edge of the grid has the number of its first node, twice, and one more if upright.
    side = np.array([0, 3, width, 1])
    starts, ends = first + side[_FROM[kind]], first + side[_TO[kind]]
    for both, (start, end) in _SECOND.items():
        twice = first[kind == both]
        starts, ends = np.append(starts, twice + side[start]), np.append(ends, twice + side[end])
    after = dict(zip(starts.tolist(), ends.tolist(), strict=True))
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


def _resampled(curve: Float[Array, "n 2"], count: int) -> Float[Array, "count 2"]:
    """Return points at equal distances along a closed curve."""
    closed = np.concatenate([curve, curve[:1]])
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(closed, axis=0), axis=1))])
    distance = along[-1] * np.arange(count) / count
    return interpolate(distance, along, closed)


def _controls(points: Float[Array, "n 2"]) -> Float[Array, "n 2"]:
    """Return control points whose spline passes near points: it flattens bends by an eighth."""
    return points - (np.roll(points, 1, axis=0) - 2 * points + np.roll(points, -1, axis=0)) / 8

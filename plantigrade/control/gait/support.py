"""Support polygon: the convex hull of the points that carry load."""

import numpy as np

from plantigrade.arrays import Array, Float

N_TANGENTS = 48  # resolution of a polygon: directions of the tangents that bound it
_ANGLE = 2 * np.pi * np.arange(N_TANGENTS) / N_TANGENTS
_OUTWARD = np.stack([np.cos(_ANGLE), np.sin(_ANGLE)])


def _shrunk(points: Array, middle: Array, margin: float) -> Array:
    """Return the distances of the tangents from the middle, less the margin or half of them."""
    extent = ((points - middle) @ _OUTWARD).max(axis=0)
    return extent - np.minimum(margin, 0.5 * extent)


def inside(
    points: Float[Array, "k 2"], position: Float[Array, " 2"], margin: float
) -> Float[Array, " 2"]:
    """Return a position, moved straight towards the middle of the support until it is inside.

    Args:
        points: Corners of the support, and any points within it [m].
        position: The position [m].
        margin: Distance to keep from the edge [m]; at most half the distance of middle and edge.
    """
    middle = points.sum(axis=0) / len(points)
    extent = _shrunk(points, middle, margin)
    distance = (position - middle) @ _OUTWARD
    outside = distance > extent
    if not outside.any():
        return position
    return middle + (position - middle) * float((extent[outside] / distance[outside]).min())


def nearest(
    points: Float[Array, "k 2"], position: Float[Array, " 2"], margin: float
) -> Float[Array, " 2"]:
    """Return the point of the support nearest to a position; arguments as for :func:`inside`.

    Projects on the tangent that is exceeded most until none is.
    """
    middle = points.mean(axis=0)
    extent = _shrunk(points, middle, margin)
    offset = position - middle
    for _ in range(N_TANGENTS):
        excess = offset @ _OUTWARD - extent
        worst = int(excess.argmax())
        if excess[worst] < 1e-6:
            break
        offset = offset - excess[worst] * _OUTWARD[:, worst]
    return middle + offset


def beyond(points: Float[Array, "k 2"], position: Float[Array, " 2"]) -> float:
    """Return the distance of a position outside the support [m]; negative inside."""
    if not len(points):
        return np.inf
    return float((position @ _OUTWARD - (points @ _OUTWARD).max(axis=0)).max())


def drawn_to(
    positions: Float[Array, "*k 2"], middle: Float[Array, "*#k 2"], radius: float | Array
) -> Float[Array, "*k 2"]:
    """Return positions, drawn to a circle about a middle where they are outside of it."""
    offset = positions - middle
    distance = np.linalg.norm(offset, axis=-1, keepdims=True)
    return middle + offset * np.minimum(1.0, radius / np.maximum(distance, 1e-9))

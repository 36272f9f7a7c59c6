"""What points that press span."""

import numpy as np

from plantigrade.arrays import Array, Float

INSIDE = 0.015
"""The centre of mass is to be no nearer to the edge of the support [m], where it is wide."""
TANGENTS = 48
"""Directions in which the edge of the support is looked at."""
_ANGLE = 2 * np.pi * np.arange(TANGENTS) / TANGENTS
_OUTWARD = np.stack([np.cos(_ANGLE), np.sin(_ANGLE)])


def inside(
    points: Float[Array, "k 2"], place: Float[Array, " 2"], margin: float = INSIDE
) -> Float[Array, " 2"]:
    """Return a place, or the first within what points span on the way from it to their middle.

    What they span is drawn in by a margin, or by half of the way to the middle where that is less;
    its edge is that of its tangents in :data:`TANGENTS` directions.
    """
    middle = points.sum(axis=0) / len(points)
    far = ((points - middle) @ _OUTWARD).max(axis=0)
    far -= np.minimum(margin, 0.5 * far)
    off = (place - middle) @ _OUTWARD
    over = off > far
    if not over.any():
        return place
    return middle + (place - middle) * float((far[over] / off[over]).min())


def nearest(
    points: Float[Array, "k 2"], place: Float[Array, " 2"], margin: float = INSIDE
) -> Float[Array, " 2"]:
    """Return the nearest place within what points span, drawn in as for :func:`inside`.

    By going back from the tangent that is most exceeded, again and again.
    """
    middle = points.mean(axis=0)
    far = ((points - middle) @ _OUTWARD).max(axis=0)
    far -= np.minimum(margin, 0.5 * far)
    off = place - middle
    for _ in range(TANGENTS):
        over = off @ _OUTWARD - far
        worst = int(over.argmax())
        if over[worst] < 1e-6:
            break
        off = off - over[worst] * _OUTWARD[:, worst]
    return middle + off


def beyond(points: Float[Array, "k 2"], place: Float[Array, " 2"]) -> float:
    """Return how far a place is outside of what points span [m]; negative inside."""
    if not len(points):
        return np.inf
    return float((place @ _OUTWARD - (points @ _OUTWARD).max(axis=0)).max())

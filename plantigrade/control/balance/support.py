"""Where the centre of mass is to be: over the points that press."""

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.control.balance.reference import Wanted

INSIDE = 0.015
"""The centre of mass is to be no nearer to the edge of the support [m], where it is wide."""
TANGENTS = 48
"""Directions in which the edge of the support is looked at."""
_ANGLE = 2 * np.pi * np.arange(TANGENTS) / TANGENTS
_OUTWARD = np.stack([np.cos(_ANGLE), np.sin(_ANGLE)])


def goal_of(
    wanted: Wanted,
    now: Float[Array, "n_sites 3"],
    touches: Int[Array, " k"],
    shift: Float[Array, " 3"],
    central: float = 0.0,
) -> Float[Array, " 3"]:
    """Return where the centre of mass is to be [m].

    As in the reference, moved with the points that press, and inside what they span; as far above
    those that touch as in the reference.

    Args:
        wanted: The reference.
        now: Where the spheres of the feet are.
        touches: Which of them touch.
        shift: So far from there [m].
        central: Part of the way from where the reference has it to the middle of those that press.
    """
    mine = wanted.presses.nonzero()[0]
    if not len(mine):
        return wanted.com + shift
    pressing, evenly = now[mine], np.full(len(mine), 1.0 / len(mine))
    goal = wanted.com + evenly @ (pressing - wanted.places[mine])
    goal[:2] += central * (evenly @ pressing[:, :2] - goal[:2])
    goal[:2] = inside(pressing[:, :2], goal[:2] + shift[:2])
    on = touches[wanted.presses[touches]]
    rise = (now[on, 2] - wanted.places[on, 2]).sum() / len(on) if len(on) else 0.0
    goal[2] = wanted.com[2] + shift[2] + rise
    return goal


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


def beyond(points: Float[Array, "k 2"], place: Float[Array, " 2"]) -> float:
    """Return how far a place is outside of what points span [m]; negative inside."""
    if not len(points):
        return np.inf
    return float((place @ _OUTWARD - (points @ _OUTWARD).max(axis=0)).max())

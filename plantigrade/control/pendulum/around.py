"""The way of a foot around the other one, on which the body stands.

Seen from above, legs hang together at the hips: a foot gets from behind the other one to ahead of
it on its own side alone, however far it has crossed over on either side.
"""

import numpy as np

from plantigrade.arrays import Array, Float

BESIDE, AHEAD = 0.1, 0.25
"""So far from the other one a foot passes it, beside it and ahead of it or behind [leg lengths]: a
foot is as wide and as long."""


def via(
    start: Float[Array, " 2"], ends: Float[Array, "m 2"], size: Float[Array, " 2"]
) -> tuple[Float[Array, "m 2"], Array]:
    """Return points by which a foot goes around the other one, and where it has to.

    The point is on the ellipse, in the direction in which the straight way is nearest to the other
    foot; half way round where that would be on the wrong side.

    Args:
        start: Where the foot is: ahead of the other, and outward from it [m].
        ends: Where it could go, likewise [m].
        size: Half axes of the ellipse around the other foot that it leaves free [m].

    Returns:
        Points, and which of them are on the way; elsewhere it goes straight.
    """
    a, b = start / size, ends / size
    begins, turns = np.arctan2(a[0], a[1]), np.arctan2(b[:, 0], b[:, 1])
    way = b - a
    part = -(way @ a) / np.maximum((way * way).sum(axis=1), 1e-12)
    near = a + part[:, None] * way
    far = np.sqrt((near * near).sum(axis=1))
    crosses = (part > 0.0) & (part < 1.0)
    wrong = np.abs(turns - begins) >= np.pi  # through the leg that stands
    middle = 0.5 * (begins + turns)
    out = near / np.maximum(far, 1e-9)[:, None]
    out = np.where(wrong[:, None], np.stack([np.sin(middle), np.cos(middle)], axis=1), out)
    return out * size, wrong | (crosses & (far < 1.0))


def length(
    start: Float[Array, " 2"], ends: Float[Array, "m 2"], size: Float[Array, " 2"]
) -> Float[Array, " m"]:
    """Return by how much ways around the other foot are longer than straight ones [m].

    Args:
        start: Where the foot is: ahead of the other, and outward from it [m].
        ends: Where it could go, likewise [m].
        size: Half axes of the ellipse around the other foot that it leaves free [m].
    """
    point, around = via(start, ends, size)
    legs = ends - start, point - start, ends - point
    straight, first, second = (np.sqrt((leg * leg).sum(axis=1)) for leg in legs)
    return np.where(around, first + second - straight, 0.0)

"""The polygon that the zero-moment point must stay in (Fig. 4 of [Zhakatayev2023]_).

The paper always takes a quadrilateral, in three cases:

a) long step: the heel of the foot in front is ahead of the toes of the other. Its corners are the
   heel of the foot behind and the toes of the foot in front;
b) short step, or parallel feet: the outer edges of both feet. The small regions at the
   inner heel behind and the inner toes in front are omitted, as in the paper;
c) one foot: heel and toes.

The figure is a picture and the text does not list the corners of case a; heel behind and toes in
front are the two edges that a step rolls over, and between them everything is inside the convex
hull of both feet.
"""

import numpy as np
from scipy.spatial import ConvexHull

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError

# places among the six points of a foot
_HEEL_INNER, _HEEL_OUTER, _TOE_INNER, _TOE_OUTER = 0, 1, 4, 5


def corners(feet: dict[str, Float[Array, "6 2"]]) -> Float[Array, "n_corners 2"]:
    """Return the corners of the support polygon of feet that stand, counterclockwise, world [m].

    The six points of a foot are in the order of
    :data:`~plantigrade.trajopt.zhakatayev2023.body.CONTACTS`.

    Raises:
        ParameterError: If no foot stands.
    """
    if not feet:
        raise ParameterError("no foot stands: there is no support polygon")
    if len(feet) == 1:
        (foot,) = feet.values()
        return convex(foot[[_HEEL_INNER, _HEEL_OUTER, _TOE_INNER, _TOE_OUTER]])
    back, front = sorted(feet.values(), key=lambda foot: float(foot[:, 0].mean()))
    if front[_HEEL_INNER, 0] > back[:, 0].max():
        return convex(
            np.vstack([back[[_HEEL_INNER, _HEEL_OUTER]], front[[_TOE_INNER, _TOE_OUTER]]])
        )
    outer = [_HEEL_OUTER, _TOE_OUTER]
    return convex(np.vstack([back[outer], front[outer]]))


def convex(points: Float[Array, "n 2"]) -> Float[Array, "n_corners 2"]:
    """Return the corners of the convex hull of points, counterclockwise."""
    return points[ConvexHull(points).vertices]


def edges(polygon: Float[Array, "n_corners 2"]) -> Float[Array, "n_corners 3"]:
    r"""Return the edges as half-planes :math:`n_x x + n_y y \le b`: (n_x, n_y, b), n of length 1.

    For a point :math:`r`, :math:`n \cdot r - b` is how far outside it is [m]: Eq. 25 over the
    length of the edge, its sign ε settled by the order of the corners.
    """
    along = np.roll(polygon, -1, axis=0) - polygon
    normal = np.column_stack([along[:, 1], -along[:, 0]])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return np.column_stack([normal, np.sum(normal * polygon, axis=1)])


def outside(
    points: Float[Array, "n 2"], polygon: Float[Array, "n_corners 2"]
) -> Float[Array, " n"]:
    """Return how far points are outside a convex polygon [m]; inside, negative, to its edge."""
    half_planes = edges(polygon)
    off = points @ half_planes[:, :2].T - half_planes[:, 2]
    inside = off.max(axis=1)
    start, stop = polygon, np.roll(polygon, -1, axis=0)
    along = stop - start
    t = np.einsum("nej,ej->ne", points[:, None] - start, along) / np.sum(along**2, axis=1)
    nearest = start + np.clip(t, 0, 1)[..., None] * along
    distance = np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)
    return np.where(inside > 0, distance, inside)

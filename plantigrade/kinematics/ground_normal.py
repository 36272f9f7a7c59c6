r"""The normal of the ground as a foot sees it, when some of its points have to touch the ground.

With :math:`u = R^T n` for a foot of orientation :math:`R`, a point :math:`v` of the foot is
:math:`-u^T v` below its ankle. The conditions of the foot's points on its orientation are all in
:math:`u`; turning about :math:`n` changes none of it.
"""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import CROSS
from plantigrade.spatial.conventions import matrices

ZERO_LENGTH = 1e-9  # [m] length or sine below which a vector counts as zero
HALF_TURN_TOLERANCE = 1e-12  # [1] 1 + cosine below which a rotation is a half-turn
MAX_DIRECT_COSINE = -0.9  # [1] cosine below which a rotation is composed with a half-turn
EQUAL_DEPTH = 1e-4  # [m] difference of depth of equally good poses
_ONE = np.eye(3)


class GroundNormal:
    """Finds the normal at which points of the foot are as far below the ankle as they have to be.

    Args:
        points: The points, in the foot; at most three, not on one line with the ankle [m].
    """

    def __init__(self, points: Float[Array, "k 3"]):
        self.k = len(points)
        if self.k == 1:
            self.length = float(np.linalg.norm(points))
            self.along = points[0] / self.length
            self.sideways = _ONE[0] - self.along[0] * self.along
            self.sideways /= np.linalg.norm(self.sideways)
        elif self.k:
            self.least = -np.linalg.pinv(points).T  # (k, 3)
            self.rise = -self.least.sum(axis=0)
            self.rise2 = float(self.rise @ self.rise)
            if self.k == 2:
                across = np.cross(points[0], points[1])
                self.across = across / np.linalg.norm(across)

    def __call__(self, w, seen, others=None, high=None):
        """Return the normal nearest to the one seen, how far the ankle sinks, what stays open.

        Args:
            w: How far each point has to be below the ankle, (n, k) [m].
            seen: The normal as the foot sees it that is not turned, (n, 3).
            others: Centres and radii of the spheres that shall not sink [m]; any may if None.
            high: Height of the ankle above the ground, (n,) [m].
        """
        if self.k == 0:
            return seen, np.zeros(len(seen)), np.zeros(len(seen), bool)
        if self.k == 1:
            return self._one(w[:, 0], seen)
        a = w @ self.least
        down = self._least_sinking(a)
        u = a + down[:, None] * self.rise
        if self.k == 2:
            aside = np.sqrt(np.maximum(1.0 - (u * u).sum(axis=1), 0.0))[:, None] * self.across
            u = self._better(u + aside, u - aside, seen, others, high - down)
        u = u / np.sqrt((u * u).sum(axis=1))[:, None]
        return u, down, np.zeros(len(u), bool)

    def _one(self, w, seen):
        """Eqs. 1 and 2 of [Park2020]_: the turn in the plane of the normal and the joint."""
        cosine = np.minimum(np.maximum(w / self.length, -1.0), 1.0)
        down = w - self.length * cosine
        aside = seen - (seen @ self.along)[:, None] * self.along
        size = np.sqrt((aside * aside).sum(axis=1))
        sine = np.sqrt(1.0 - cosine * cosine)
        open_ = size < ZERO_LENGTH
        if size.min() < ZERO_LENGTH:
            aside[open_], size[open_] = self.sideways, 1.0
        u = (sine / size)[:, None] * aside - cosine[:, None] * self.along
        return u, down, open_ & (sine > ZERO_LENGTH)

    def _least_sinking(self, a):
        r"""Return by how much the ankle has to sink that a normal of unit length exists [m].

        It is a root of :math:`|a + d\,b| = 1`: the one nearer to zero, of three points the one at
        which the foot is the right way up. Two points need none where :math:`|a|\le 1`. On rough
        ground three may have none: then the shortest normal is taken.
        """
        half, rest = a @ self.rise, (a * a).sum(axis=1) - 1.0
        root = np.sqrt(np.maximum(half * half - self.rise2 * rest, 0.0))
        if self.k == 3:
            return (np.sign(self.rise[2]) * root - half) / self.rise2
        d = (np.where(half < 0, -root, root) - half) / self.rise2
        return np.where(rest > 0, d, 0.0)

    def _better(self, one, other, seen, others, high):
        """Return of two normals the one that sinks less, or else the nearer one."""
        first = ((one - other) * seen).sum(axis=1) >= 0
        if others is not None and len(others[0]):
            centres, radius = others
            low = [(u @ centres.T - radius).min(axis=1) + high for u in (one, other)]
            more = np.minimum(low[0], 0.0) - np.minimum(low[1], 0.0)
            first = np.where(np.abs(more) > EQUAL_DEPTH, more > 0, first)
        return np.where(first[:, None], one, other)


def smallest_turn(c, d):
    """Return the smallest rotation that takes unit vectors c to d, and where it is a half-turn.

    Eq. 5 of [Park2020]_, which is undefined there; half-turns are made about the second axis, or as
    near to it as is square to c.
    """
    cosine = (c * d).sum(axis=1)
    K = (c @ CROSS).reshape(-1, 3, 3) @ d[:, :, None]
    half = cosine < HALF_TURN_TOLERANCE - 1.0
    turn = cosine[:, None, None] * _ONE + (K[..., 0] @ CROSS).reshape(-1, 3, 3)
    turn += K @ (K.swapaxes(1, 2) / np.maximum(1.0 + cosine, ZERO_LENGTH)[:, None, None])
    near = cosine < MAX_DIRECT_COSINE
    if near.any():
        # A half-turn about the same axis, or any where there is none, and what is left of it.
        lost, k, ours = half[near], K[near, :, 0], c[near]
        size = np.linalg.norm(k, axis=1)[:, None]
        spare = axes_from(ours, np.tile(_ONE[1], (len(ours), 1)))[0][..., 0]
        axis = np.where(lost[:, None], spare, k / np.maximum(size, ZERO_LENGTH))
        axis -= ours * (axis * ours).sum(axis=1)[:, None]
        axis /= np.linalg.norm(axis, axis=1)[:, None]
        left, _ = smallest_turn(-ours, d[near])
        turn[near] = left @ (2 * axis[:, :, None] * axis[:, None] - _ONE)
    return turn, half


def axes_from(up, forward, instead=None):
    """Return axes whose third is ``up`` and whose first is ``forward``, as far as it can be.

    Arrays of vectors broadcast, (..., 3). Where ``forward`` is along ``up`` its place is taken by
    ``instead``, and where that is too, by the axis of space most across. Also returns where
    ``forward`` was.
    """
    x = forward - up * (forward * up).sum(axis=-1, keepdims=True)
    size = np.sqrt((x * x).sum(axis=-1, keepdims=True))
    along = size[..., 0] < ZERO_LENGTH
    if size.min() < ZERO_LENGTH:
        up, x = np.broadcast_arrays(up, x)
        x, size = x.copy(), size.copy()
        for other in (instead, _ONE[np.abs(up).argmin(axis=-1)]):
            if other is not None:
                flat = other - up * (other * up).sum(axis=-1, keepdims=True)
                lost = size[..., 0] < ZERO_LENGTH
                x[lost] = np.broadcast_to(flat, x.shape)[lost]
                size = np.sqrt((x * x).sum(axis=-1, keepdims=True))
    x /= size
    out = np.empty((*x.shape, 3))
    out[..., 0], out[..., 2] = x, up
    out[..., 1] = ((up @ CROSS).reshape(*up.shape, 3) @ x[..., None])[..., 0]
    return out, along


def hinge_angles(turn: Float[Array, "*n 3 3"], sign: float) -> Float[Array, "*n 3"]:
    """Return bending, inversion and adduction of a joint within the foot [rad]."""
    out = np.empty(turn.shape[:-1])
    out[..., 0] = -np.arctan2(turn[..., 0, 2], turn[..., 2, 2])
    out[..., 1] = sign * np.arcsin(np.minimum(np.maximum(-turn[..., 1, 2], -1.0), 1.0))
    out[..., 2] = sign * np.arctan2(turn[..., 1, 0], turn[..., 1, 1])
    return out


def hinge_turn(angles: Float[Array, "*n 3"], sign: float) -> Float[Array, "*n 3 3"]:
    """Return the rotation of a joint within the foot from its hinges, as :func:`hinge_angles`."""
    (ca, cb, cc), (sa, sb, sc) = (
        np.moveaxis(f(angles * [-1.0, sign, sign]), -1, 0) for f in (np.cos, np.sin)
    )
    rows = (
        (ca * cc + sa * sb * sc, sa * sb * cc - ca * sc, sa * cb),
        (cb * sc, cb * cc, -sb),
        (ca * sb * sc - sa * cc, ca * sb * cc + sa * sc, ca * cb),
    )
    return matrices(rows)


def plane_slopes(share, x, z, middle, level):
    """Return the slopes of the least-squares planes through heights z at positions x.

    Args:
        share: Weights of the positions for each plane, (k, m), with unit sum.
        x: Positions, (n, m, 2).
        z: Heights, (n, m).
        middle: Mean positions, (n, k, 2).
        level: Mean heights, (n, k).
    """
    off = np.empty((*level.shape, len(share[0]), 3))
    off[..., :2] = x[:, None] - middle[:, :, None]
    off[..., 2] = z[:, None] - level[..., None]
    M = (share[..., None] * off[..., :2]).swapaxes(-1, -2) @ off
    a, b, f, c, g = M[..., 0, 0], M[..., 0, 1], M[..., 0, 2], M[..., 1, 1], M[..., 1, 2]
    slope = np.empty(middle.shape)
    det = a * c - b * b
    slope[..., 0], slope[..., 1] = (c * f - b * g) / det, (a * g - b * f) / det
    return slope


def sole_plane(spheres: tuple[np.ndarray, np.ndarray]) -> tuple[np.ndarray, float]:
    """Return the normal of a sole, and the height of its joint above the ground it lies on [m]."""
    centre, radius = spheres
    bottom = centre - radius[:, None] * np.array([0.0, 0.0, 1.0])
    flat = bottom - bottom.mean(axis=0)
    slope = np.linalg.lstsq(flat[:, :2], flat[:, 2], rcond=None)[0]
    normal = np.array([-slope[0], -slope[1], 1.0])
    normal /= np.linalg.norm(normal)
    return normal, float((radius - centre @ normal).max())

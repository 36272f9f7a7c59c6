"""Planes through points of a foot."""

import numpy as np


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

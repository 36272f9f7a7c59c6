"""Rotations that turn one direction into another."""

import numpy as np
from scipy.spatial.transform import Rotation


def unit_vector(v: np.ndarray) -> np.ndarray:
    """Return vectors of length one; zero stays zero."""
    size = np.linalg.norm(v, axis=-1, keepdims=True)
    return v / np.where(size > 1e-12, size, 1.0)


def swing(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the smallest rotation that takes direction ``a`` to ``b``."""
    a, b = unit_vector(a), unit_vector(b)
    axis, cosine = np.cross(a, b), float(a @ b)
    size = np.linalg.norm(axis)
    if size < 1e-9:
        return np.eye(3) if cosine > 0 else Rotation.from_rotvec(np.pi * np.eye(3)[0]).as_matrix()
    return Rotation.from_rotvec(axis / size * np.arctan2(size, cosine)).as_matrix()


def yaw(direction: np.ndarray) -> np.ndarray:
    """Return rotations about the vertical that turn x towards ``direction``."""
    c, s = np.moveaxis(unit_vector(direction[..., :2]), -1, 0)
    zero, one = np.zeros_like(c), np.ones_like(c)
    rows = [[c, -s, zero], [s, c, zero], [zero, zero, one]]
    return np.stack([np.stack(r, axis=-1) for r in rows], axis=-2)


def mean_rotation(R: np.ndarray) -> np.ndarray:
    """Return the rotation nearest to the mean of rotation matrices."""
    u, _, v = np.linalg.svd(R.mean(axis=0))
    return u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v

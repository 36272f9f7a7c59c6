"""Directions."""

import numpy as np

from plantigrade.arrays import Array, Float

MIN_LENGTH = 1e-12  # below which a vector has no direction


def unit_vectors(vectors: Float[Array, "*n k"]) -> Float[Array, "*n k"]:
    """Return vectors of length one; zero stays zero."""
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), MIN_LENGTH)


def nearest_right_angle(
    way: Float[Array, " 2"], direction: Float[Array, " 2"]
) -> Float[Array, " 2"]:
    """Return a direction, turned by the right angles that bring it nearest to another one."""
    left = np.array([-way[1], way[0]])
    x, y = float(way @ direction), float(left @ direction)
    return way * np.copysign(1.0, x) if abs(x) >= abs(y) else left * np.copysign(1.0, y)

"""Smooth rises from 0 to 1, by which one thing turns into another."""

from typing import overload

import numpy as np

from plantigrade.arrays import Array


@overload
def cubic_rise(share: float) -> float: ...
@overload
def cubic_rise(share: Array) -> Array: ...
def cubic_rise(share: Array | float) -> Array | float:
    """Return a rise from 0 at 0 to 1 at 1 whose slope is zero at the ends.

    Example:
        >>> cubic_rise(np.array([-1.0, 0.0, 0.5, 2.0])).tolist()
        [0.0, 0.0, 0.5, 1.0]
    """
    s = np.minimum(np.maximum(share, 0.0), 1.0)
    return s * s * (3.0 - 2.0 * s)


@overload
def quintic_rise(share: float) -> float: ...
@overload
def quintic_rise(share: Array) -> Array: ...
def quintic_rise(share: Array | float) -> Array | float:
    """Return a rise from 0 at 0 to 1 at 1 whose slope and curvature are zero at the ends."""
    s = np.minimum(np.maximum(share, 0.0), 1.0)
    return s**3 * (10.0 - 15.0 * s + 6.0 * s * s)

r"""Symmetry of left and right: an index of single measures, and one of curves.

The symmetry index of a measure is the difference of right and left in percent of their mean
[Robinson1987]_,

.. math:: \mathrm{SI} = 100\,\frac{R - L}{\frac{1}{2} (R + L)} :

0 if they are equal, positive if the right is greater. It is undefined for measures that change
sign, such as an angle; for those the range over the cycle is used.

The trend symmetry of two curves compares their shapes alone [Crenshaw2006]_: of the points
:math:`(R_i - \bar R, L_i - \bar L)` over the cycle it is the variance across the principal axis in
percent of that along it; 0 if one curve is the other scaled and shifted.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES

MEASURES = ("step_length_{}_m", "step_time_{}_s", "stance_{}_pct", "swing_{}_pct")
ANGLES = ("hip_flexion", "hip_adduction", "hip_rotation", "knee_angle", "ankle_angle")


def symmetry_index(right: float, left: float) -> float:
    """Return the symmetry index of a measure [%]; NaN unless it is positive on both sides.

    Example:
        >>> symmetry_index(0.66, 0.60), symmetry_index(0.6, -0.6)
        (9.523809523809533, nan)
    """
    if not (right > 0 and left > 0):
        return float("nan")
    return float(200.0 * (right - left) / (right + left))


def trend_symmetry(right: Float[Array, " n"], left: Float[Array, " n"]) -> float:
    """Return the trend symmetry of two mean curves over the cycle [%]; NaN for constant curves.

    Example:
        >>> t = np.linspace(0, 2 * np.pi, 100, endpoint=False)
        >>> round(trend_symmetry(np.sin(t), 3 * np.sin(t) + 5), 6)
        0.0
        >>> round(trend_symmetry(np.sin(t), np.cos(t)))  # a quarter of a cycle late
        100
    """
    known = np.isfinite(right) & np.isfinite(left)
    if known.sum() < 3:
        return float("nan")
    across, along = np.linalg.eigvalsh(np.cov(right[known], left[known]))
    return float(100.0 * max(across, 0.0) / along) if along > 1e-9 else float("nan")


def symmetry_figures(
    figures: Mapping[str, Any], angles: Mapping[str, Float[Array, "n_cycles n_percent"]]
) -> dict[str, float]:
    """Return the indices of a gait under flat keys [%, deg]; unknown ones are omitted.

    Args:
        figures: Spatio-temporal measures, as in ``metrics.json``.
        angles: Angles by name and side, cycles by percent [deg].
    """
    found = {}
    for key in MEASURES:
        right, left = (figures.get(key.format(side)) for side in SIDES)
        if isinstance(right, float) and isinstance(left, float):
            name = key.partition("_{}")[0]
            found[f"symmetry_index_{name}_pct"] = symmetry_index(right, left)
    for name in ANGLES:
        rows = [angles.get(f"{name}_{side}", np.empty((0, 1))) for side in SIDES]
        if not all(np.isfinite(each).any() for each in rows):
            continue
        means = [np.nanmean(each, axis=0) for each in rows]
        ranges = [float(np.nanmax(each) - np.nanmin(each)) for each in means]
        found[f"symmetry_index_{name}_range_pct"] = symmetry_index(*ranges)
        found[f"trend_symmetry_{name}_pct"] = trend_symmetry(*means)
    return {key: value for key, value in found.items() if np.isfinite(value)}

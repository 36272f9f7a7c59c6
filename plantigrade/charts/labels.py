"""Labels of coordinates in plots: titles, sides, meaning of positive and negative values."""

from dataclasses import dataclass

from plantigrade.data_files import csv_rows
from plantigrade.side_names import without_side


@dataclass(frozen=True)
class Label:
    """Words for a coordinate in a plot."""

    name: str  #: Its name, without side
    title: str  #: Its title
    positive: str  #: What positive means, short enough for an axis
    negative: str  #: What negative means


COORDINATES = {row.name: row for row in csv_rows("plantigrade.charts", "coordinates.csv", Label)}
UNITS = {"deg": "°", "N m/kg": "N m/kg", "body weight": "BW"}
"""Unit of a curve over the cycle → its sign in a plot."""
MIN_SPANS = {"°": 10.0, "N m": 10.0, "N m/kg": 0.2, "W/kg": 0.2, "BW": 0.1}
"""Minimum span of the vertical axis, by unit; a smaller one would magnify noise."""


def title_of(name: str) -> str:
    """Return the title of the coordinate ``name``, without its side.

    Example:
        >>> title_of("knee_angle_r"), title_of("hip_flexion_l_moment"), title_of("neck_extension")
        ('Knee flexion', 'Hip flexion moment', 'Neck extension')
    """
    base = without_side(name)
    for ending in ("_moment", "_power", "_force"):
        if base.endswith(ending):
            return f"{title_of(base.removesuffix(ending))} {ending[1:]}"
    known = COORDINATES.get(base)
    return base.replace("_", " ").strip().capitalize() if known is None else known.title


def axis_label(base: str, unit: str) -> str:
    """Return the label of the vertical axis, with the meaning of its ends if known."""
    known = COORDINATES.get(base.removesuffix("_moment"))
    up, down = ("", "") if known is None else (known.positive, known.negative)
    if base.endswith("_power"):
        up, down = "gives", "takes"
    return f"{down} ← [{unit}] → {up}" if up else f"[{unit}]"

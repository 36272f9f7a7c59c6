"""Points and lines that a controller draws."""

from dataclasses import dataclass

from plantigrade.arrays import Array, Float


@dataclass(frozen=True, eq=False, kw_only=True)
class Drawing:
    """Points and lines in world axes.

    Attributes:
        name: Name of the drawing; it replaces an earlier one of the same name.
        points: Points [m].
        lines: Both end points of each line [m].
        colour: Hexadecimal colour, such as ``"#7e57c2"``.
    """

    name: str
    points: Float[Array, "n_points 3"] | None = None
    lines: Float[Array, "n_lines 2 3"] | None = None
    colour: str = "#7e57c2"

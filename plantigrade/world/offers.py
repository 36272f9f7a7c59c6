"""Targets of a controller, to be set while it runs, and what it draws."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError


@dataclass(eq=False)
class Target:
    """A number that a person may set while a controller runs, as with a slider.

    Attributes:
        name: What it is called.
        low: Least value.
        high: Greatest value.
        value: What it is now; the controller reads it whenever it is called.
        unit: Of all three, as it is shown: ``"deg"``, ``"m/s"``; empty for a mere number.
        names: Of what is chosen by number, from zero on; empty where it is a number.

    Raises:
        ParameterError: If the value is not from the least to the greatest.
    """

    name: str
    low: float
    high: float
    value: float
    unit: str = ""
    names: tuple[str, ...] = ()

    def __post_init__(self):
        """Refuse what is no range."""
        if not (np.isfinite([self.low, self.high]).all() and self.low < self.high):
            raise ParameterError(f"{self.name}: {self.low:g} to {self.high:g} is no range")
        self.set(self.value)

    def set(self, value: float) -> None:
        """Set it.

        Raises:
            ParameterError: If the value is out of range.
        """
        if not self.low <= value <= self.high:  # NaN is not within any range
            raise ParameterError(
                f"{self.name} must be {self.low:g}–{self.high:g} {self.unit}, not {value:g}"
            )
        self.value = float(value)


@dataclass(frozen=True, eq=False, kw_only=True)
class Drawing:
    """Points and lines in world axes.

    Attributes:
        name: What they are; what has the name of an earlier one takes its place.
        points: Points [m].
        lines: Both ends of each line [m].
        colour: Red, green and blue in hexadecimal, as ``"#7e57c2"``.
    """

    name: str
    points: Float[Array, "n_points 3"] | None = None
    lines: Float[Array, "n_lines 2 3"] | None = None
    colour: str = "#7e57c2"

"""What a controller may offer to whoever watches it: targets to be set, and drawings.

Both are optional and looked up by name, so any object that is called with a state may have them::

    class Sway:
        def __init__(self):
            self.targets = (Target("lean", -5.0, 5.0, 0.0, "deg"),)

        def __call__(self, state):
            lean = np.deg2rad(self.targets[0].value)
            ...

        def drawings(self, state):
            return (Drawing("where the weight is to be", points=self.goal[None]),)
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.world.state import State


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


def targets_of(controller: Any) -> tuple[Target, ...]:
    """Return what may be set of a controller; nothing where it offers nothing."""
    return tuple(getattr(controller, "targets", ()))


def drawings_of(controller: Any, state: State) -> Sequence[Drawing]:
    """Return what a controller draws of a state; nothing where it offers nothing."""
    draws = getattr(controller, "drawings", None)
    return () if draws is None else tuple(draws(state))

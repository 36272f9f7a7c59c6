"""Targets of a controller, which a slider or a script sets while it runs."""

from dataclasses import dataclass

import numpy as np

from plantigrade.errors import ParameterError


@dataclass(eq=False)
class Target:
    """A number that a slider or a script sets during a simulation.

    Attributes:
        name: Name of the target.
        low: Minimum.
        high: Maximum.
        value: Present value, which the controller reads at every call.
        unit: Unit as displayed, such as ``"deg"`` or ``"m/s"``; empty if dimensionless.
        names: Names of choices, numbered from zero; empty for a continuous target.

    Raises:
        ParameterError: If the value is not between minimum and maximum.
    """

    name: str
    low: float
    high: float
    value: float
    unit: str = ""
    names: tuple[str, ...] = ()

    def __post_init__(self):
        """Check the numbers."""
        if not (np.isfinite([self.low, self.high]).all() and self.low < self.high):
            raise ParameterError(f"{self.name}: {self.low:g} to {self.high:g} is not a range")
        self.set(self.value)

    def set(self, value: float) -> None:
        """Set the value.

        Raises:
            ParameterError: If the value is out of range.
        """
        if not self.low <= value <= self.high:  # also refuses NaN
            raise ParameterError(
                f"{self.name} must be {self.low:g}–{self.high:g} {self.unit}, not {value:g}"
            )
        self.value = float(value)

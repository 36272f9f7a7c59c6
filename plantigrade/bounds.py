"""Bounds of settings: every settings class states the ranges of its numeric fields.

This module does not import NumPy.
"""

from collections.abc import Mapping
from dataclasses import fields
from numbers import Integral
from typing import Any, ClassVar

from plantigrade.errors import ParameterError
from plantigrade.options import check_types, is_real, shown

RADIAN = 57.29577951308232  # [deg/rad]
SEEDS = (0, 2**32 - 1, "")  # Range of seeds of random generators (NumPy's legacy limit)
AGES = (0.5, 120, "years")  # Range of people's ages


class Bounded:
    """A dataclass of settings whose types and ranges are checked on construction.

    A subclass with checks of its own calls ``super().__post_init__()`` first.
    """

    activity: ClassVar[str] = ""
    """Activity that messages name, as ``"walking"``."""
    ranges: ClassVar[Mapping[str, tuple[float, float, str]]] = {}
    """Minimum, maximum and unit of each number; the unit of angles is ``"degrees"``."""

    def __post_init__(self):
        """Check types and ranges of all fields.

        Raises:
            ParameterError: If a value has another type or is out of range.
        """
        check_types(self)
        default = {f.name: f.default for f in fields(self)}  # type: ignore[arg-type]
        for kind in type(self).__mro__:
            of = getattr(kind, "activity", "")
            for name, (low, high, unit) in vars(kind).get("ranges", {}).items():
                value: Any = getattr(self, name)
                if (value, default[name]) == (None, None):
                    continue
                if isinstance(default[name], int):
                    whole(name, value, low, high, f"for {of}" if of else "")
                elif unit == "degrees":
                    number(name, in_degrees(value), low, high, unit, of)
                else:
                    number(name, value, low, high, unit, of)


def number(name: str, value: Any, low: float, high: float, unit: str, what: str = "") -> None:
    """Check that a value is a number from ``low`` to ``high``."""
    if not is_real(value) or not low <= value <= high:  # NaN is not within any bounds
        where = " ".join(filter(None, (unit, what and f"for {what}")))
        raise ParameterError(f"{name} must be {low:.3g}–{high:.3g} {where}, not {shown(value)}")


def whole(name: str, value: Any, low: float, high: float, what: str = "") -> None:
    """Check that a value is a whole number from ``low`` to ``high``."""
    if isinstance(value, bool) or not isinstance(value, Integral) or not low <= int(value) <= high:
        allowed = f"{name} must be a whole number from {low} to {high} {what}".rstrip()
        raise ParameterError(f"{allowed}, not {shown(value)}")


def word(name: str, value: Any, allowed: tuple[str, ...]) -> None:
    """Check that a value is one of the allowed names."""
    if value not in allowed:
        raise ParameterError(
            f"{name} must be {' or '.join(map(repr, allowed))}, not {shown(value)}"
        )


def in_degrees(value: Any) -> Any:
    """Return an angle in degrees; values that are not numbers, or too large, unchanged."""
    huge = isinstance(value, Integral) and abs(int(value)) >= 10**300
    return value * RADIAN if is_real(value) and not huge else value

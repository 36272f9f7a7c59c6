"""Every signal of a Record: name, unit, shape, meaning, and the section of a report that draws it.

``docs/signals.md`` is this table. Axes are named: ``frames`` are those of the motion, ``nv`` its
generalised forces, ``hinges`` its hinges, ``markers`` its recorded markers; other axes of one name
are equally long within a family, which is what stands before the first dot. ``*`` stands for any
word. Names of the families ``controller``, ``live`` and ``user`` are free.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from plantigrade.data_files import csv_rows
from plantigrade.errors import ParameterError, known_names

Kind = Literal["number", "word", "flag"]


@dataclass(frozen=True)
class Signal:
    """A signal that the package knows, or a family of them."""

    name: str  #: Its name; ``*`` at the end stands for any word
    kind: Kind  #: What it holds
    shape: str  #: Names or lengths of its axes, with spaces; ``...`` for any shape
    unit: str  #: SI unit, ``°`` or ``%``; empty for words, flags and pure numbers
    meaning: str  #: What it is
    section: str = ""  #: Title of the section of the report that draws it, ``viewer``, or empty

    @property
    def axes(self) -> tuple[str | int, ...]:
        """Names or lengths of its axes."""
        return tuple(int(axis) if axis.isdigit() else axis for axis in self.shape.split())

    @property
    def has_any_shape(self) -> bool:
        """Whether nothing is asked of its kind and shape."""
        return self.shape == "..."


CONTROLLER, LIVE, USER = "controller.", "live.", "user."
"""Beginnings of free names: what a controller, a live session or a user stores."""

SIGNALS: Mapping[str, Signal] = {
    row.name: row for row in csv_rows("plantigrade.record", "signals.csv", Signal)
}
"""Every signal by name, and families by ``NAME.*``."""
_FAMILIES = {name[:-1]: signal for name, signal in SIGNALS.items() if name.endswith("*")}


def signal_of(name: str) -> Signal:
    """Return the signal of a name, or the family that it belongs to.

    Example:
        >>> signal_of("controller.com_error").unit
        'm'
    """
    found = SIGNALS.get(name)
    if found is not None:
        return found
    for beginning, family in _FAMILIES.items():
        if name.startswith(beginning) and name != beginning:
            return family
    raise ParameterError(
        f"no signal is called {name!r}; {known_names(name, list(SIGNALS))}. Names of your own "
        f"begin with {USER!r}, those of a controller with {CONTROLLER!r}"
    )

"""Quantities of the check: key in ``metrics.json``, unit, wording and advice."""

from dataclasses import dataclass

from plantigrade.data_files import csv_rows


@dataclass(frozen=True)
class Quantity:
    """Report of a quantity."""

    name: str  #: Its name
    key: str  #: Its key in ``metrics.json``
    unit: str  #: Unit of its value and limit
    label: str  #: What it is, in a table
    words: str  #: Sentence of a fault, with ``{where}``, ``{value}`` and ``{unit}``
    advice: str  #: Advice


_BY_NAME = {row.name: row for row in csv_rows("plantigrade.analyze", "quantities.csv", Quantity)}
CONDITION = _BY_NAME["condition"]
"""Conditions of a task, reported by their own names and units."""
QUANTITY = {name: row for name, row in _BY_NAME.items() if name != "condition"}
QUANTITIES = tuple(QUANTITY)
"""Quantities that are checked in every motion."""

OF_JOINTS = ("coordinate", "velocity", "torque", "condition")
"""Quantities that are reported by name."""

OF_COORDINATES = (*OF_JOINTS, "velocity_mismatch", "acceleration_mismatch")
"""Quantities whose names are those of coordinates."""


def quantity(name: str) -> Quantity:
    """Return a quantity by name."""
    return _BY_NAME[name]

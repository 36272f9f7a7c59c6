"""Figures that pages show, by the table that they are in: ``figures.csv``."""

from dataclasses import dataclass

from plantigrade.data_files import csv_rows


@dataclass(frozen=True)
class Shown:
    """How a figure is shown."""

    table: str  #: Table that it is in
    label: str  #: Words for it
    unit: str  #: Unit
    key: str  #: Its key in ``metrics.json``, ``{}`` for the side
    digits: int = 1  #: Decimals
    factor: float = 1.0  #: Ratio of the unit shown to that of the key

    @property
    def sided(self) -> bool:
        """Whether the figure exists for both sides."""
        return "{}" in self.key


SHOWN_FIGURES = csv_rows("plantigrade.pages", "figures.csv", Shown)


def shown_in(table: str) -> tuple[Shown, ...]:
    """Return the figures of a table in order."""
    return tuple(one for one in SHOWN_FIGURES if one.table == table)

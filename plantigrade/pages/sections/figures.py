"""Figures of a run in groups with readable names, except those of other sections."""

from dataclasses import dataclass

from plantigrade.constants import SIDES
from plantigrade.data_files import csv_rows
from plantigrade.pages.section import Group, Section, Subject
from plantigrade.pages.text import rounded_text


@dataclass(frozen=True)
class Shown:
    """Display of a figure; ``key`` has ``{}`` for the side."""

    group: str
    label: str
    unit: str
    key: str
    digits: int = 1
    factor: float = 1.0

    @property
    def sided(self) -> bool:
        """Whether the figure exists for both sides."""
        return "{}" in self.key

    def text(self, subject: Subject, side: str = "") -> str:
        """Return the text of the value; a dash if it is unknown."""
        value = subject.number(self.key.format(side))
        return rounded_text(None if value is None else self.factor * value, self.digits)


GROUPS: dict[str, list[Shown]] = {}
for _shown in csv_rows("plantigrade.pages.sections", "figures.csv", Shown):
    GROUPS.setdefault(_shown.group, []).append(_shown)


def figure_section(subject: Subject) -> list[Section]:
    """Return the known figures of the run in groups."""
    groups = [group for title, shown in GROUPS.items() for group in _group(subject, title, shown)]
    return [Section("Other figures", groups=groups, folded=True)] if groups else []


def _group(subject: Subject, title: str, shown: list[Shown]) -> list[Group]:
    sides = SIDES if shown[0].sided else ("",)
    known = [one for one in shown if any(one.text(subject, side) != "–" for side in sides)]
    if not shown[0].sided:
        rows = [[f.label, f"{f.text(subject)} {f.unit}".strip()] for f in known]
        return [Group(title, (), rows)] if rows else []
    rows = [[f.label, *(f.text(subject, side) for side in sides), f.unit] for f in known]
    headers = ("", "right", "left", "unit")
    return [Group(title, headers, rows)] if rows else []

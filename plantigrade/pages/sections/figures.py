"""Figures of a run in groups with readable names, except those of other sections."""

from plantigrade.constants import SIDES
from plantigrade.pages.section import Group, ReportedRun, Section
from plantigrade.pages.shown import SHOWN_FIGURES, Shown, shown_in
from plantigrade.pages.text import rounded_text

OTHER_PREFIX = "other: "
"""Beginning of the names of the tables of this section."""
TITLES = tuple(
    dict.fromkeys(one.table for one in SHOWN_FIGURES if one.table.startswith(OTHER_PREFIX))
)


def figure_section(subject: ReportedRun) -> list[Section]:
    """Return the known figures of the run in groups."""
    groups = [group for table in TITLES for group in _group(subject, table)]
    return [Section("Other figures", groups=groups, folded=True)] if groups else []


def _text(subject: ReportedRun, one: Shown, side: str = "") -> str:
    """Return the text of a value; a dash if it is unknown."""
    value = subject.number(one.key.format(side))
    return rounded_text(None if value is None else one.factor * value, one.digits)


def _group(subject: ReportedRun, table: str) -> list[Group]:
    shown, title = shown_in(table), table.removeprefix(OTHER_PREFIX)
    sides = SIDES if shown[0].sided else ("",)
    known = [one for one in shown if any(_text(subject, one, side) != "–" for side in sides)]
    if not shown[0].sided:
        rows = [[f.label, f"{_text(subject, f)} {f.unit}".strip()] for f in known]
        return [Group(title, (), rows)] if rows else []
    rows = [[f.label, *(_text(subject, f, side) for side in sides), f.unit] for f in known]
    headers = ("", "right", "left", "unit")
    return [Group(title, headers, rows)] if rows else []

"""The result of an experiment: a table with a goal beside each figure."""

import math
import re
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.errors import ParameterError, PlantigradeError
from plantigrade.pages.section import Section

_SUFFIXES = {"%": "pct", "ms/frame": "ms_per_frame", "% of body weight": "bw_percent"}


@dataclass(frozen=True)
class Row:
    """One figure.

    Attributes:
        subject: What it was measured on.
        quantity: What was measured.
        value: The figure; None where it could not be measured.
        unit: Its unit.
        goal: What it is held against (``"<= 10"``); empty where there is no goal.
        met: Whether the goal is met; None where there is no goal.
        note: Why a figure is missing, or anything a reader should know.
    """

    subject: str
    quantity: str
    value: float | None
    unit: str = ""
    goal: str = ""
    met: bool | None = None
    note: str = ""

    @property
    def key(self) -> str:
        """Its name among flat figures: snake_case, the unit as suffix."""
        words = f"{self.subject} {self.quantity} {_SUFFIXES.get(self.unit, self.unit)}"
        words = re.sub(r"(?<!\S)\+(?=\d)", "plus ", re.sub(r"(?<!\S)-(?=\d)", "minus ", words))
        return re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_")


@dataclass(frozen=True)
class ResultTable:
    """A titled list of rows.

    Attributes:
        title: What the table shows.
        rows: The figures.
        notes: Sentences under the table.
        sheets: Wide tables (:func:`sheet`) that show the figures in a form of their own; of the
            rows then only those short of their goal are printed.
        figures: Further figures, which :meth:`metrics` returns beside the rows.
    """

    title: str
    rows: Sequence[Row]
    notes: Sequence[str] = field(default_factory=tuple)
    sheets: Sequence[str] = field(default_factory=tuple)
    figures: Mapping[str, Any] = field(default_factory=dict)

    def metrics(self) -> dict[str, Any]:
        """Return the rows as flat figures and a status."""
        flat: dict[str, Any] = {"status": "ok", **self.figures}
        for row in self.rows:
            flat[row.key] = row.value
        judged = [row for row in self.rows if row.met is not None]
        flat["goals"] = len(judged)
        flat["goals_met"] = sum(bool(row.met) for row in judged)
        return flat

    def text(self) -> str:
        """Return the table for a reader."""
        cells = [("", "figure", "ours", "goal", "")]
        last = None
        for r in self.rows:
            if self.sheets and r.met is not False:
                continue
            value = "-" if r.value is None else f"{r.value:.4g}"
            mark = "" if r.met is None else ("ok" if r.met else "SHORT")
            subject, last = "" if r.subject == last else r.subject, r.subject
            figure, note = f"{value} {r.unit}".strip(), f"{mark} {r.note}".strip()
            cells.append((subject, r.quantity, figure, r.goal, note))
        widths = [max(len(c[i]) for c in cells) for i in range(5)]
        lines = [self.title, ""]
        for wide in self.sheets:
            lines += [wide, ""]
        if self.sheets and len(cells) > 1:
            lines.append("Short of their goals:")
        for c in cells if len(cells) > 1 or not self.sheets else ():
            lines.append("  ".join(c[i].ljust(widths[i]) for i in range(5)).rstrip())
        judged = [row for row in self.rows if row.met is not None]
        met = sum(bool(row.met) for row in judged)
        if judged:
            lines += [*([""] if lines[-1] else []), f"{met} of {len(judged)} goals met"]
        elif not lines[-1]:
            lines.pop()
        return "\n".join([*lines, *self.notes])


def sheet(title: str, header: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    """Return a wide table as text: the first column to the left, all others to the right.

    Example:
        >>> print(sheet("Heights", ("who", "m"), [("Ann", "1.7"), ("Bo", "12.0")]))
        Heights
        who     m
        Ann   1.7
        Bo   12.0
    """
    cells = [tuple(header), *(tuple(line) for line in lines)]
    widths = [max(len(c[i]) for c in cells) for i in range(len(header))]
    text = [title]
    for c in cells:
        right = (c[i].rjust(widths[i]) for i in range(1, len(header)))
        text.append("  ".join([c[0].ljust(widths[0]), *right]).rstrip())
    return "\n".join(text)


@dataclass(frozen=True)
class Grid:
    """A wide table, for the terminal and for the page."""

    title: str
    header: Sequence[str]
    lines: Sequence[Sequence[str]]

    def text(self) -> str:
        """Return it as text."""
        return sheet(self.title, self.header, self.lines)

    def section(self) -> Section:
        """Return it as a section of a page."""
        return Section(self.title, headers=tuple(self.header), rows=[list(x) for x in self.lines])


def pivots(title: str, rows: Iterable[Row]) -> list[Grid]:
    """Return rows as wide tables: one for all subjects that share their quantities.

    Subjects or quantities, whichever are fewer, are the columns. A value that misses its goal has
    an exclamation mark.
    """
    groups: list[dict[str, dict[str, Row]]] = []  # subject → quantity → row
    by_name: dict[str, dict[str, Row]] = {}
    for r in rows:
        by_name.setdefault(r.subject, {})[f"{r.quantity} [{r.unit}]".removesuffix(" []")] = r
    for subject, own in by_name.items():
        for group in groups:
            shared = max(group.values(), key=len)
            if own.keys() <= shared.keys() or shared.keys() <= own.keys():
                group[subject] = own
                break
        else:
            groups.append({subject: own})
    return [_pivot(title, group) for group in groups]


def _pivot(title: str, group: Mapping[str, Mapping[str, Row]]) -> Grid:
    quantities = list(max(group.values(), key=len))

    def cell(subject: str, quantity: str) -> str:
        r = group[subject].get(quantity)
        return "" if r is None else text_of(r.value, None) + ("!" if r.met is False else "")

    if len(group) > len(quantities):
        lines = [[s, *(cell(s, q) for q in quantities)] for s in group]
        return Grid(title, ("", *quantities), lines)
    lines = []
    for q in quantities:
        goals = {own[q].goal for own in group.values() if q in own} - {""}
        lines.append([q, *(cell(s, q) for s in group), ", ".join(sorted(goals))])
    return Grid(title, ("", *group, "goal"), lines)


def sheets_of(
    title: str, rows: Iterable[Row], quantities: Container[str] | None = None
) -> list[str]:
    """Return rows, or those of some quantities, as wide tables in text."""
    some = (r for r in rows if quantities is None or r.quantity in quantities)
    return [grid.text() for grid in pivots(title, some)]


def mean_rows(subject: str, rows: Iterable[Row]) -> list[Row]:
    """Return the mean of each quantity over the subjects that have it."""
    found: dict[tuple[str, str], list[float]] = {}
    for row in rows:
        if row.value is not None:
            found.setdefault((row.quantity, row.unit), []).append(row.value)
    return [
        Row(subject, quantity, float(np.mean(own)), unit, note=f"{len(own)} walks")
        for (quantity, unit), own in found.items()
    ]


def at_most(
    subject: str, quantity: str, value: float, limit: float | None, unit: str = "", note: str = ""
) -> Row:
    """Return a row whose figure should not exceed ``limit``; without a limit it has no goal."""
    goal, met = ("", None) if limit is None else (f"<= {limit:g}", bool(value <= limit))
    return Row(subject, quantity, value, unit, goal, met, note)


def at_least(
    subject: str, quantity: str, value: float, limit: float | None, unit: str = "", note: str = ""
) -> Row:
    """Return a row whose figure should reach ``limit``; without a limit it has no goal."""
    goal, met = ("", None) if limit is None else (f">= {limit:g}", bool(value >= limit))
    return Row(subject, quantity, value, unit, goal, met, note)


def equal(
    subject: str, quantity: str, value: float, goal: float | None, unit: str = "", note: str = ""
) -> Row:
    """Return a row whose figure should be ``goal``; without one it has no goal."""
    met = None if goal is None else bool(value == goal)
    return Row(subject, quantity, value, unit, "" if goal is None else f"= {goal:g}", met, note)


def between(
    subject: str, quantity: str, value: float, low: float, high: float, unit: str = ""
) -> Row:
    """Return a row whose figure should lie in a range."""
    return Row(subject, quantity, value, unit, f"{low:g} to {high:g}", bool(low <= value <= high))


def within(subject: str, quantity: str, value: float, limit: float | None, unit: str = "") -> Row:
    """Return a row whose magnitude should not exceed ``limit``; without one it has no goal."""
    row = at_most(subject, quantity, abs(value), limit, unit)
    return replace(row, value=value)


def by_subject(rows: Iterable[Row], quantities: Container[str]) -> dict[str, dict[str, float]]:
    """Return the known values of some quantities: subject → quantity → value."""
    found: dict[str, dict[str, float]] = {}
    for row in rows:
        if row.quantity in quantities and row.value is not None:
            found.setdefault(row.subject, {})[row.quantity] = float(row.value)
    return found


def text_of(value: float | None, digits: int | None = 1, missing: str = "-") -> str:
    """Return a number with some digits behind the point, four in all if None.

    Unknown numbers are replaced by ``missing``.
    """
    if value is None or not math.isfinite(value):
        return missing
    return f"{value:.4g}" if digits is None else f"{value:.{digits}f}"


def over_trials(
    title: str,
    data: Path,
    names: Sequence[str],
    trial_rows: Callable[[Path, str], Iterable[Row]],
    *,
    say: Callable[[str], None] = lambda _: None,
    notes: Sequence[str] = (),
) -> ResultTable:
    """Return the table over those trials of a data folder that are there.

    ``names`` are paths below the folder; ``trial_rows`` takes the path and the name of a trial.

    Raises:
        ParameterError: If none of them is there.
    """
    rows: list[Row] = []
    notes = list(notes)
    for name in names:
        path = data / name
        if not path.exists():
            notes.append(f"{name} is not there and was left out.")
            continue
        try:
            rows += trial_rows(path, name)
            say(f"{name} done")
        except PlantigradeError as error:
            rows.append(Row(name, "fit", None, note=str(error), met=False))
    if not rows:
        raise ParameterError(
            f"{data} holds none of the trials of this experiment ({', '.join(names)})"
        )
    return ResultTable(title, rows, notes)

"""What an experiment returns: a table with the goal beside each figure."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from plantigrade.errors import ParameterError, PlantigradeError

_UNIT_WORDS = {"%": "pct", "ms/frame": "ms_per_frame"}  # as a suffix of a key


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


@dataclass(frozen=True)
class ResultTable:
    """A titled list of rows.

    Attributes:
        title: What the table shows.
        rows: The figures.
        notes: Sentences under the table.
    """

    title: str
    rows: Sequence[Row]
    notes: Sequence[str] = field(default_factory=tuple)

    def metrics(self) -> dict[str, Any]:
        """Return the rows as flat figures and a status."""
        flat: dict[str, Any] = {"status": "ok"}
        for row in self.rows:
            words = f"{row.subject} {row.quantity} {_UNIT_WORDS.get(row.unit, row.unit)}"
            flat[re.sub(r"[^a-z0-9]+", "_", words.lower()).strip("_")] = row.value
        judged = [row for row in self.rows if row.met is not None]
        flat["goals"] = len(judged)
        flat["goals_met"] = sum(bool(row.met) for row in judged)
        return flat

    def text(self) -> str:
        """Return the table for a reader."""
        cells = [("", "figure", "ours", "goal", "")]
        last = None
        for r in self.rows:
            value = "-" if r.value is None else f"{r.value:.4g}"
            mark = "" if r.met is None else ("ok" if r.met else "SHORT")
            cells.append(
                (
                    r.subject if r.subject != last else "",
                    r.quantity,
                    f"{value} {r.unit}".strip(),
                    r.goal,
                    f"{mark} {r.note}".strip(),
                )
            )
            last = r.subject
        widths = [max(len(c[i]) for c in cells) for i in range(5)]
        lines = [self.title, ""]
        for c in cells:
            lines.append("  ".join(c[i].ljust(widths[i]) for i in range(5)).rstrip())
        judged = [row for row in self.rows if row.met is not None]
        met = sum(bool(row.met) for row in judged)
        return "\n".join([*lines, "", f"{met} of {len(judged)} goals met", *self.notes])


def at_most(subject: str, quantity: str, value: float, limit: float, unit: str = "") -> Row:
    """Return a row whose figure should not exceed ``limit``."""
    return Row(subject, quantity, value, unit, f"<= {limit:g}", bool(value <= limit))


def at_least(subject: str, quantity: str, value: float, limit: float, unit: str = "") -> Row:
    """Return a row whose figure should reach ``limit``."""
    return Row(subject, quantity, value, unit, f">= {limit:g}", bool(value >= limit))


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

    Args:
        title: What the table shows.
        data: The folder.
        names: Paths of the trials below it.
        trial_rows: Called with the path and the name of a trial; returns its rows.
        say: Called with one line per trial as it is done.
        notes: Sentences under the table.

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

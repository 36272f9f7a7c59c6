"""``table.html`` and ``table.csv`` of a batch of simulations: one line each."""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from plantigrade.printable import cell
from plantigrade.record import Run
from plantigrade.report.section import Section, page_html
from plantigrade.report.text import rounded_text

PAGE, TABLE = "table.html", "table.csv"
COLUMNS = (
    ("fell at [s]", "fell_at_s", 2),
    ("diverged at [s]", "diverged_at_s", 2),
    ("duration [s]", "duration_s", 2),
    ("peak force [BW]", "vertical_force_max_bw", 2),
    ("peak motor torque [%]", "motor_torque_max_pct", 0),
    ("tracking error [°]", "tracking_error_rms_deg", 1),
)
"""Heading, figure and decimals of each column of numbers."""


@dataclass(frozen=True, eq=False)
class Simulated:
    """One simulation of a batch.

    Attributes:
        name: Its name, and that of its folder.
        varied: What it had of its own.
        metrics: Its figures, as in ``metrics.json``; empty where it failed.
        problem: Why it failed; empty where it did not.
        run: The run; None where it failed, or lies in a folder.
    """

    name: str
    varied: Mapping[str, Any]
    metrics: Mapping[str, Any] = field(default_factory=dict)
    problem: str = ""
    run: Run | None = None

    @property
    def status(self) -> str:
        """``"ok"``, how it ended, or why it failed."""
        return self.problem or str(self.metrics.get("status", ""))

    def row(self) -> dict[str, Any]:
        """Return its line of the table; what is not known is None."""
        figures = {key: self.metrics.get(key) for _, key, _ in COLUMNS}
        ended = {"status": self.status, "on_feet": self.metrics.get("on_feet")}
        return {"name": self.name, **self.varied, **ended, **figures}


def table_csv(members: Sequence[Simulated]) -> str:
    """Return the table as CSV; what is not known is empty."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    rows = [one.row() for one in members]
    writer.writerow(rows[0])
    for row in rows:
        writer.writerow(["" if value is None else cell(value) for value in row.values()])
    return stream.getvalue()


def table_html(
    members: Sequence[Simulated], *, status: str, provenance: Mapping[str, Any], title: str
) -> str:
    """Return the page of a batch as one text without any outside address."""
    shown = [c for c in COLUMNS if any(one.metrics.get(c[1]) is not None for one in members)]
    own = list(members[0].varied)
    rows = []
    for one in members:
        figures = [rounded_text(one.metrics.get(key), digits) for _, key, digits in shown]
        rows.append([one.name, *(str(one.varied[k]) for k in own), one.status, *figures])
    held = sum(bool(one.metrics.get("on_feet")) for one in members)
    text = (
        "Each simulation has a folder of its name; plantigrade report FOLDER writes its report "
        "and its viewer. The same table with all digits is table.csv."
    )
    headers = ("simulation", *own, "status", *(label for label, _, _ in shown))
    return page_html(
        [
            *_by_value(members, own),
            Section("One by one", headers=headers, rows=rows, text=text),
        ],
        provenance=provenance,
        title=title,
        sentence=f"{held} of {len(members)} on their feet at the end.",
        status=status,
        left_out=[(one.name, one.problem) for one in members if one.problem],
        key=(),
        footer="",
    )


def _by_value(members: Sequence[Simulated], own: Sequence[str]) -> list[Section]:
    """Return how many stayed on their feet for each value of what varies."""
    rows = []
    for name in own:
        values = list(dict.fromkeys(str(one.varied[name]) for one in members))
        if not 1 < len(values) < len(members):
            continue
        for value in values:
            those = [one for one in members if str(one.varied[name]) == value]
            held = sum(bool(one.metrics.get("on_feet")) for one in those)
            rows.append([name, value, f"{held} of {len(those)}"])
    headers = ("", "value", "on their feet at the end")
    return [Section("By varied option", headers=headers, rows=rows)] if rows else []

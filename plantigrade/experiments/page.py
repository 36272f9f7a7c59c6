"""The page of an experiment: its tables and pictures as one HTML file."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plantigrade.experiments.table import ResultTable, sheet

if TYPE_CHECKING:
    from plantigrade.report.sections import Section


@dataclass(frozen=True)
class Grid:
    """A wide table, for the terminal and for the page.

    Attributes:
        title: What it shows.
        header: Of its columns.
        lines: Its rows.
    """

    title: str
    header: Sequence[str]
    lines: Sequence[Sequence[str]]

    def text(self) -> str:
        """Return it as text."""
        return sheet(self.title, self.header, self.lines)

    def section(self) -> "Section":
        """Return it as a section of a page."""
        from plantigrade.report.sections import Section

        return Section(self.title, headers=tuple(self.header), rows=[list(x) for x in self.lines])


def goals_section(table: ResultTable) -> "Section":
    """Return every figure that has a goal."""
    from plantigrade.report.sections import Section

    rows = [
        [
            r.subject,
            r.quantity,
            "–" if r.value is None else f"{r.value:.4g} {r.unit}".strip(),
            r.goal,
            "met" if r.met else "short",
        ]
        for r in sorted(table.rows, key=lambda r: r.met is not False)
        if r.met is not None
    ]
    return Section("Goals", headers=("", "figure", "ours", "goal", ""), rows=rows)


def write_page(
    path: Path,
    table: ResultTable,
    sections: Sequence["Section"],
    *,
    left_out: Mapping[str, str] | None = None,
    provenance: Mapping[str, Any] | None = None,
) -> None:
    """Write the page of an experiment: no outside address is in it.

    Args:
        path: The file.
        table: The result; its notes stand on top.
        sections: Tables and pictures.
        left_out: What could not be made → why.
        provenance: Where it came from.
    """
    from jinja2 import Environment
    from markupsafe import Markup

    from plantigrade.report.report import anchor, metric_rows, provenance_rows
    from plantigrade.report.viewer import template_text

    judged = [r for r in table.rows if r.met is not None]
    template = Environment(autoescape=True, trim_blocks=True, lstrip_blocks=True).from_string(
        template_text("study.html")
    )
    page = template.render(
        title=table.title,
        sentence=" ".join(filter(None, table.notes)),
        status="ok",
        css=Markup(template_text("report.css")),
        facts={"goals met": f"{sum(bool(r.met) for r in judged)} of {len(judged)}"},
        sections=[*sections, goals_section(table)],
        left_out=list((left_out or {}).items()),
        markup=Markup,
        metrics=metric_rows(table.metrics()),
        provenance=provenance_rows(dict(provenance or {})),
        anchor=anchor,
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page, encoding="utf-8")

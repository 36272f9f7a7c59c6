"""The page of an experiment: its tables and pictures as one HTML file."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from experiments.kept_results import KeptResults
from experiments.synthesis_trial import failures
from experiments.table import ResultTable, sheet
from plantigrade.pages.section import Section, page_html


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


def goals_section(table: ResultTable) -> Section:
    """Return every figure that has a goal."""
    rows = []
    for r in sorted((r for r in table.rows if r.met is not None), key=lambda r: bool(r.met)):
        figure = "–" if r.value is None else f"{r.value:.4g} {r.unit}".strip()
        rows.append([r.subject, r.quantity, figure, r.goal, "met" if r.met else "short"])
    return Section("Goals", headers=("", "figure", "ours", "goal", ""), rows=rows)


def write_page(
    path: Path, table: ResultTable, sections: Sequence[Section], kept: KeptResults
) -> None:
    """Write the page of an experiment: its notes, tables and pictures, what failed, all goals."""
    judged = [r for r in table.rows if r.met is not None]
    page = page_html(
        [*sections, goals_section(table)],
        provenance=kept.provenance(),
        title=table.title,
        sentence=" ".join(filter(None, table.notes)),
        status="ok",
        facts={"goals met": f"{sum(bool(r.met) for r in judged)} of {len(judged)}"},
        footer="Angles in degrees.",
        left_out=list(failures(kept.results).items()),
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page, encoding="utf-8")
    kept.say(f"{path}")

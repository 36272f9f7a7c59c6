"""Specification of an experiment of many cases: parts, cached results, figures, tables, page."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.cached_results import CachedResults, Cases, Result
from experiments.table import Grid, ResultTable, Row, pivots
from plantigrade.errors import FileError, ParameterError
from plantigrade.pages.section import Section, page_html

Part = Callable[[bool], Cases]
"""Returns the cases of a part, given whether the short form is meant."""


def default_summary(result: Result) -> str:
    """Return one line about a result: a force, or whether somebody stayed on the feet."""
    if "force" in result:
        return f"{result['force']:g} N"
    return "upright" if result["stood"] else f"fell after {result['time']:.2f} s"


@dataclass(frozen=True, kw_only=True)
class Specification:
    """Measurements and their display; :meth:`run` is the function ``run`` of its module.

    Attributes:
        name: Name of the experiment, and of its files.
        title: Title of its table.
        parts: Name of a part → its cases.
        default_parts: Parts that run if none is named; all if empty.
        quick_parts: The same for the short form; as in the long one if empty.
        summary: Returns one line about a result.
        rows: Returns the figures of the results; :func:`~experiments.table.pivots` prints them.
        grids: Returns further wide tables.
        notes: Sentences under the table.
        remarks: Returns further sentences about the results.
        pictures: Returns further sections of the page.
    """

    name: str
    title: str
    parts: Mapping[str, Part]
    default_parts: tuple[str, ...] = ()
    quick_parts: tuple[str, ...] = ()
    summary: Callable[[Result], str] = default_summary
    rows: Callable[[CachedResults], Iterable[Row]]
    grids: Callable[[CachedResults], Iterable[Grid]] = lambda _: ()
    notes: Sequence[str] = ()
    remarks: Callable[[CachedResults], Iterable[str]] = lambda _: ()
    pictures: Callable[[CachedResults], Iterable[Section]] = lambda _: ()

    @property
    def page(self) -> str:
        """File name of its page."""
        return f"{self.name}.html"

    @property
    def file(self) -> str:
        """File name of its cached results."""
        return f"{self.name}.json"

    def run(
        self,
        *,
        parts: Sequence[str] = (),
        quick: bool = False,
        out: Path | None = None,
        overwrite: bool = False,
        jobs: int = 1,
        say: Callable[[str], None] = lambda _: None,
    ) -> ResultTable:
        """Compute the missing results; return the table of all results in the folder.

        Args:
            parts: Names of :attr:`parts`.
            quick: Whether to run the short form.
            out: Folder for the cached results and the page.
            overwrite: Whether to discard the results in the folder.
            jobs: Number of cases that are computed at once; -1 for one per core.
            say: Called with one line for each result.

        Raises:
            ParameterError: If there is no such part, or no case could be measured.
            FileError: If earlier code wrote the cached results in a form that cannot be displayed.
        """
        path = None if out is None else out / self.file
        cached = CachedResults(path, say, overwrite=overwrite)
        default = (quick and self.quick_parts) or self.default_parts or tuple(self.parts)
        cases: dict = {}
        for part in chosen_parts(parts, self.parts, default):
            cases |= self.parts[part](quick)
        try:
            self.tables(cached)  # before hours are spent
        except (KeyError, ValueError) as error:
            if path is None or not cached.notes():
                raise
            raise FileError(
                path,
                f"holds results of other code, of another form ({error!r})",
                remedy="use --overwrite to measure again",
            ) from error
        cached.get_all(cases, self._summary, jobs=jobs)
        table, sections = self.tables(cached)
        if out is not None:
            write_page(out / self.page, table, sections, cached)
        failed = [cached.results[key].get("error") for key in cases]
        if failed and all(failed):
            raise ParameterError(f"none of {len(failed)} cases could be measured: {failed[0]}")
        return table

    def tables(self, cached: CachedResults) -> tuple[ResultTable, list[Section]]:
        """Return the table of the results, and the sections of the page."""
        rows = list(self.rows(cached))
        grids = [g for g in (*pivots("Figures", rows), *self.grids(cached)) if g.lines]
        failed = [f"{key}: {r['error']}" for key, r in cached.results.items() if "error" in r]
        notes = [*self.notes, *failed, *self.remarks(cached), *cached.notes()]
        table = ResultTable(self.title, rows, notes, [grid.text() for grid in grids])
        return table, [*(grid.section() for grid in grids), *self.pictures(cached)]

    def _summary(self, result: Result) -> str:
        return str(result["error"]) if "error" in result else self.summary(result)


def runs_on(make: Callable[[Any], Specification]) -> Callable[..., ResultTable]:
    """Return the function ``run`` of a module whose experiment is about a folder of recordings.

    Args:
        make: Returns the experiment for a folder, or for None where it does without.
    """

    def run(data: Path | None = None, **options: Any) -> ResultTable:
        """Measure on a folder of recordings; see :meth:`Specification.run`."""
        return make(data).run(**options)

    return run


def chosen_parts(
    parts: Sequence[str], known: Collection[str], default: Collection[str]
) -> Collection[str]:
    """Return the named parts, or the default ones if none is named.

    Raises:
        ParameterError: If there is no such part.
    """
    for part in parts:
        if part not in known:
            raise ParameterError(f"no part {part!r}; there are {', '.join(known)}")
    return parts or default


def gap_remarks(cached: CachedResults) -> list[str]:
    """Return a sentence for each push limit below which a lighter push was not withstood."""
    return [
        f"Not monotone: {key} holds {result['force']:g} N and fails at "
        f"{', '.join(f'{force:g}' for force in result['gaps'])} N."
        for key, result in cached.results.items()
        if result.get("gaps")
    ]


def goals_section(table: ResultTable) -> Section:
    """Return every figure that has a goal, missed goals first."""
    rows = []
    for r in sorted((r for r in table.rows if r.met is not None), key=lambda r: bool(r.met)):
        figure = "–" if r.value is None else f"{r.value:.4g} {r.unit}".strip()
        rows.append([r.subject, r.quantity, figure, r.goal, "met" if r.met else "short"])
    return Section("Goals", headers=("", "figure", "ours", "goal", ""), rows=rows)


def write_page(
    path: Path, table: ResultTable, sections: Sequence[Section], cached: CachedResults
) -> None:
    """Write the page of an experiment: its notes, tables and pictures, and all goals."""
    judged = [r for r in table.rows if r.met is not None]
    page = page_html(
        [*sections, goals_section(table)],
        provenance=cached.provenance(),
        title=table.title,
        sentence=" ".join(filter(None, table.notes)),
        status="ok",
        facts={"goals met": f"{sum(bool(r.met) for r in judged)} of {len(judged)}"},
        footer="Angles in degrees.",
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(page, encoding="utf-8")
    cached.say(f"{path}")

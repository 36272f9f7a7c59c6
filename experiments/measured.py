"""An experiment of many cases whose results are kept: measured by parts, a table and a page."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.kept_results import KeptResults, Result
from experiments.page import Grid, write_page
from experiments.synthesis_trial import chosen_parts
from experiments.table import ResultTable, Row
from plantigrade.errors import FileError, ParameterError
from plantigrade.pages.section import Section

Cases = Mapping[str, Callable[[], dict[str, Any]]]
"""Key of a result → what makes it."""


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What is measured, and how it is shown; the function ``run`` of its module is :meth:`run`.

    Attributes:
        name: Of the experiment, and of its files.
        title: Of its table.
        parts: Name of a part → its cases, given whether the form is the short one.
        usual: Parts that are done where none are named; all if empty.
        shortly: Likewise in the short form; as in the long one if empty.
        brief: One result in a line.
        grids: The wide tables of what is there.
        rows: The figures of what is there.
        notes: Sentences under the table.
        remarks: Further sentences that follow from results.
        pictures: Further sections of the page.
    """

    name: str
    title: str
    parts: Mapping[str, Callable[[bool], Cases]]
    usual: tuple[str, ...] = ()
    shortly: tuple[str, ...] = ()
    brief: Callable[[Result], str]
    grids: Callable[[KeptResults], Iterable[Grid]]
    rows: Callable[[KeptResults], Iterable[Row]]
    notes: Sequence[str] = ()
    remarks: Callable[[KeptResults], Iterable[str]] = lambda _: ()
    pictures: Callable[[KeptResults], Iterable[Section]] = lambda _: ()

    @property
    def page(self) -> str:
        """Name of the file of its page."""
        return f"{self.name}.html"

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
        """Measure what is not kept yet; return the table of it and of all measured before.

        Args:
            parts: Names of :attr:`parts`.
            quick: The short form.
            out: Folder to keep results in and to write the page to.
            overwrite: Do anew what is there.
            jobs: How many at once; -1 for one per core.
            say: Called with a line for every result.

        Raises:
            ParameterError: If there is no such part, or no case could be measured.
            FileError: If what is kept was made by other code, in a form that cannot be shown.
        """
        path = None if out is None else out / f"{self.name}.json"
        kept = KeptResults(path, say, anew=overwrite)
        usual = (quick and self.shortly) or self.usual or tuple(self.parts)
        cases: dict[str, Callable[[], dict[str, Any]]] = {}
        for part in chosen_parts(parts, self.parts, usual):
            cases |= self.parts[part](quick)
        try:
            self._shown(kept)  # before hours are spent
        except (KeyError, ValueError) as error:
            if path is None or not kept.notes():
                raise
            raise FileError(
                path,
                f"holds results of other code, of another form ({error!r})",
                remedy="use --overwrite to measure again",
            ) from error
        kept.get_all(cases, self._told, jobs=jobs)
        table, sections = self._shown(kept)
        if out is not None:
            write_page(out / self.page, table, sections, kept)
        failed = [kept.results[key].get("error") for key in cases]
        if failed and all(failed):
            raise ParameterError(f"none of {len(failed)} cases could be measured: {failed[0]}")
        return table

    def _shown(self, kept: KeptResults) -> tuple[ResultTable, list[Section]]:
        """Return the table of what is kept, and the sections of its page."""
        grids = [grid for grid in self.grids(kept) if grid.lines]
        failed = [f"{key}: {r['error']}" for key, r in kept.results.items() if "error" in r]
        notes = [*self.notes, *failed, *self.remarks(kept), *kept.notes()]
        sheets = [grid.text() for grid in grids]
        table = ResultTable(self.title, list(self.rows(kept)), notes, sheets)
        return table, [*(grid.section() for grid in grids), *self.pictures(kept)]

    def _told(self, result: Result) -> str:
        return str(result["error"]) if "error" in result else self.brief(result)

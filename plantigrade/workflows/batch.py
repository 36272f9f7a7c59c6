"""Batches: the part that ``fit_many``, ``synthesize_many`` and ``simulate_many`` share.

A batch is computed while it is iterated over; results come as they arrive. In a folder it can be
interrupted and resumed: an item with the same content, settings and version is not computed again
(:mod:`plantigrade.record.batch`).
"""

import contextlib
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

from plantigrade.errors import NothingToFit, ParameterError
from plantigrade.extras import require
from plantigrade.notes import repeated
from plantigrade.options import as_path
from plantigrade.pages.batch import PAGE, BatchKind, page_html_of
from plantigrade.record.batch import BatchFolder, Row
from plantigrade.record.jobs import Done, Workers
from plantigrade.record.metrics import METRICS
from plantigrade.record.provenance import sha256_of
from plantigrade.workflows.batch_items import BatchPace, Item, ItemGroup, ItemResult
from plantigrade.workflows.batch_work import Keep, Kept, Made, Work, made, unpack

ITEMS_AHEAD = 32
"""Items per worker in one round. At its end each worker waits for about half an item, until the
starting points of the next round (the body of a subject, a fit) are computed: below 2 % of 32."""
Begin = Callable[[Any], Any]  #: Computes the starting point of a group


class Concluded(NamedTuple):
    """Pages, figures and printed lines over all items of a batch."""

    pages: Mapping[str, str]
    figures: Mapping[str, Any]
    lines: Sequence[str]


Conclude = Callable[[BatchFolder, Mapping[str, Any]], Concluded]


@dataclass(frozen=True)
class Plan:
    """The parts of a batch."""

    kind: BatchKind  #: Words and columns of its page
    work: Work  #: Computes the run of an item
    #: Returns the groups; it may use the workers to find them
    groups: Callable[[Workers], Iterable[ItemGroup]]
    names: Sequence[str]  #: Names of the items
    spec: Mapping[str, Any]  #: Settings, method and variation; equal for equal batches
    begin: Begin | None = None  #: Computes the starting point of a group
    default: Keep = "pages"  #: What is kept of each item unless an option chooses otherwise
    folders: Sequence[str] = ()  #: Names of further folders in that of the batch
    #: Error classes with which a file that was found, not named, is left out instead of failing
    passes_over: tuple[str, ...] = (NothingToFit.__name__,)
    #: Computes pages and figures over all items, once they have ended
    conclude: Conclude | None = None


@dataclass(frozen=True, kw_only=True)
class BatchSettings:
    """Where a batch is computed, and what is kept of it."""

    out: str | Path | None = None
    """Folder of the batch. What it holds of the same content, settings and version is not computed
    again. Without it the runs come back in memory."""
    overwrite: bool = False
    """Replace a batch that is there."""
    keep: Keep | None = None
    """Files of each item that stay in ``out``: ``"pages"`` (the run with report and viewer),
    ``"runs"`` (the run alone; the default of simulations), or ``"figures"`` (its line of the table
    and its curves)."""
    collect: bool = False
    """Have workers send their runs back: for clusters without a shared disk."""
    jobs: int = 1
    """Number of items computed at once; -1 for one per core."""
    backend: Literal["loky", "ray", "dask"] = "loky"
    """Where they are computed: on this machine (loky), or on a Ray or Dask cluster."""
    address: str | None = None
    """Address of a running cluster (ray, dask)."""
    say: Callable[[str], None] | None = None
    """Called with lines of progress."""

    @classmethod
    def split(cls, options: Mapping[str, Any]) -> tuple["BatchSettings", dict[str, Any]]:
        """Return the settings of the batch among options by name, and all other options."""
        names = {f.name for f in fields(cls)}
        own = {name: value for name, value in options.items() if name in names}
        return cls(**own), {name: x for name, x in options.items() if name not in names}


class Batch(Iterable[ItemResult]):
    """Results of many items, computed while it is iterated over, as they arrive.

    Every other use (``members``, ``status``, ``to_dataframe()``) computes what is left first.

    Raises:
        ParameterError: If settings contradict each other.
        RunExists: If the folder holds anything else.
    """

    def __init__(self, plan: Plan, how: BatchSettings, command: str = ""):
        out, keep, collect = how.out, how.keep, how.collect
        if out is None and (keep is not None or collect):
            raise ParameterError("keep and collect say what is written: name a folder with out")
        if collect and keep == "figures":
            raise ParameterError(
                "collect has no effect with keep figures, which sends no runs back"
            )
        self.folder = None
        self._plan, self._say = plan, how.say or (lambda _: None)
        self._workers = Workers(how.jobs, how.backend, how.address)
        self._kept = Kept(None, keep or plan.default, collect)
        self._store: BatchFolder | None = None
        if out is not None:
            self.folder = as_path(out, "the folder of a batch").expanduser().absolute()
            self._store = BatchFolder(self.folder, plan.spec, command, how.overwrite)
            self._store.announce([*plan.names, *plan.folders])
            self._kept = self._kept._replace(folder=self.folder)
        self.lines: tuple[str, ...] = ()  #: Printed about all items together once they have ended
        self._held: dict[str, ItemResult] = {}
        self._metrics: dict[str, Any] = {}
        self._arriving: Iterator[ItemResult] | None = None
        self._begun = self._ended = False
        self._pace = BatchPace(len(plan.names), self._say)

    def __iter__(self) -> Iterator[ItemResult]:
        """Yield results as they arrive; all of them in order once they have been computed."""
        if self._ended:
            yield from self.members
            return
        self._begun = True
        if self._arriving is None:
            self._arriving = self._computed()
        try:
            for result in self._arriving:  # noqa: UP028 (it resumes where a loop stopped)
                yield result
        except GeneratorExit:
            raise
        except BaseException:
            self._arriving = None  # results are kept; the next loop resumes
            raise

    def __del__(self) -> None:
        """Warn of a batch whose results were never requested: it was not computed."""
        if not getattr(self, "_begun", True):
            warnings.warn(
                "a batch was made but not computed: iterate over it, or call finish()", stacklevel=2
            )

    @property
    def members(self) -> tuple[ItemResult, ...]:
        """Every result, in the order of the items."""
        self.finish()
        if self._store is None:
            return tuple(self._held[name] for name in self._plan.names)
        return tuple(self._from_row(row) for row in self._store.rows())

    @property
    def share(self) -> float:
        """Share of the items that are done [1]."""
        return self._pace.share

    @property
    def metrics(self) -> dict[str, Any]:
        """Status and counts; all of ``metrics.json`` where there is a folder."""
        self.finish()
        return self._metrics

    @property
    def status(self) -> str:
        """``"ok"``, or how many items failed."""
        return str(self.metrics["status"])

    @property
    def sentence(self) -> str:
        """Return one sentence that says what was done."""
        return self._plan.kind.sentence(self.metrics)

    def finish(self) -> None:
        """Compute what is left, and write the tables and the page."""
        for _ in () if self._ended else self:
            pass

    def to_dataframe(self) -> Any:
        """Return the table as a pandas DataFrame, one row an item.

        Raises:
            MissingExtra: If pandas is not installed.
        """
        pandas = require("pandas", "tables")
        return pandas.DataFrame([one.row() for one in self.members]).set_index("name")

    def _computed(self) -> Iterator[ItemResult]:
        pace = self._pace = BatchPace(len(self._plan.names), self._say)
        with self._workers as workers:
            for groups in _rounds(self._left(pace), ITEMS_AHEAD * workers.count):
                yield from self._round(groups, workers, pace)
        self._end(pace)

    def _left(self, pace: "BatchPace") -> Iterator[ItemGroup]:
        """Yield the items of each group that are still to be computed; count the others."""
        before = {} if self._store is None else self._store.before
        of_file = {file: name for name, (file, _) in before.items() if file}
        there = {key: name for name, (_, key) in before.items() if key}
        for group in self._plan.groups(self._workers):
            left = []
            for item in group.items:
                name = there.pop(item.key, "")
                if name and self._store is not None and self._is_kept(name):
                    self._store.place(name, item.number)
                    pace.found += 1
                    continue
                name = of_file.get(str(item.source), "") if not item.varied else ""
                left.append(replace(item, name=name or _free_name(item, before)))
            if left:
                yield replace(group, items=tuple(left))

    def _is_kept(self, name: str) -> bool:
        """Return whether the folder holds all that is to be kept of an item done before."""
        if self._kept.what == "figures" or self.folder is None:
            return True
        last = METRICS if self._kept.what == "runs" else "report.html"
        return all((self.folder / name / file).is_file() for file in (METRICS, last))

    def _round(
        self, groups: Sequence[ItemGroup], workers: Workers, pace: "BatchPace"
    ) -> Iterator[ItemResult]:
        begun: dict[int, Done] = {}
        if self._plan.begin is not None:
            first = [(k, group.begin) for k, group in enumerate(groups) if group.begin is not None]
            for done in workers.run(partial(_second, self._plan.begin), first):
                begun[done.item[0]] = done
        work = partial(made, self._plan.work, self._kept)
        tasks = []
        for k, group in enumerate(groups):
            start = begun.get(k)
            if start is not None and start.problem:
                for item in group.items:
                    yield self._arrived(Done((item, None), None, start.problem), pace)
                continue
            tasks += [(item, start.result if start else group.start) for item in group.items]
        for done in workers.run(work, tasks, ordered=False):
            yield self._arrived(done, pace)

    def _arrived(self, done: Done, pace: "BatchPace") -> ItemResult:
        """Store the result of one item and return it."""
        item: Item = done.item[0]
        made: Made | None = done.result
        file = "" if item.source is None else str(item.source)
        sha256 = ""
        if item.source is not None and item.source.is_file():
            with contextlib.suppress(OSError):
                sha256 = sha256_of(item.source)
        row = Row(
            item.name,
            item.number,
            file,
            item.key,
            status=done.problem,
            failed=True,
            seconds=done.seconds,
            sha256=sha256,
            varied=item.varied,
        )
        curves, run = {}, None
        if not item.named and done.error in self._plan.passes_over:
            row = replace(row, left_out=True)
        if made is not None:
            curves, run = made.curves, made.run
            row = replace(row, status=made.status, failed=False, figures=made.figures,
                          warnings=made.warnings)  # fmt: skip
            if made.archive and self.folder is not None:
                unpack(made.archive, self.folder / item.name)
        result = replace(self._from_row(row), run=run)
        if self._store is None:
            self._held[item.name] = result
        else:
            self._store.add(row, curves)
        pace.ended(result, self._plan.kind)
        return result

    def _from_row(self, row: Row) -> ItemResult:
        folder = None if self.folder is None or row.failed else self.folder / row.name
        if folder is not None and not (folder / METRICS).is_file():
            folder = None
        problem = row.status if row.failed else ""
        source = Path(row.file) if row.file else None
        return ItemResult(row.name, source, row.varied, row.figures, row.status, problem, folder,
                      left_out=row.left_out, warnings=tuple(row.warnings))  # fmt: skip

    def _results(self) -> Iterator[ItemResult]:
        """Yield all results without holding those that are in a folder."""
        if self._store is None:
            return iter(self._held.values())
        return map(self._from_row, self._store.rows())

    def _end(self, pace: "BatchPace") -> None:
        pace.close()
        kind = self._plan.kind
        counts = kind.counts(self._results())
        there = (one for one in self._results() if one.problem and not one.left_out)
        failed = ((one.name, (one.problem,)) for one in there)
        warned = ((one.name, one.warnings) for one in self._results())
        for name, sentences in (("failures", failed), ("warnings", warned)):
            counts[name] = [kind.counted(each, counts) for each in repeated(sentences)]
        self._metrics = counts
        if self._store is not None:
            more = Concluded({}, {}, ())
            if self._plan.conclude is not None:
                more = self._plan.conclude(self._store, counts)
            self.lines = tuple(more.lines)
            pages = {**more.pages, PAGE: page_html_of(kind, self._store, counts)}
            found = {**counts, **more.figures}
            self._metrics = self._store.finish(found, pages, self._plan.folders)
        self._ended = True


def _rounds(groups: Iterable[ItemGroup], count: int) -> Iterator[list[ItemGroup]]:
    """Yield groups together until they have so many items."""
    held: list[ItemGroup] = []
    for group in groups:
        held.append(group)
        if sum(len(each.items) for each in held) >= count:
            yield held
            held = []
    if held:
        yield held


def _free_name(item: Item, before: Mapping[str, tuple[str, str]]) -> str:
    """Return the name of an item; with a number where an item of another file has it.

    A file that is gone makes room for the one that came in its place.
    """
    file, name, n = "" if item.source is None else str(item.source), item.name, 1
    while name in before and (held := before[name][0]) != file and Path(held).exists():
        n += 1
        name = f"{item.name}-{n}"
    return name


def _second(begin: Begin, numbered: tuple[int, Any]) -> Any:
    return begin(numbered[1])

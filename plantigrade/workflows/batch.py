"""Many items, one table: what ``fit_many``, ``synthesize_many``, ``simulate_many`` have in common.

A batch is computed while it is iterated over; results come as they arrive. In a folder it can be
stopped and taken up again: an item that was done with the same content, settings and version is not
done again (:mod:`plantigrade.record.batch`).
"""

import contextlib
import hashlib
import io
import json
import shutil
import tempfile
import time
import warnings
import zipfile
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from plantigrade.analyze.norms import unit_of
from plantigrade.analyze.run_comparison import gait_of
from plantigrade.charts.labels import without_side
from plantigrade.errors import NothingToFit, ParameterError
from plantigrade.extras import require
from plantigrade.options import as_path
from plantigrade.record import Run
from plantigrade.record.batch import BatchFolder, Curve, Row
from plantigrade.record.folder import METRICS, metrics_json, read_metrics
from plantigrade.record.jobs import Done, Workers
from plantigrade.record.provenance import sha256_of
from plantigrade.report.batch import PAGE, BatchKind, page_html_of
from plantigrade.workflows.save import save

Keep = Literal["pages", "runs", "figures"]
"""What is kept of each item in the folder of a batch: its run with report and viewer, its run, or
its line of the table alone."""

ITEMS_AHEAD = 32
"""Items for each worker in one round: workers wait at its end, about half an item each, for what
the next one starts from (the body of a subject, a fit); 32 keep this below 2 %."""
MAX_RETURNED_BYTES = 64 * 2**20
"""Largest result that a worker sends back; Ray and Dask copy it in memory several times."""
MAX_LINES = 200
"""Items up to which each is a line of progress."""
SECONDS_BETWEEN = 5.0
"""Time between two lines of progress of a larger batch [s]."""
MIN_PACE_SECONDS = 10.0
"""Time after which the rest can be estimated [s]."""


@dataclass(frozen=True)
class Item:
    """One item of a batch.

    Attributes:
        name: Its name, and that of its folder in that of the batch.
        number: Its place in the table.
        key: Content hash of all that decides its result.
        what: What the work is done for.
        source: The file it comes from.
        varied: What it has of its own, by option.
        named: Whether it was asked for; an item that was only found is left out if it holds
            nothing to work on.
    """

    name: str
    number: int
    key: str
    what: Any
    source: Path | None = None
    varied: Mapping[str, Any] = field(default_factory=dict)
    named: bool = True


@dataclass(frozen=True)
class Group:
    """Items that start from the same: trials of one subject, simulations of one recording.

    Attributes:
        items: The items.
        begin: What they start from is made from this; None where nothing is to be made.
        start: What they start from, where it was made before.
    """

    items: tuple[Item, ...]
    begin: Any = None
    start: Any = None


@dataclass(frozen=True, eq=False)
class Result:
    """What came of one item.

    Attributes:
        name: Its name, and that of its folder.
        source: The file it comes from; None where there is none.
        varied: What it has of its own, by option.
        figures: Every figure, flat.
        status: ``"ok"``, what is wrong with the result, or why there is none.
        problem: Why there is no result; empty where there is one.
        folder: Its run folder; None where none is kept.
        run: The run; None where it lies in a folder, or there is none.
        left_out: Whether it was found in a folder and holds nothing to work on.
    """

    name: str
    source: Path | None
    varied: Mapping[str, Any]
    figures: Mapping[str, Any]
    status: str
    problem: str = ""
    folder: Path | None = None
    run: Run | None = field(default=None, repr=False)
    left_out: bool = False

    @property
    def ok(self) -> bool:
        """Whether everything that was asked for was reached."""
        return self.status == "ok"

    @property
    def metrics(self) -> Mapping[str, Any]:
        """Everything that ``metrics.json`` of its run holds; its figures where no run is kept."""
        if self.run is not None:
            return self.run.metrics
        return self.figures if self.folder is None else read_metrics(self.folder)

    def load(self) -> Run:
        """Return the run, from its folder if it lies in one.

        Raises:
            ParameterError: If no run was kept.
            FileError: If the folder cannot be read.
        """
        if self.run is not None:
            return self.run
        if self.folder is None:
            raise ParameterError(f"no run of {self.name} was kept: {self.problem or 'keep runs'}")
        return Run.load(self.folder)

    def row(self) -> dict[str, Any]:
        """Return its line of a table."""
        first = {"name": self.name, "file": None if self.source is None else str(self.source)}
        return {**first, "status": self.status, **self.varied, **self.figures}


class Kept(NamedTuple):
    """How results are kept; it travels to where they are computed."""

    folder: Path | None
    what: Keep
    collect: bool


class Made(NamedTuple):
    """What a worker returns of one item."""

    figures: dict[str, Any]
    status: str
    curves: dict[str, Curve]
    run: Run | None = None
    archive: bytes = b""


Work = Callable[[Any, Any], Run]
"""Makes the run of an item: from what it is, and from what its group starts with."""
Begin = Callable[[Any], Any]
"""Makes what a group starts with."""


class Concluded(NamedTuple):
    """What a kind of batch has to say of all its items together."""

    pages: Mapping[str, str]
    figures: Mapping[str, Any]
    lines: Sequence[str]


Conclude = Callable[[BatchFolder, Mapping[str, Any]], Concluded]


@dataclass(frozen=True)
class Plan:
    """What a batch consists of.

    Attributes:
        kind: Of what: words and columns of its page.
        work: Makes the run of an item.
        begin: Makes what a group starts from.
        groups: Returns the groups; it may use the workers to find them.
        names: Names of the items.
        spec: What two batches have in common if they are the same, ``settings`` among them.
        default: What is kept if nothing is said.
        folders: Names of further folders that are made in that of the batch.
        passes_over: Classes of errors of files that were found and not named; such files are left
            out, not failed.
        conclude: Makes further pages, and figures, of a folder in which all items have ended.
    """

    kind: BatchKind
    work: Work
    groups: Callable[[Workers], Iterable[Group]]
    names: Sequence[str]
    spec: Mapping[str, Any]
    begin: Begin | None = None
    default: Keep = "pages"
    folders: Sequence[str] = ()
    passes_over: tuple[str, ...] = (NothingToFit.__name__,)
    conclude: Conclude | None = None


class Batch(Iterable[Result]):
    """Results of many items, computed while it is iterated over, as they arrive.

    Every other use (``members``, ``status``, ``to_dataframe()``) computes what is left first.

    Args:
        plan: What is computed.
        out: Folder of the batch; without it results stay in memory.
        overwrite: Replace a folder of results that is there.
        keep: What is kept of each item in the folder.
        collect: Have workers send their runs back instead of writing them themselves.
        workers: Where it is computed.
        say: Called with a line about items that have ended.
        command: The command line, for the provenance.
    """

    def __init__(
        self,
        plan: Plan,
        *,
        out: str | Path | None,
        overwrite: bool,
        keep: Keep | None,
        collect: bool,
        workers: Workers,
        say: Callable[[str], None],
        command: str,
    ):
        if out is None and (keep is not None or collect):
            raise ParameterError("keep and collect say what is written: name a folder with out")
        self.folder = None
        self._plan, self._workers, self._say = plan, workers, say
        self._kept = Kept(None, keep or plan.default, collect)
        self._store: BatchFolder | None = None
        if out is not None:
            self.folder = as_path(out, "the folder of a batch").expanduser().absolute()
            self._store = BatchFolder(self.folder, plan.spec, command, overwrite)
            self._store.announce([*plan.names, *plan.folders])
            self._kept = self._kept._replace(folder=self.folder)
        self.lines: tuple[str, ...] = ()
        """What is to be printed of all items together, once they have ended."""
        self._held: dict[str, Result] = {}
        self._metrics: dict[str, Any] = {}
        self._arriving: Iterator[Result] | None = None
        self._ended = False

    def __iter__(self) -> Iterator[Result]:
        """Yield results as they arrive; all of them in order once they have been computed."""
        if self._ended:
            yield from self.members
            return
        if self._arriving is None:
            self._arriving = self._computed()
        try:
            for result in self._arriving:  # noqa: UP028 (it goes on where a loop was left)
                yield result
        except GeneratorExit:
            raise
        except BaseException:
            self._arriving = None  # what was done is kept; the next loop begins anew
            raise

    def __del__(self) -> None:
        """Warn of a batch that nobody asked for its results: it was not computed."""
        if getattr(self, "_arriving", self) is None:
            warnings.warn(
                "a batch was made but not computed: iterate over it, or call finish()",
                stacklevel=2,
            )

    @property
    def members(self) -> tuple[Result, ...]:
        """Every result, in the order of the items."""
        self.finish()
        if self._store is None:
            return tuple(self._held[name] for name in self._plan.names)
        return tuple(self._from_row(row) for row in self._store.rows())

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
        """What was done, in one sentence."""
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

    def _computed(self) -> Iterator[Result]:
        pace = _Pace(len(self._plan.names), self._say)
        with self._workers as workers:
            for groups in _rounds(self._left(pace), ITEMS_AHEAD * workers.count):
                yield from self._round(groups, workers, pace)
        self._end(pace)

    def _left(self, pace: "_Pace") -> Iterator[Group]:
        """Yield what is left to do of each group; what is there is counted."""
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
        """Return whether of an item that was done all is there that is to be kept."""
        if self._kept.what == "figures" or self.folder is None:
            return True
        wanted = METRICS if self._kept.what == "runs" else "report.html"
        return (self.folder / name / METRICS).is_file() and (self.folder / name / wanted).is_file()

    def _round(self, groups: Sequence[Group], workers: Workers, pace: "_Pace") -> Iterator[Result]:
        begun: dict[int, Done] = {}
        if self._plan.begin is not None:
            first = [(k, group.begin) for k, group in enumerate(groups) if group.begin is not None]
            for done in workers.run(partial(_second, self._plan.begin), first):
                begun[done.item[0]] = done
        work = partial(_made, self._plan.work, self._kept)
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

    def _arrived(self, done: Done, pace: "_Pace") -> Result:
        """Keep what came of one item and return it."""
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
            row = replace(row, status=made.status, failed=False, figures=made.figures)
            if made.archive and self.folder is not None:
                _unpack(made.archive, self.folder / item.name)
        result = replace(self._from_row(row), run=run)
        if self._store is None:
            self._held[item.name] = result
        else:
            self._store.add(row, curves)
        pace.ended(result, self._plan.kind)
        return result

    def _from_row(self, row: Row) -> Result:
        folder = None if self.folder is None else self.folder / row.name
        if folder is not None and not (folder / METRICS).is_file():
            folder = None
        problem = row.status if row.failed else ""
        source = Path(row.file) if row.file else None
        return Result(row.name, source, row.varied, row.figures, row.status, problem, folder,
                      left_out=row.left_out)  # fmt: skip

    def _end(self, pace: "_Pace") -> None:
        pace.close()
        kind = self._plan.kind
        rows = self._held.values() if self._store is None else map(
            self._from_row, self._store.rows())  # fmt: skip
        counts = kind.counts(rows)
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


class _Pace:
    """Says what has ended, how fast, and how long the rest will take."""

    def __init__(self, count: int, say: Callable[[str], None]):
        self.count, self.say = count, say
        self.done = self.found = self._told = 0
        self._began = self._said = time.perf_counter()

    def ended(self, result: Result, kind: BatchKind) -> None:
        """Count an item that has ended, and say so unless too much is said."""
        self.close()
        self.done += 1
        now, of = time.perf_counter(), self.done + self.found
        if self.count > MAX_LINES and not result.problem and of < self.count:
            if now - self._said < SECONDS_BETWEEN:
                return
        self._said = now
        line = f"{of} of {self.count}: {result.name}: {kind.words(result)}"
        left, passed = self.count - of, now - self._began
        if left and passed > MIN_PACE_SECONDS:
            rate = self.done / passed
            line += f" ({rate:.2g}/s, {_duration(left / rate)} left)"
        self.say(line)

    def close(self) -> None:
        """Say how many items were done before, if that was not said yet."""
        if self.found > self._told:
            self.say(f"{self.found} of {self.count} were there")
            self._told = self.found


def _duration(seconds: float) -> str:
    """Return a time in the units in which people wait.

    Example:
        >>> _duration(42.3), _duration(400), _duration(90_000)
        ('42 s', '7 min', '25 h')
    """
    for most, unit, size in ((100, "s", 1), (6000, "min", 60)):
        if seconds < most:
            return f"{max(round(seconds / size), 1)} {unit}"
    return f"{seconds / 3600:.0f} h"


def _rounds(groups: Iterable[Group], count: int) -> Iterator[list[Group]]:
    """Yield groups together until they have so many items."""
    held: list[Group] = []
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


def _made(work: Work, kept: Kept, task: tuple[Item, Any]) -> Made:
    """Make the run of an item and keep of it what is to be kept."""
    item, start = task
    run = replace(work(item.what, start), name=item.name)
    found = Made(figures_of(run.metrics), run.status, curves_of(run))
    if kept.folder is None:
        return found._replace(run=run)
    if kept.what == "figures":
        return found
    write = save if kept.what == "pages" else Run.save
    if not kept.collect:
        write(run, kept.folder / item.name, overwrite=True)
        return found
    with tempfile.TemporaryDirectory() as place:
        return found._replace(archive=_packed(write(run, Path(place) / item.name)))


def _packed(run: Run) -> bytes:
    """Return a run folder as one archive.

    Raises:
        ParameterError: If it is too large to be sent.
    """
    assert run.folder is not None
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(run.folder.iterdir()):
            archive.write(path, path.name)
    size = stream.tell()
    if size > MAX_RETURNED_BYTES:
        raise ParameterError(
            f"the run has {size / 2**20:.0f} MB, and at most {MAX_RETURNED_BYTES / 2**20:.0f} MB "
            "can be sent back: use --keep figures, or a folder that all workers share"
        )
    return stream.getvalue()


def _unpack(archive: bytes, folder: Path) -> None:
    """Write a run folder that was sent back, whole or not at all."""
    part = Path(tempfile.mkdtemp(prefix=f".{folder.name[:20]}-", suffix=".part", dir=folder.parent))
    try:
        with zipfile.ZipFile(io.BytesIO(archive)) as stream:
            stream.extractall(part)
        shutil.rmtree(folder, ignore_errors=True)
        part.chmod(0o755)
        part.rename(folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)


_NOT_FIGURES = ("status", "format", "version", "kind", "title", "command", "files")


def figures_of(metrics: Mapping[str, Any]) -> dict[str, Any]:
    """Return the figures of a run, flat: numbers, words and booleans; how many warnings it has.

    Example:
        >>> figures_of({"status": "ok", "mass_kg": 70.0, "warnings": ["one"], "gaits": {}})
        {'mass_kg': 70.0, 'warnings_count': 1}
    """
    found: dict[str, Any] = {}
    for name, value in json.loads(metrics_json(metrics)).items():
        if name in _NOT_FIGURES:
            continue
        if name == "warnings":
            found["warnings_count"] = len(value)
        elif isinstance(value, str | int | float | bool):
            found[name] = value
    return found


def curves_of(run: Run) -> dict[str, Curve]:
    """Return the mean curves over the gait cycles of a run; none where it has no whole cycle."""
    try:
        gait = gait_of(run, run.name or run.kind)
    except ParameterError:
        return {}
    found = {}
    for name, rows in gait.curves.items():
        sd = rows.std(axis=0, ddof=1) if len(rows) > 1 else np.full(rows.shape[1], np.nan)
        unit = unit_of(without_side(name))
        found[name] = Curve(unit, len(rows), np.nanmean(rows, axis=0), sd)
    return found


def content_key(*parts: Any) -> str:
    """Return a hash of settings, words and sums of files that together decide a result."""
    return hashlib.sha256(metrics_json({"parts": parts}).encode()).hexdigest()

"""Items of a batch, their results, and how fast they end."""

import hashlib
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from plantigrade.errors import ParameterError
from plantigrade.pages.batch import BatchKind
from plantigrade.record import Run
from plantigrade.record.metrics import metrics_json, read_metrics

MAX_LINES = 200  # Items up to which each is a line of progress
SECONDS_BETWEEN = 5.0  # [s] time between two lines of progress of a larger batch
MIN_PACE_SECONDS = 10.0  # [s] time after which the rest can be estimated


@dataclass(frozen=True)
class Item:
    """One item of a batch."""

    name: str  #: Its name, and that of its folder in that of the batch
    number: int  #: Its place in the table
    key: str  #: Content hash of all that decides its result
    what: Any  #: What the work is done for
    source: Path | None = None  #: The file it comes from
    varied: Mapping[str, Any] = field(default_factory=dict)  #: What it has of its own, by option
    #: Whether it was asked for; an item that was only found is left out if it holds nothing to work
    #: on
    named: bool = True


@dataclass(frozen=True)
class ItemGroup:
    """Items that start from the same: trials of one subject, simulations of one recording."""

    items: tuple[Item, ...]  #: The items
    begin: Any = None  #: What they start from is made from this; None where nothing is to be made
    start: Any = None  #: What they start from, where it was made before


@dataclass(frozen=True, eq=False)
class ItemResult:
    """Result of one item."""

    name: str  #: Its name, and that of its folder
    source: Path | None  #: The file it comes from; None where there is none
    varied: Mapping[str, Any]  #: What it has of its own, by option
    figures: Mapping[str, Any]  #: Every figure, flat
    status: str  #: ``"ok"``, what is wrong with the result, or why there is none
    problem: str = ""  #: Why there is no result; empty where there is one
    folder: Path | None = None  #: Its run folder; None where none is kept
    #: The run; None where it lies in a folder, or there is none
    run: Run | None = field(default=None, repr=False)
    left_out: bool = False  #: Whether it was found in a folder and holds nothing to work on
    warnings: tuple[str, ...] = ()  #: Its warnings, sentences

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


def content_key(*parts: Any) -> str:
    """Return a hash of settings, words and sums of files that together decide a result."""
    return hashlib.sha256(metrics_json({"parts": parts}).encode()).hexdigest()


class BatchPace:
    """Says what has ended, how fast, and how long the rest will take."""

    def __init__(self, count: int, say: Callable[[str], None]):
        self.count, self.say = count, say
        self.done = self.found = self._printed_found = 0
        self._began = self._last_line_time = time.perf_counter()

    def ended(self, result: ItemResult, kind: BatchKind) -> None:
        """Count an item that has ended; print a line, in large batches only now and then."""
        self.close()
        self.done += 1
        now, of = time.perf_counter(), self.done + self.found
        if self.count > MAX_LINES and not result.problem and of < self.count:
            if now - self._last_line_time < SECONDS_BETWEEN:
                return
        self._last_line_time = now
        line = f"{of} of {self.count}: {result.name}: {kind.words(result)}"
        left, passed = self.count - of, now - self._began
        if left and passed > MIN_PACE_SECONDS:
            rate = self.done / passed
            line += f" ({rate:.2g}/s, {_duration(left / rate)} left)"
        self.say(line)

    @property
    def share(self) -> float:
        """Share of the items that have ended [1]."""
        return (self.done + self.found) / max(self.count, 1)

    def close(self) -> None:
        """Print how many items were done before, once."""
        if self.found > self._printed_found:
            self.say(f"{self.found} of {self.count} were there")
            self._printed_found = self.found


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

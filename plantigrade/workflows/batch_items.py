"""Items of a batch and their results."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from plantigrade.errors import ParameterError
from plantigrade.record import Run
from plantigrade.record.metrics import metrics_json, read_metrics


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
class Group:
    """Items that start from the same: trials of one subject, simulations of one recording."""

    items: tuple[Item, ...]  #: The items
    begin: Any = None  #: What they start from is made from this; None where nothing is to be made
    start: Any = None  #: What they start from, where it was made before


@dataclass(frozen=True, eq=False)
class Result:
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

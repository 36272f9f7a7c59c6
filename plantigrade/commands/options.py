"""Options that several commands share; a command is a dataclass that inherits what it needs."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from plantigrade.bounds import Bounded
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError
from plantigrade.options import Flag, OptionalWord, OutPath

if TYPE_CHECKING:
    from plantigrade.commands.progress import Progress
    from plantigrade.record import Run

MAX_SHOWN_PDFS = 5  # PDFs of a batch that are named on the screen; chosen
Backend = Literal["loky", "ray", "dask"]


@dataclass(frozen=True, kw_only=True)
class PrintOptions:
    """Options of printing."""

    quiet: Flag = False
    """Print only warnings and errors: no progress, no information."""
    json: Flag = False
    """Print metrics.json on standard output and everything else on standard error."""


@dataclass(frozen=True, kw_only=True)
class RunOptions(PrintOptions, Bounded):
    """Where the run folder goes."""

    out: OutPath = None
    """Run folder to write; by default runs/<command>-<name>, numbered if taken."""
    overwrite: Flag = False
    """Replace the run folder if it exists."""

    def refuse_existing(self, *names: str) -> None:
        """Refuse, before any work, what could not be written.

        Args:
            names: Folders in ``runs`` that are written where ``--out`` is absent.

        Raises:
            RunExists: If the folder of ``--out``, or one to be replaced, may not be written.
            FileError: If nothing may be written where it is to be.
        """
        from plantigrade.record.folder import refuse_existing, refuse_unwritable
        from plantigrade.record.run import RUNS

        if self.out is not None:
            refuse_existing(self.out, self.overwrite)
        for name in names if self.out is None else ():
            if self.overwrite:
                refuse_existing(RUNS / name, overwrite=True)
            else:
                refuse_unwritable(RUNS / name)

    def written(
        self,
        run: "Run",
        progress: "Progress",
        summary: Callable[[Path, dict[str, Any]], str],
        *warnings: str,
    ) -> Outcome:
        """Write a run with its pages, say what should be known, and return what is printed."""
        from plantigrade.workflows.save import save

        with progress.step("writing the report and the viewer"):
            run = save(run, self.out, overwrite=self.overwrite)
        for sentence in (*run.record.notes, *warnings):
            progress.note(sentence)
        folder = run.folder or Path()
        return Outcome(summary(folder, run.metrics), run.metrics, (folder,))


@dataclass(frozen=True, kw_only=True)
class PdfOption(PrintOptions):
    """Pages on paper."""

    pdf: Flag = False
    """Print the pages as PDF too, with the Chromium, Chrome or Edge that is installed."""

    def with_pdf(self, outcome: Outcome) -> Outcome:
        """Print the pages that a command wrote; return what it found, with the paths of the PDFs.

        Raises:
            PlantigradeError: If the browser prints nothing.
        """
        from plantigrade.commands.progress import Progress
        from plantigrade.workflows.printing import print_pages

        progress = Progress(quiet=self.quiet)
        made = [pdf for folder in outcome.folders for pdf in print_pages(folder, progress.say)]
        shown = [str(pdf) for pdf in made[:MAX_SHOWN_PDFS]]
        shown += [f"{len(made) - MAX_SHOWN_PDFS} more"] if len(made) > MAX_SHOWN_PDFS else []
        lines = [f"  pdf            {pdf}" for pdf in shown]
        return replace(outcome, text="\n".join([outcome.text, *lines]))


@dataclass(frozen=True, kw_only=True)
class PageOptions(RunOptions, PdfOption):
    """Where the run folder goes, and whether its pages are printed."""


@dataclass(frozen=True, kw_only=True)
class JobOptions(Bounded):
    """How many independent runs (files, subjects, seeds) are computed side by side."""

    ranges = {"jobs": (-1, 1024, "")}

    jobs: int = 1
    """Number of parallel runs; -1 for one per core."""
    backend: Backend = "loky"
    """Where parallel runs are computed: on this machine (loky), or on a Ray or Dask cluster."""
    address: OptionalWord = None
    """Address of a Ray or Dask cluster; by default one is started on this machine."""

    def __post_init__(self):
        super().__post_init__()
        if self.jobs == 0:
            raise ParameterError("jobs must be 1, 2, … or -1 for one per core, not 0")
        if self.address is not None and self.backend not in ("ray", "dask"):
            raise ParameterError(f"--address needs --backend ray or dask, not {self.backend}")


def command_line() -> str:
    """Return the command as it was written, for the provenance of a run."""
    return " ".join(["plantigrade", *sys.argv[1:]])

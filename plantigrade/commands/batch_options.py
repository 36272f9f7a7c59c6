"""Options of commands that process many items, and the summary they print."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, TypeVar

import tyro

from plantigrade.commands.options import JobOptions, RunOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError
from plantigrade.options import Flag, optional

Made = TypeVar("Made", bound="Batch")

if TYPE_CHECKING:
    from collections.abc import Callable

    from plantigrade.commands.progress import Progress
    from plantigrade.workflows.batch import Batch, BatchSettings

PRINTED_WARNINGS = 5  # Kinds of warnings that are printed, the most frequent first; chosen
PRINTED_FAILURES = 20  # Kinds of failures, likewise


@dataclass(frozen=True, kw_only=True)
class BatchOptions(JobOptions):
    """Many items at once: where they are listed, and what is kept of each."""

    listed: Annotated[
        Path | None, tyro.conf.arg(name="list", metavar="FILE", help_behavior_hint="")
    ] = None
    """Text file that names files, folders or patterns, one a line."""
    keep: Annotated[
        Literal["pages", "runs", "figures"] | None, optional("{pages,runs,figures}")
    ] = None
    """Files that a batch keeps of each item: its run with report and viewer (pages), its run
    without them (runs), or its line of the table and its mean curves (figures)."""
    collect: Flag = False
    """Have workers send runs back instead of writing them, for clusters without a shared disk."""

    def one_or_many(
        self,
        files: tuple[Path, ...],
        name: str,
        one: "Callable[[Path, Progress], Outcome]",
        many: "Callable[..., Batch]",
    ) -> Outcome:
        """Process one recording, or many as a batch.

        Args:
            files: Recordings, folders and patterns.
            name: First part of the name of the batch's folder in ``runs``.
            one: Processes a single recording.
            many: Makes the batch of several.
        """
        from plantigrade.commands.progress import Progress
        from plantigrade.workflows.fit_many import recordings

        assert isinstance(self, RunOptions)
        if not files and self.listed is None:
            raise ParameterError("no recording given: name files or folders, or a --list of them")
        given, progress = recordings(files, self.listed), Progress(quiet=self.quiet)
        if not given.several:
            self.refuse_batch_options("name several recordings, a folder, or a --list")
            return one(given.files[0], progress)
        batch = batch_folder(
            self,
            f"{name}-{given.title}",
            lambda out: many(given, where=self.batch_settings(out, progress)),
        )
        return batch_outcome(batch, progress)

    def batch_settings(self, out: Path, progress: "Progress") -> "BatchSettings":
        """Return the settings of a batch in a folder; ``progress`` says what has ended."""
        from plantigrade.workflows.batch import BatchSettings

        assert isinstance(self, RunOptions)
        return BatchSettings(
            out=out,
            overwrite=self.overwrite,
            keep=self.keep,
            collect=self.collect,
            jobs=self.jobs,
            backend=self.backend,
            address=self.address,
            say=progress.say,
        )

    def refuse_batch_options(self, needs: str) -> None:
        """Refuse options of a batch where there is a single item."""
        given = {"--keep": self.keep is not None, "--collect": self.collect}
        given |= {"--jobs": self.jobs != 1, "--backend": self.backend != "loky"}
        for name, there in given.items():
            if there:
                raise ParameterError(f"{name} is for a batch: {needs}")


def batch_folder(options: RunOptions, name: str, open_: "Callable[[Path], Made]") -> "Made":
    """Return a batch in the folder of ``--out``, or else in ``runs/NAME``.

    Where that holds the same batch, it is taken up; where it holds something else, it is numbered.

    Raises:
        RunExists: If the folder that is named holds something else.
    """
    from itertools import count

    from plantigrade.errors import RunExists
    from plantigrade.record.run import RUNS

    if options.out is not None or options.overwrite:
        return open_(options.out or RUNS / name)
    for n in count(1):
        try:
            return open_(RUNS / (name if n == 1 else f"{name}-{n}"))
        except RunExists:
            continue
    raise AssertionError("numbers do not end")


def batch_outcome(batch: "Batch", progress: "Progress") -> Outcome:
    """Compute a batch and return what is printed of it."""
    from plantigrade.pages.batch import PAGE
    from plantigrade.record.batch import FAILED

    with progress.bar() as reached:
        for _ in batch:
            reached(batch.share)
    for name, most in (("failures", PRINTED_FAILURES), ("warnings", PRINTED_WARNINGS)):
        sentences = batch.metrics[name]
        for sentence in sentences[:most]:
            progress.warn(sentence)
        if len(sentences) > most:
            progress.warn(f"{len(sentences) - most} more on the page ({name} of other kinds)")
    folder = batch.folder or Path()
    shown = _shown(folder)
    lines = [f"{shown}: {batch.sentence}"]
    lines.append(f"  page             {shown / PAGE}")
    tables = [name for name in batch.metrics["files"] if name.endswith((".csv", ".parquet"))]
    lines.append(f"  tables           {', '.join(tables)}")
    lines += batch.lines
    if (folder / FAILED).is_file():
        lines.append(f"  failed           {shown / FAILED}: run the command again to try them")
    return Outcome("\n".join(lines), batch.metrics, (shown,))


def _shown(folder: Path) -> Path:
    """Return a folder as it is written from here."""
    try:
        return folder.relative_to(Path.cwd())
    except ValueError:
        return folder

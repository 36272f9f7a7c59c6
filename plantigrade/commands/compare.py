"""Compare walks: overlaid curves and differences with confidence bands."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from plantigrade.commands.options import PageOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError
from plantigrade.options import optional


@dataclass(frozen=True, kw_only=True)
class Command(PageOptions):
    """Compare walks: overlaid curves and differences with confidence bands, on one page.

    Each further gait is compared with the first. A single one has its left side compared with its
    right. A folder of several runs, such as that of a batch, is one gait: its runs are trials of
    one person, whose cycles are pooled.
    """

    runs: Annotated[tyro.conf.Positional[tuple[Path, ...]], optional("RUN [RUN ...]")]
    """Run folders of any kind that contain walking, or folders of such runs."""
    affected: Annotated[Literal["right", "left"] | None, optional("{right,left}")] = None
    """Pool all runs as trials of one person and compare this affected side with the other."""

    def run(self) -> Outcome:
        """Do it."""
        from plantigrade.commands.progress import Progress
        from plantigrade.record.metrics import read_metrics
        from plantigrade.workflows.compare import compare, default_name, summary, write

        if not self.runs:
            raise ParameterError("no run given: plantigrade compare RUN RUN")
        found = compare(*self.runs, affected=self.affected)
        self.refuse_existing(default_name(found))
        with Progress(quiet=self.quiet).step("writing the page"):
            folder = write(found, self.out, command=command_line(), overwrite=self.overwrite)
        return Outcome(summary(folder, found), read_metrics(folder), (folder,))

"""Compare walks: overlaid curves and differences with confidence bands."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.commands.options import RunOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError


@dataclass(frozen=True, kw_only=True)
class Command(RunOptions):
    """Compare walks: overlaid curves and differences with confidence bands, on one page.

    Each further run is compared with the first. A single run has its left side compared with its
    right.
    """

    runs: Annotated[
        tyro.conf.Positional[tuple[Path, ...]],
        tyro.conf.arg(metavar="RUN [RUN ...]", help_behavior_hint=""),
    ]
    """Run folders of any kind that contain walking."""

    def run(self) -> Outcome:
        """Do it."""
        from plantigrade.commands.progress import Progress
        from plantigrade.record.metrics import read_metrics
        from plantigrade.workflows.compare import compare, default_name, summary, write

        if not self.runs:
            raise ParameterError("no run given: plantigrade compare RUN RUN")
        found = compare(*self.runs)
        self.refuse_existing(default_name(found))
        with Progress(quiet=self.quiet).step("writing the page"):
            folder = write(found, self.out, command=command_line(), overwrite=self.overwrite)
        return Outcome(summary(folder, found), read_metrics(folder))

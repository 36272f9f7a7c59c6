"""Show a run in the browser."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import PlantigradeError


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions):
    """Show a run as a live, movable scene in the browser."""

    run_folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN")]
    """Run folder to show."""

    def run(self) -> Outcome:
        """Do it."""
        raise PlantigradeError("plantigrade view is not written yet")

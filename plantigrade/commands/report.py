"""Write the report and the viewer page of a run anew."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import PlantigradeError


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions):
    """Write the report and the viewer page of a run anew."""

    run_folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN")]
    """Run folder to report on."""

    def run(self) -> Outcome:
        """Do it."""
        raise PlantigradeError("plantigrade report is not written yet")

"""Compute a table or figure: ours beside the published numbers."""

from dataclasses import dataclass
from typing import Annotated

import tyro

from plantigrade.commands.options import RunOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import PlantigradeError


@dataclass(frozen=True, kw_only=True)
class Command(RunOptions):
    """Compute a table or figure: ours beside the published numbers."""

    name: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="NAME")]
    """Name of the experiment."""

    def run(self) -> Outcome:
        """Do it."""
        raise PlantigradeError("plantigrade experiment is not written yet")

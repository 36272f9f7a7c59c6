"""Fit a recording to a scaled human."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.commands.options import PersonOptions, RunOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import PlantigradeError


@dataclass(frozen=True, kw_only=True)
class Command(PersonOptions, RunOptions):
    """Fit a recording to a scaled human: motion, and moments where forces were measured."""

    files: Annotated[
        tyro.conf.Positional[tuple[Path, ...]],
        tyro.conf.arg(metavar="FILE [FILE ...]", help_behavior_hint=""),
    ]
    """Recordings to fit (.c3d, .trc, .amc, .bvh, .mot, ...)."""

    def run(self) -> Outcome:
        """Do it."""
        raise PlantigradeError("plantigrade fit is not written yet")

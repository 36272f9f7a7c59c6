"""Run the main job on the embedded default, end to end."""

from dataclasses import dataclass

from plantigrade.commands.options import PersonOptions, RunOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import PlantigradeError


@dataclass(frozen=True, kw_only=True)
class Command(PersonOptions, RunOptions):
    """Run the main job on the embedded default, end to end, and say where to look."""

    def run(self) -> Outcome:
        """Do it."""
        raise PlantigradeError("plantigrade demo is not written yet")

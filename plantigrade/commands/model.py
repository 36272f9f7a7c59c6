"""Write the human as MJCF and print what it is made of."""

from dataclasses import dataclass

from plantigrade.commands.options import PersonOptions, RunOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import PlantigradeError


@dataclass(frozen=True, kw_only=True)
class Command(PersonOptions, RunOptions):
    """Write the human as MJCF and print what it is made of."""

    def run(self) -> Outcome:
        """Do it."""
        raise PlantigradeError("plantigrade model is not written yet")

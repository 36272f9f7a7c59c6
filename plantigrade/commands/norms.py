"""Write your own norms from runs: mean and standard deviation over people."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import FileError, ParameterError
from plantigrade.options import Flag, OptionalWord


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions):
    """Write your own norms from runs: mean and standard deviation over people.

    Each run counts as one person, with the mean of its gait cycles and of both sides.
    """

    runs: Annotated[
        tyro.conf.Positional[tuple[Path, ...]],
        tyro.conf.arg(metavar="FOLDER [FOLDER ...]", help_behavior_hint=""),
    ]
    """Folders of runs, or run folders: one run per person."""
    out: Path = Path("norms.csv")
    """Table to write (.csv)."""
    people: OptionalWord = None
    """Who they are, in words for the pages: "30 adults, 20–60 years"."""
    overwrite: Flag = False
    """Replace the table if it exists."""

    def run(self) -> Outcome:
        """Do it."""
        from plantigrade.analyze.norms_of_runs import norms_of_folder
        from plantigrade.analyze.own_norms import norms_csv, own_population
        from plantigrade.io.text import write_text

        if not self.runs:
            raise ParameterError("no folder was named; write plantigrade norms FOLDER")
        if self.out.suffix.lower() != ".csv":
            raise FileError(self.out, "is no .csv file", remedy="end the name of --out in .csv")
        if self.out.exists() and not self.overwrite:
            raise FileError(self.out, "exists", remedy="name another --out, or add --overwrite")
        found = norms_of_folder(*self.runs)
        if self.people:
            found = own_population(found.curves, self.people)
        write_text(self.out, norms_csv(found))
        curves = list(found.curves)
        text = (
            f"{self.out}: {len(curves)} curves of {found.people}\n"
            f"  use it         plantigrade fit FILE --norms {self.out}"
        )
        return Outcome(text, {"file": str(self.out), "people": found.people, "curves": curves})

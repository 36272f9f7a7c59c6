"""Compute norms from your own runs: mean and standard deviation over people."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import FileError, ParameterError
from plantigrade.options import Flag, OptionalWord, optional


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions):
    """Compute norms from your own runs: mean and standard deviation over people.

    Each run counts as one person and enters as the mean of its gait cycles and both sides. Runs
    that are not ok, walk backward or have no complete gait cycle are omitted and named.
    """

    runs: Annotated[tyro.conf.Positional[tuple[Path, ...]], optional("FOLDER [FOLDER ...]")]
    """Run folders, or folders of runs: one run per person."""
    out: Path = Path("norms.csv")
    """CSV file to write."""
    people: OptionalWord = None
    """Description of the group for reports, such as "30 adults, 20–60 years"."""
    overwrite: Flag = False
    """Replace the file if it exists."""

    def run(self) -> Outcome:
        """Do it."""
        from plantigrade.analyze.norms_of_runs import norms_of_folder
        from plantigrade.analyze.own_norms import norms_csv, own_population
        from plantigrade.io.writing import write_text

        if not self.runs:
            raise ParameterError("no folder given: plantigrade norms FOLDER")
        if self.out.suffix.lower() != ".csv":
            raise FileError(
                self.out, "is not a .csv file", remedy="give --out a name ending in .csv"
            )
        if self.out.exists() and not self.overwrite:
            raise FileError(self.out, "exists", remedy="choose another --out, or add --overwrite")
        found, left_out = norms_of_folder(*self.runs)
        if self.people:
            found = own_population(found.curves, self.people)
        write_text(self.out, norms_csv(found))
        curves = list(found.curves)
        text = (
            f"{self.out}: {len(curves)} curves of {found.people}\n"
            f"  use it         plantigrade fit FILE --norms {self.out}"
        )
        text = "\n".join([*(f"omitted {name}: {why}" for name, why in left_out.items()), text])
        metrics = {"file": str(self.out), "people": found.people, "curves": curves}
        return Outcome(text, {**metrics, "left_out": left_out})

"""Write the report and viewer pages of a run again."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.bounds import AGES, Bounded
from plantigrade.commands.options import PdfOption
from plantigrade.commands.outcome import Outcome
from plantigrade.options import OptionalPath, Years


@dataclass(frozen=True, kw_only=True)
class Command(PdfOption, Bounded):
    """Write the report and viewer pages of a run again."""

    ranges = {"age": AGES}

    run_folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN")]
    """Run folder."""
    norms: OptionalPath = None
    """Your own norms to compare with from now on: a .csv file or a folder of runs."""
    age: Years = None
    """Age [years]; selects adult or children's norms from now on."""

    def run(self) -> Outcome:
        """Do it."""
        from plantigrade.record.metrics import read_metrics
        from plantigrade.workflows.save import report

        page = report(self.run_folder, norms=self.norms, age=self.age)
        written = (page, page.with_name("viewer.html"))
        text = "\n".join(str(path) for path in written)
        return Outcome(text, read_metrics(self.run_folder), (self.run_folder,))

"""Write the report and the viewer page of a run anew."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions):
    """Write the report and the viewer page of a run anew."""

    run_folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN")]
    """Run folder to report on."""

    def run(self) -> Outcome:
        """Do it."""
        from plantigrade.record import Run
        from plantigrade.record.folder import read_metrics, replace_files
        from plantigrade.report.pages import pages

        written = replace_files(self.run_folder, pages(Run.load(self.run_folder)))
        return Outcome("\n".join(str(path) for path in written), read_metrics(self.run_folder))

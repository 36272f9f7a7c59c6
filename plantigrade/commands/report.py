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
        from plantigrade.record.folder import replace_files
        from plantigrade.report.pages import pages

        run = Run.load(self.run_folder)
        written = replace_files(self.run_folder, pages(run))
        return Outcome("\n".join(str(path) for path in written), run.metrics)

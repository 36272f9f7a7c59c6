"""Show a run in the browser."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.bounds import Bounded
from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.options import Flag


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions, Bounded):
    """Show a run as an interactive 3-D scene in the browser.

    The server runs until Ctrl-C; over ssh, forward its port. The run's viewer.html needs no server.
    """

    ranges = {"port": (1, 65535, "")}

    run_folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="RUN")]
    """Run folder to show."""
    port: int = 8080
    """Port to listen on, or the next free one."""
    no_open: Flag = False
    """Print the address without opening a browser."""

    def run(self) -> Outcome:
        """Serve the run until interrupted.

        Raises:
            FileError: If the folder is no run folder.
        """
        from plantigrade.pages.page_server import serve_page
        from plantigrade.pages.run_pages import run_viewer
        from plantigrade.record import Run
        from plantigrade.record.metrics import read_metrics

        page = run_viewer(Run.load(self.run_folder))
        serve_page(page, port=self.port, open=not self.no_open)
        return Outcome(metrics=read_metrics(self.run_folder))

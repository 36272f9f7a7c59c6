"""Options of the live pages, and what is written of them."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plantigrade.bounds import Bounded
from plantigrade.commands.options import RunOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress
from plantigrade.errors import ParameterError
from plantigrade.options import Flag

if TYPE_CHECKING:
    from plantigrade.record import Run


@dataclass(frozen=True, kw_only=True)
class LiveOptions(Bounded):
    """Where a live page is served. A command adds ``live``, the switch."""

    ranges = {"port": (1, 65535, "")}

    live: Flag = False
    port: int = 8080
    """Port of the live page, or the next free one."""
    no_open: Flag = False
    """Print the address of the live page without opening a browser."""

    def __post_init__(self):
        super().__post_init__()
        if not self.live and (self.port != 8080 or self.no_open):
            raise ParameterError("--port and --no-open need --live")


def written_live(
    options: RunOptions,
    progress: Progress,
    live: Callable[..., "Run"],
    summary: Callable[[Path, dict[str, Any]], str],
) -> Outcome:
    """Run a live session; write the run where a folder is named, or where Save is pressed.

    Args:
        live: Runs the session with ``tell`` and ``save``, and returns the last run.
        summary: Returns the text that is printed of a run folder and its figures.
    """
    import sys

    from plantigrade.record import Run
    from plantigrade.workflows.save import save

    if options.out is not None:
        options.refuse_existing()
    written: list[Run] = []

    def keep(run: Run) -> Run:
        out = written[-1].folder if written else options.out
        written.append(save(run, out, overwrite=options.overwrite or bool(written)))
        return written[-1]

    run = live(tell=lambda line: print(line, file=sys.stderr, flush=True), save=keep)
    if options.out is not None:
        with progress.step("writing the report and the viewer"):
            keep(run)
    if not written:
        progress.say("not saved: press Save on the page, or name a folder with --out")
        return Outcome()
    folder = written[-1].folder or Path()
    return Outcome(summary(folder, written[-1].metrics), written[-1].metrics, (folder,))

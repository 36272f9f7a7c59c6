"""A run with its pages, written."""

from pathlib import Path

from plantigrade.record import Run
from plantigrade.report.pages import pages


def save(run: Run, out: str | Path, *, overwrite: bool = False) -> Run:
    """Write the folder of a run with its report and viewer, whole or not at all.

    Raises:
        RunExists: If the folder exists and is not to be replaced, or is no run.
        FileError: If the place cannot be written.
    """
    return run.save(out, files=pages(run), overwrite=overwrite)

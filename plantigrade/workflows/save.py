"""A run with its pages, written."""

from collections.abc import Mapping
from pathlib import Path

from plantigrade.options import as_path
from plantigrade.record import Run
from plantigrade.record.folder import replace_files
from plantigrade.report.pages import pages

REPORT = "report.html"


def save(
    run: Run,
    out: str | Path | None = None,
    *,
    overwrite: bool = False,
    files: Mapping[str, str | bytes] | None = None,
    numbered: bool = False,
    beside: str = "",
) -> Run:
    """Write the folder of a run with its report and viewer, whole or not at all.

    The arguments are those of :meth:`Run.save`; ``files`` are further ones.

    Raises:
        RunExists: If the folder exists and is not to be replaced, or is no run.
        FileError: If the place cannot be written.
    """
    every = {**pages(run), **(files or {})}
    return run.save(out, files=every, overwrite=overwrite, numbered=numbered, beside=beside)


def report(
    run: Run | str | Path, out: str | Path | None = None, *, overwrite: bool = False
) -> Path:
    """Write the report and the viewer of a run and return the path of ``report.html``.

    Args:
        run: A run, or its folder.
        out: Save it here first. A run that is not saved yet goes to ``runs/<kind>-<name>``,
            numbered where that is taken, if absent; one that is saved stays where it is, and its
            two pages are written anew.
        overwrite: Replace an existing run.

    Raises:
        RunExists: If ``out`` exists and is not to be replaced, or is no run.
        FileError: If there is no run in the folder, or it cannot be written.
        ParameterError: If the record cannot be drawn, or ``run`` is neither a run nor a path.
    """
    if not isinstance(run, Run):
        run = Run.load(as_path(run, "a run"))
    if out is not None or run.folder is None:
        saved = save(run, out, overwrite=overwrite)
        return (saved.folder or Path()) / REPORT
    replace_files(run.folder, pages(run))
    return run.folder / REPORT

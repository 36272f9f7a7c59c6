"""A run with its pages, written."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from plantigrade.analyze.clinical import clinical_figures
from plantigrade.analyze.moment_table import moment_table
from plantigrade.analyze.norms_of_runs import norm_files, read_norms
from plantigrade.analyze.own_norms import as_signals
from plantigrade.exchange.tables import cycle_table
from plantigrade.io.mot import mot_text
from plantigrade.options import as_path
from plantigrade.pages.run_pages import pages
from plantigrade.record import Run
from plantigrade.record.folder import replace_files
from plantigrade.record.metrics import METRICS
from plantigrade.record.provenance import source_files
from plantigrade.record.run import COORDINATES, MODEL, MOTION
from plantigrade.workflows.settings import FitSettings

REPORT, CURVES, MOMENTS = "report.html", "curves.csv", "inverse_dynamics.sto"


def save(
    run: Run,
    out: str | Path | None = None,
    *,
    overwrite: bool = False,
    files: Mapping[str, str | bytes] | None = None,
    numbered: bool = False,
    beside: str = "",
) -> Run:
    """Write the folder of a run with its report, viewer and curves, whole or not at all.

    The arguments are those of :meth:`Run.save`; ``files`` are further ones.

    Raises:
        RunExists: If the folder exists and is not to be replaced, or is no run.
        FileError: If the place cannot be written.
    """
    every = {**shown(run), **(files or {})}
    return run.save(out, files=every, overwrite=overwrite, numbered=numbered, beside=beside)


def shown(run: Run) -> dict[str, str]:
    """Return the files that follow from a run alone, by name.

    They are its pages and, where it has gait cycles, ``curves.csv``, the mean curves over the cycle
    (:func:`~plantigrade.exchange.tables.cycle_table`), and on a model of the person's own the
    moments of its coordinates, ``inverse_dynamics.sto``.

    Raises:
        ParameterError: If the record cannot be drawn.
    """
    curves = cycle_table(run, mean=True)
    moments = moment_table(run.record)
    found = pages(run) | ({CURVES: curves} if curves else {})
    return found | ({} if moments is None else {MOMENTS: mot_text(moments, "moments", False)})


def report(
    run: Run | str | Path,
    out: str | Path | None = None,
    *,
    overwrite: bool = False,
    norms: str | Path | None = None,
    age: float | None = None,
) -> Path:
    """Write the report and the viewer of a run and return the path of ``report.html``.

    Args:
        run: A run, or its folder.
        out: Save it here first. A run that is not saved yet goes to ``runs/<kind>-<name>``,
            numbered where that is taken, if absent; one that is saved stays where it is, and its
            two pages are written anew.
        overwrite: Replace an existing run.
        norms: Your own norms, a table or a folder of runs: the run is compared with them from now
            on, its figures too.
        age: Age of the person [years], likewise.

    Raises:
        RunExists: If ``out`` exists and is not to be replaced, or is no run.
        FileError: If there is no run in the folder, or it cannot be written.
        ParameterError: If the record cannot be drawn, or ``run`` is neither a run nor a path.
    """
    if not isinstance(run, Run):
        run = Run.load(as_path(run, "a run"))
    if norms is not None or age is not None:
        run = compared_anew(run, norms, age)
        if out is None and run.folder is not None:
            theirs = (f"{name}.{ending}" for name in run.others for ending in ("npz", "xml"))
            own = (MODEL, MOTION, COORDINATES, METRICS, *theirs)
            names = [name for name in run.files if name not in own]
            kept = {name: (run.folder / name).read_bytes() for name in names}
            save(run, run.folder, overwrite=True, files={**kept, **shown(run)})
            return run.folder / REPORT
    if out is not None or run.folder is None:
        saved = save(run, out, overwrite=overwrite)
        return (saved.folder or Path()) / REPORT
    replace_files(run.folder, shown(run))
    return run.folder / REPORT


def compared_anew(run: Run, norms: str | Path | None, age: float | None) -> Run:
    """Return a run compared with other norms, with its figures and their sources.

    Raises:
        FileError: If the norms cannot be read.
        ParameterError: If they are a folder without runs of people who walk, or the age is not
            allowed.
    """
    compared = FitSettings(norms=None if norms is None else as_path(norms, "norms"), age=age)
    record, figures = run.record, {k: v for k, v in run.figures.items() if not _of_norms(k)}
    settings, files = dict(run.provenance.settings), dict(run.provenance.source_files)
    if compared.age is not None:
        figures["age_years"] = settings["age"] = compared.age
    if compared.norms is not None:
        record = replace(
            record, signals={**record.signals, **as_signals(read_norms(compared.norms))}
        )
        settings["norms"] = str(compared.norms)
        files |= source_files(norm_files(compared.norms))
    return replace(
        run,
        record=record,
        figures={**figures, **clinical_figures(record, figures)},
        provenance=replace(run.provenance, settings=settings, source_files=files),
    )


def _of_norms(key: str) -> bool:
    return key.startswith(("gps_", "gvs_", "norm_population", "norm_reason"))

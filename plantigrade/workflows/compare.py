"""Runs compared: a folder with one page, a table of every curve, and the figures."""

from collections.abc import Sequence
from pathlib import Path

from plantigrade import __version__
from plantigrade.analyze.run_comparison import RunComparison, compare_runs
from plantigrade.errors import ParameterError
from plantigrade.io.writing import csv_text
from plantigrade.options import as_path
from plantigrade.pages.compare import compare_html
from plantigrade.record import Run
from plantigrade.record.folder import write_folder
from plantigrade.record.metrics import METRICS
from plantigrade.record.provenance import source_files
from plantigrade.record.run import RUNS

PAGE, TABLE = "compare.html", "compare.csv"


def compare(*runs: Run | str | Path) -> RunComparison:
    """Compare two or more walks by their curves over the gait cycle; right and left of one.

    Each later run is compared with the first. Differences have a band of 95 % confidence for the
    whole curve (:mod:`plantigrade.analyze.curve_difference`).

    Args:
        runs: Runs, or their folders, of any kind.

    Raises:
        FileError: If a folder holds no run.
        ParameterError: If there is no run, one is named twice, or one shows no complete gait cycle.

    Example:
        >>> import plantigrade as pg
        >>> found = pg.compare("runs/fit-before", "runs/fit-after")  # doctest: +SKIP
        >>> found.differences["fit-after"]["knee_angle_r"].largest  # doctest: +SKIP
    """
    loaded = [run if isinstance(run, Run) else Run.load(as_path(run, "a run")) for run in runs]
    names = names_of(loaded)
    return compare_runs(loaded, names)


def names_of(runs: Sequence[Run]) -> list[str]:
    """Return a name for each run: that of its folder, with folders above it where two are alike.

    Raises:
        ParameterError: If a run was named twice.
    """
    for k, run in enumerate(runs):
        same = [r for r in runs[:k] if r is run or _same_folder(r, run)]
        if same:
            where = run.folder or run.title or run.name
            raise ParameterError(f"{where} is given twice")
    names = [run.name or run.title or run.kind for run in runs]
    longer = [f"{r.folder.resolve().parent.name}/{n}" if r.folder else n
              for r, n in zip(runs, names, strict=True)]  # fmt: skip
    names = [w if names.count(n) > 1 else n for n, w in zip(names, longer, strict=True)]
    return [n if names.count(n) == 1 else f"{n} ({k})" for k, n in enumerate(names, start=1)]


def write(
    found: RunComparison,
    out: str | Path | None = None,
    *,
    command: str = "",
    overwrite: bool = False,
) -> Path:
    """Write the folder of a comparison: page, table and figures; return it.

    Without ``out`` it goes to ``runs/compare-<names>``, numbered where that is taken.

    Raises:
        RunExists: If the folder exists and is not to be replaced, or is no run.
        FileError: If the place cannot be written.
    """
    folders = [run.folder for run in found.runs if run.folder is not None]
    provenance = {
        "version": __version__,
        "command": command,
        "runs": [str(folder) for folder in folders],
        "source_files": source_files([folder / METRICS for folder in folders]),
    }
    return write_folder(
        RUNS / default_name(found) if out is None else as_path(out, "out"),
        metrics={**found.metrics(), **provenance},
        files={PAGE: compare_html(found, provenance), TABLE: table_csv(found)},
        overwrite=overwrite,
        numbered=out is None and not overwrite,
    )


def default_name(found: RunComparison) -> str:
    """Return the name of the folder of a comparison."""
    plain = [run.name.rpartition("/")[2] or run.kind for run in found.runs]
    more = f"-and-{len(plain) - 2}-more" if len(plain) > 2 else ""
    return "-".join(["compare", *plain[:2]]) + more


def table_csv(found: RunComparison) -> str:
    """Return every curve as CSV; what is not known is empty."""
    return csv_text(*found.rows())


def summary(folder: Path, found: RunComparison) -> str:
    """Return the angles that differ most, and where to look."""
    lines = [f"{folder}: {', '.join(gait.name for gait in found.gaits)}"]
    for other, table in found.differences.items():
        angles = {n: d for n, d in table.items() if "moment" not in n and "ground" not in n}
        most = sorted(angles, key=lambda n: -angles[n].rms)[:3]
        words = ", ".join(f"{n} {angles[n].rms:.1f}°" for n in most)
        beyond = sum(bool(d.beyond.any()) for d in angles.values())
        known = sum(d.half is not None for d in angles.values())
        lines.append(f"  {other}: largest RMS differences {words}")
        lines.append(
            f"    beyond the 95 % band somewhere in the cycle: {beyond} of {known} angles"
            if known
            else "    too few cycles for a confidence band"
        )
    return "\n".join([*lines, f"  page           {folder / PAGE}"])


def _same_folder(a: Run, b: Run) -> bool:
    return (
        a.folder is not None and b.folder is not None and a.folder.resolve() == b.folder.resolve()
    )

"""Runs compared: a folder with one page, a table of every curve, and the figures."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from pathlib import Path

from plantigrade import __version__
from plantigrade.analyze.pooled_gait import Affected
from plantigrade.analyze.run_comparison import RunComparison, compare_runs
from plantigrade.errors import ParameterError
from plantigrade.io.writing import csv_text
from plantigrade.motion.cycles import cut_cycles
from plantigrade.options import as_path
from plantigrade.pages.compare import compare_html
from plantigrade.record import Run
from plantigrade.record.folder import write_folder
from plantigrade.record.metrics import METRICS
from plantigrade.record.provenance import source_files
from plantigrade.record.run import MOTION, RUNS

PAGE, TABLE, FIGURES = "compare.html", "compare.csv", "differences.csv"
Given = Run | str | Path  # A run, its folder, or a folder of runs that are trials of one person


def compare(*runs: Given | Sequence[Given], affected: Affected | None = None) -> RunComparison:
    """Compare two or more walks by their curves over the gait cycle; right and left of one.

    Each later gait is compared with the first. Differences have a band of 95 % confidence for the
    whole curve (:mod:`plantigrade.analyze.curve_difference`), and range, peak and time of the peak
    a test (:mod:`plantigrade.analyze.curve_difference`).

    Args:
        runs: Runs or their folders, of any kind; a folder of several runs, such as that of a
            batch, or a sequence of runs, is one gait: trials of one person, whose cycles are
            pooled.
        affected: ``"right"`` or ``"left"``: all runs are trials of one person, whose affected side
            is compared with the other one.

    Raises:
        FileError: If a folder holds no run.
        ParameterError: If there is no run, one is named twice, one shows no complete gait cycle, or
            pooled trials are of different people.

    Example:
        >>> import plantigrade as pg
        >>> found = pg.compare("runs/fit-before", "runs/fit-after")  # doctest: +SKIP
        >>> found.differences["fit-after"]["knee_angle_r"].largest  # doctest: +SKIP
        >>> pg.compare("runs/anna", affected="left").figures["affected (left)"]  # doctest: +SKIP
    """
    omitted: list[str] = []
    groups = [_trials(each, omitted) for each in runs]
    every = [run for group in groups for run in group]
    names = names_of(every)
    if affected is not None and groups:
        found = compare_runs([every], [_shared_name(runs, every)], affected=affected)
        return replace(found, omitted=tuple(omitted))
    firsts = [every.index(group[0]) for group in groups]
    called = [
        names[k] if len(group) == 1 else _shared_name([given], group)
        for k, group, given in zip(firsts, groups, runs, strict=True)
    ]
    called = [n if called.count(n) == 1 else f"{n} ({k})" for k, n in enumerate(called, start=1)]
    return replace(compare_runs(groups, called), omitted=tuple(omitted))


def _trials(given: Given | Sequence[Given], omitted: list[str]) -> list[Run]:
    """Return a run, or the trials of a folder or a sequence.

    Trials of a folder without a complete gait cycle are added to ``omitted`` by name.

    Raises:
        FileError: If a folder holds no run.
        ParameterError: If no trial of a folder shows a complete gait cycle.
    """
    if isinstance(given, Run):
        return [given]
    if not isinstance(given, str | Path) and isinstance(given, Sequence):
        return [run for each in given for run in _trials(each, omitted)]
    folder = as_path(given, "a run")
    inside = _runs_inside(folder)
    if not inside:
        return [Run.load(folder)]
    found = []
    for run in map(Run.load, inside):
        if cut_cycles(run.record.motion.events):
            found.append(run)
        else:
            omitted.append(run.name)
    if not found:
        raise ParameterError(f"none of the {len(inside)} runs in {folder} shows a gait cycle")
    return found


def _runs_inside(folder: Path) -> list[Path]:
    """Return the folders of the runs in a folder that is no run itself."""
    folder = folder.expanduser()
    if (folder / MOTION).is_file() or not folder.is_dir():
        return []
    return sorted(each for each in folder.iterdir() if (each / MOTION).is_file())


def _shared_name(given: Iterable[object], trials: Sequence[Run]) -> str:
    """Return a name of pooled trials: that of their folder, or of the person."""
    folders = {run.folder.resolve().parent.name for run in trials if run.folder is not None}
    named = [Path(each).name for each in given if isinstance(each, str | Path)]
    if len(trials) == 1:
        return names_of(trials)[0]
    if len(named) == 1:
        return named[0]
    people = {str(run.figures["subject_name"]) for run in trials if "subject_name" in run.figures}
    for found in (people, folders):
        if len(found) == 1:
            return found.pop()
    return "trials"


def names_of(runs: Sequence[Run]) -> list[str]:
    """Return a name for each run: that of its folder, with folders above it where two are alike."""
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
        files={
            PAGE: compare_html(found, provenance),
            TABLE: csv_text(*found.rows()),
            FIGURES: csv_text(*found.figure_rows()),
        },
        overwrite=overwrite,
        numbered=out is None and not overwrite,
    )


def default_name(found: RunComparison) -> str:
    """Return the name of the folder of a comparison."""
    if found.affected is not None:
        return f"compare-affected-{found.affected}"
    if found.sides:
        plain = [found.runs[0].name if len(found.runs) == 1 else "sides"]
    else:
        plain = [g.name if g.runs[1:] else g.runs[0].name for g in found.gaits]
    plain = [name.rpartition("/")[2] or found.runs[0].kind for name in plain]
    more = f"-and-{len(plain) - 2}-more" if len(plain) > 2 else ""
    return "-".join(["compare", *plain[:2]]) + more


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

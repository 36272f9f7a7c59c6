"""Fit recordings to scaled humans."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from plantigrade.commands.options import JobOptions, RunOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError
from plantigrade.workflows.settings import FitSettings

if TYPE_CHECKING:
    from plantigrade.record import Run
    from plantigrade.workflows.one_subject import Shared


@dataclass(frozen=True, kw_only=True)
class Command(FitSettings, RunOptions, JobOptions):
    """Fit a scaled human to a recording: motion, ground reactions and joint moments.

    Several recordings are summarised in one table; trials of one subject are fitted with one scaled
    body. A standing trial, skeleton or force file in the same folder is found by name and content,
    or can be given as an option.
    """

    files: Annotated[
        tyro.conf.Positional[tuple[Path, ...]],
        tyro.conf.arg(metavar="FILE [FILE ...]", help_behavior_hint=""),
    ]
    """Recordings to fit (.c3d, .trc, .amc, .bvh, .mot, ...)."""
    subject: Literal["auto", "one", "each"] = "auto"
    """Whose the recordings are: trials of one subject share lengths, marker places and body mass.
    auto: alike in folder, subject or name before the trial number, and marker distances; one: all
    are one subject's; each: every recording on its own."""

    def run(self) -> Outcome:
        """Fit one recording, or each of several on its own."""
        if not self.files:
            raise ParameterError("no recording given: plantigrade fit FILE")
        names = [f"fit-{name}" for name in run_names(self.files)]
        if len(self.files) > 1:
            return self._several(names)
        self.refuse_existing(*names)
        files = list(self.files)
        run = fit_one(self, (files[0], self.out, names[0]))
        return Outcome(summary(run.folder or Path(), run.metrics), run.metrics)

    def _shared(self) -> tuple[list["Shared | None"], list[str]]:
        """Return what each recording shares with others of its subject, and what went wrong.

        Raises:
            ParameterError: If all are said to be of one subject, and cannot be.
        """
        from plantigrade.workflows.one_subject import by_subject

        shared: list[Shared | None] = [None] * len(self.files)
        groups = {"each": [], "one": [tuple(range(len(self.files)))]}.get(self.subject)
        groups = by_subject(self.files) if groups is None else groups
        work = partial(_share, FitSettings.of(self))
        lines = []
        for done in self.side_by_side(work, [[self.files[i] for i in g] for g in groups]):
            if done.problem and self.subject == "one":
                raise ParameterError(done.problem)
            if done.problem:
                lines.append(f"fitted each on its own: {done.problem}")
            found = done.result
            for path in () if found is None else found.files:
                shared[self.files.index(path)] = found
        return shared, lines

    def _several(self, names: Sequence[str]) -> Outcome:
        """Fit each recording on its own, and put them into one table."""
        from plantigrade.record.folder import refuse_existing
        from plantigrade.record.run import RUNS
        from plantigrade.workflows import fit_table

        default = f"fit-table-{study_name(self.files)}"
        self.refuse_existing(default)
        out = self.out or RUNS / default
        folders = [out.parent / name for name in names]
        if self.overwrite:
            for folder in folders:
                refuse_existing(folder, overwrite=True)
        shared, lines = self._shared()
        items = zip(self.files, folders, names, shared, strict=True)
        done = self.side_by_side(partial(_member, self), items)
        metrics: dict[str, Any] = {}
        fitted, left_out = [], {}
        for each in done:
            path, folder, name, _ = each.item
            if each.result is None:
                lines.append(f"{path}: error: {each.problem}")
                metrics[str(path)] = {"status": each.problem}
                left_out[str(path)] = each.problem
            else:
                place, found = each.result
                lines.append(f"{path}: {summary(place, found)}")
                metrics[str(path)] = found
                fitted.append((name.removeprefix("fit-"), path, place, found))
        if fitted:
            table = fit_table.write(
                fitted,
                left_out,
                out,
                command=command_line(),
                settings=FitSettings.of(self),
                overwrite=self.overwrite,
                numbered=self.out is None and not self.overwrite,
            )
            lines.append(f"table of {len(fitted)} fits: {table / fit_table.PAGE}")
        failed = sum(found.get("status") != "ok" for found in metrics.values())
        status = "ok" if not failed else f"{failed} of {len(self.files)} recordings failed"
        return Outcome("\n".join(lines), {"status": status, **metrics})


def _share(settings: FitSettings, paths: Sequence[Path]) -> "Shared | None":
    """Return what trials of one subject share."""
    from plantigrade.workflows.one_subject import share

    return share(paths, settings)


def _member(
    options: Command, item: tuple[Path, Path, str, "Shared | None"]
) -> tuple[Path, dict[str, Any]]:
    """Fit one recording of several: its folder and metrics."""
    numbered = not options.overwrite
    run = fit_one(options, item[:3], quiet=True, numbered=numbered, shared=item[3])
    return run.folder or item[1], run.metrics


def fit_one(
    options: Command,
    item: tuple[Path, Path | None, str],
    quiet: bool = False,
    numbered: bool = False,
    shared: "Shared | None" = None,
) -> "Run":
    """Fit one recording and write its run folder, called so where no folder is named."""
    from plantigrade.commands.progress import Progress
    from plantigrade.workflows.fit import fit
    from plantigrade.workflows.save import save

    path, out, name = item
    progress = Progress(quiet=options.quiet or quiet)
    settings = FitSettings.of(options)
    run = fit(path, settings, step=progress.step, command=command_line(), shared=shared)
    with progress.step("writing the report and the viewer"):
        named = replace(run, name=name)
        run = save(named, out, overwrite=options.overwrite, numbered=numbered)
    of = f"{path.name}: " if len(options.files) > 1 else ""
    for sentence in (*run.record.notes, *(() if run.ok else (run.status,))):
        progress.note(sentence, of)
    return run


def run_names(files: Sequence[Path]) -> list[str]:
    """Return one name for each recording: its own, with its ending or folder where names are alike.

    Raises:
        ParameterError: If one file is named twice.

    Example:
        >>> run_names([Path("a/walk.c3d"), Path("a/walk.trc"), Path("b/run.c3d")])
        ['walk-c3d', 'walk-trc', 'run']
    """
    paths = [path.absolute() for path in files]
    names = [path.stem for path in paths]
    longer = (
        lambda p: f"{p.stem}-{p.suffix[1:]}",
        lambda p: f"{p.parent.name}-{p.stem}-{p.suffix[1:]}",
        lambda p: "-".join((*p.parts[1:-1], p.stem, p.suffix[1:])),
    )
    for name_of in longer:
        alike = {name for name in names if names.count(name) > 1}
        names = [name_of(p) if n in alike else n for p, n in zip(paths, names, strict=True)]
    twice = [str(f) for f, n in zip(files, names, strict=True) if names.count(n) > 1]
    if twice:
        raise ParameterError(f"{twice[0]} is given twice; give each recording once")
    return names


def study_name(given: Sequence[Path]) -> str:
    """Return what several are called after: their folder, or the first recording and their number.

    Example:
        >>> study_name([Path("a/walk.c3d"), Path("b/run.c3d"), Path("c.trc")])
        'walk-and-2-more'
    """
    first = given[0].resolve().name if given[0].is_dir() else given[0].stem
    return first if len(given) == 1 else f"{first}-and-{len(given) - 1}-more"


def summary(folder: Path, metrics: dict) -> str:
    """Return what a reader wants to know first."""
    lines = [f"{folder}: {metrics['frames']} frames, {metrics['duration_s']:.2f} s"]
    error = metrics.get("marker_rms_mean_mm", metrics.get("joint_rms_mm"))
    if error is not None:
        what = "marker" if "marker_rms_mean_mm" in metrics else "joint centre"
        lines.append(f"  {what} error   {error:.1f} mm RMS")
    lines.append(f"  person         {metrics['height_m']:.3f} m, {metrics['mass_kg']:.1f} kg")
    for what in ("walking", "running"):
        if f"{what}_speed_m_s" in metrics:
            lines.append(
                f"  {what}        {metrics[f'{what}_speed_m_s']:.2f} m/s, "
                f"{metrics['cadence_steps_min']:.0f} steps/min"
            )
    lines.append(f"  report         {folder / 'report.html'}")
    lines.append(f"  viewer         {folder / 'viewer.html'}")
    return "\n".join(lines)

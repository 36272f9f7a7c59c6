"""Fit recordings to scaled humans."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import tyro

from plantigrade.commands.options import JobOptions, RunOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError
from plantigrade.workflows.settings import FitSettings


@dataclass(frozen=True, kw_only=True)
class Command(FitSettings, RunOptions, JobOptions):
    """Fit a recording to a scaled human: motion, and moments where forces were measured.

    A standing trial, a skeleton or a file of forces that belongs to the recording is found beside
    it by name and content, or named by option.
    """

    files: Annotated[
        tyro.conf.Positional[tuple[Path, ...]],
        tyro.conf.arg(metavar="FILE [FILE ...]", help_behavior_hint=""),
    ]
    """Recordings to fit (.c3d, .trc, .amc, .bvh, .mot, ...)."""

    def run(self) -> Outcome:
        """Fit one recording, or each of several on its own."""
        if not self.files:
            raise ParameterError("no recording was named; write plantigrade fit FILE")
        if len(self.files) > 1 and self.out is not None:
            raise ParameterError(
                "--out names one folder but several recordings were given; leave it out (each goes "
                "to runs/fit-<name>) or fit them one by one"
            )
        names = [f"fit-{name}" for name in run_names(self.files)]
        self.refuse_existing(*names)
        if len(self.files) == 1:
            return fit_one(self, (self.files[0], names[0]))
        return self._several(names)

    def _several(self, names: Sequence[str]) -> Outcome:
        items = zip(self.files, names, strict=True)
        done = self.side_by_side(partial(fit_one, self, quiet=True), items)
        lines: list[str] = []
        metrics: dict[str, Any] = {}
        for each in done:
            path = each.item[0]
            if each.result is None:
                lines.append(f"{path}: error: {each.problem}")
                metrics[str(path)] = {"status": each.problem}
            else:
                lines.append(f"{path}: {each.result.text}")
                metrics[str(path)] = each.result.metrics
        failed = sum(found.get("status") != "ok" for found in metrics.values())
        status = "ok" if not failed else f"{failed} of {len(self.files)} recordings failed"
        return Outcome("\n".join(lines), {"status": status, **metrics})


def fit_one(options: Command, item: tuple[Path, str], quiet: bool = False) -> Outcome:
    """Fit one recording and write its run folder, called so where ``--out`` is absent."""
    from plantigrade.commands.progress import Progress
    from plantigrade.workflows.fit import fit
    from plantigrade.workflows.save import save

    path, name = item
    progress = Progress(quiet=options.quiet or quiet)
    run = fit(path, FitSettings.of(options), step=progress.step, command=command_line())
    with progress.step("writing the report and the viewer"):
        run = save(replace(run, name=name), options.out, overwrite=options.overwrite)
    of = f"{path.name}: " if len(options.files) > 1 else ""
    for sentence in (*run.record.notes, *(() if run.ok else (run.status,))):
        progress.warn(of + sentence)
    return Outcome(summary(run.folder or Path(), run.metrics), run.metrics)


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
        raise ParameterError(f"{twice[0]} was named twice; name each recording once")
    return names


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

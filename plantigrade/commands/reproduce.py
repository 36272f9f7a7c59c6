"""Reproduce recorded gaits from prioritised tasks; several recordings make a study."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from plantigrade.commands.fit import run_names, study_name
from plantigrade.commands.options import JobOptions, RunOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError
from plantigrade.workflows.settings import ReproduceSettings

if TYPE_CHECKING:
    from plantigrade.analyze.reproduction import Comparison
    from plantigrade.commands.progress import Progress
    from plantigrade.record import Run


@dataclass(frozen=True, kw_only=True)
class Command(ReproduceSettings, RunOptions, JobOptions):
    """Reproduce a recorded gait from three prioritised tasks; several make a study.

    The tasks take only foot contacts, heel and centre-of-mass paths, and the posture (by default
    with its rate) at the end of each gait phase from the recording. Everything else is computed.
    """

    files: Annotated[
        tyro.conf.Positional[tuple[Path, ...]],
        tyro.conf.arg(metavar="FILE [FILE ...]", help_behavior_hint=""),
    ]
    """Recordings of walking (.c3d, .trc, .amc, .bvh, .mot, ...), or folders of them."""

    def run(self) -> Outcome:
        """Reproduce one recording, or several as a study."""
        from plantigrade.commands.progress import Progress

        if not self.files:
            raise ParameterError("no recording given: plantigrade reproduce FILE")
        progress, files = Progress(quiet=self.quiet), list(self.files)
        if len(files) > 1 or files[0].is_dir():
            return self._study(progress)
        self.refuse_existing(f"reproduce-{files[0].stem}")
        run = reproduce_one(self, (files[0], self.out), progress)
        for sentence in (*run.record.notes, *(() if run.ok else (run.status,))):
            progress.note(sentence)
        return Outcome(summary(run.folder or Path(), run.metrics), run.metrics)

    def _study(self, progress: "Progress") -> Outcome:
        from plantigrade.record.folder import refuse_existing
        from plantigrade.record.run import RUNS
        from plantigrade.workflows import study as gait_study

        files, named = recordings(self.files)
        default = f"reproduce-study-{study_name(self.files)}"
        names = run_names(files)
        self.refuse_existing(default)
        out = self.out or RUNS / default
        folders = [out.parent / f"reproduce-{name}" for name in names]
        if self.overwrite:
            for folder in folders:
                refuse_existing(folder, overwrite=True)
        items = zip(files, folders, strict=True)
        done = self.side_by_side(partial(_reproduce_member, self), items)
        members, left_out, of = [], {}, len(files)
        for k, (name, each) in enumerate(zip(names, done, strict=True), start=1):
            path, _ = each.item
            if each.result is None:
                left_out[str(path)] = each.problem
                say = progress.warn if path in named else progress.say
                say(f"{k}/{of} {path}: {each.problem}")
                continue
            members.append(gait_study.Member(name, path, *each.result))
            progress.say(f"{k}/{of} {path}: {members[-1].words}")
        if not members:
            raise ParameterError(
                f"none of the {of} recordings could be reproduced; first: {files[0]}: "
                f"{left_out[str(files[0])]}"
            )
        with progress.step("writing the study"):
            found = gait_study.GaitStudy(tuple(members), left_out)
            metrics = found.metrics(failed=[p for p in left_out if Path(p) in named])
            folder = gait_study.write(
                found,
                metrics,
                out,
                command=command_line(),
                settings=ReproduceSettings.of(self),
                overwrite=self.overwrite,
                numbered=self.out is None and not self.overwrite,
            )
        return Outcome(study_summary(folder, found), metrics)


def reproduce_one(
    options: Command, item: tuple[Path, Path | None], progress: "Progress", numbered: bool = False
) -> "Run":
    """Reproduce one recording, write its run folder and return the run."""
    from plantigrade.workflows.reproduce import reproduce
    from plantigrade.workflows.save import save

    path, folder = item
    settings = ReproduceSettings.of(options)
    run = reproduce(path, settings, step=progress.step, command=command_line())
    with progress.step("writing the report and the viewer"):
        numbered = numbered and not options.overwrite
        return save(run, folder, overwrite=options.overwrite, numbered=numbered)


def _reproduce_member(
    options: Command, item: tuple[Path, Path]
) -> "tuple[Path, Comparison, dict[str, Any]]":
    """Reproduce one recording of a study: its folder, comparison and metrics."""
    from plantigrade.analyze.reproduction import compare
    from plantigrade.commands.progress import Progress

    run = reproduce_one(options, item, Progress(quiet=True), numbered=True)
    return run.folder or item[1], compare(run.record), run.metrics


def recordings(given: Sequence[Path]) -> tuple[list[Path], set[Path]]:
    """Return the recordings that were named or lie in named folders, and which were named.

    Run folders, and files of no format of motion, are passed over.

    Raises:
        ParameterError: If a folder holds none.
    """
    from plantigrade.errors import FileError
    from plantigrade.io import format_of
    from plantigrade.record.folder import METRICS

    files: list[Path] = []
    for path in given:
        if not path.is_dir():
            files.append(path)
            continue
        inside = []
        for each in sorted(p for p in path.rglob("*") if p.is_file()):
            if (each.parent / METRICS).exists():
                continue
            try:
                if format_of(each).name != "npz":
                    inside.append(each)
            except FileError:
                continue
        if not inside:
            raise ParameterError(f"{path} holds no recording of a known format")
        files += [each for each in inside if each not in files]
    return files, {path for path in given if not path.is_dir()}


def summary(folder: Path, metrics: dict[str, Any]) -> str:
    """Return what a reader wants to know first."""
    n = metrics["cycles_count"]
    lines = [
        f"{folder}: {metrics['duration_s']:.2f} s of walking, {n} stride{'' if n == 1 else 's'}, "
        f"tasks “{metrics['tasks']}”",
        *figures(metrics),
        f"  report           {folder / 'report.html'}",
        f"  viewer           {folder / 'viewer.html'}",
    ]
    return "\n".join(lines)


def figures(metrics: dict[str, Any]) -> list[str]:
    """Return the lines that say how near the reproduced gait is to the recorded one."""
    from plantigrade.analyze.gait_study import PAPER_TABLE

    lines = []
    if "rom_error_mean_deg" in metrics:
        paper = [row.difference for row in PAPER_TABLE.values()]
        lines.append(
            f"  range of motion  error {metrics['rom_error_mean_deg']:.1f}° mean, "
            f"{metrics['rom_error_max_deg']:.1f}° maximum (paper, nine people: "
            f"{sum(paper) / len(paper):.1f}°, {max(paper)}°)"
        )
    lines.append(
        f"  centre of mass   error {metrics['com_error_max_mm']:.1f} mm maximum; "
        f"contact drift {metrics['contact_drift_max_mm']:.1f} mm, "
        f"lowest sole point {metrics['sole_lowest_mm']:.1f} mm"
    )
    if metrics.get("vertical_force_rmse_bw") is not None:
        lines.append(
            f"  vertical force   RMSE {metrics['vertical_force_rmse_bw']:.3f} body weights, "
            f"r {metrics['vertical_force_correlation']:.2f}"
        )
    if "cycle" in metrics["seconds"]:
        lines.append(f"  time             {metrics['seconds']['cycle']:.2f} s per gait cycle")
    return lines


def study_summary(folder: Path, found) -> str:
    """Return Table I as text, what was left out, and where to look."""
    from plantigrade.workflows.study import PAGE

    n = len(found.members)
    lines = [f"{folder}: {n} gait{'' if n == 1 else 's'} reproduced", *found.table_text()]
    lines += [f"  left out         {path}: {why}" for path, why in found.left_out.items()]
    return "\n".join([*lines, f"  study            {folder / PAGE}"])

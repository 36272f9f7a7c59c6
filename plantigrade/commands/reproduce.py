"""Rebuild recorded gaits from ordered tasks; several of them make a study."""

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tyro

from plantigrade.commands.fit import ready, run_names
from plantigrade.commands.options import (
    Flag,
    JobOptions,
    PersonOptions,
    RecordingOptions,
    RunOptions,
    fit_settings,
)
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError, PlantigradeError

if TYPE_CHECKING:
    from plantigrade.analyze.reproduction import Comparison

GENERATING = ("loky", "threading")  # back ends that hand over each result as it is ready


@dataclass(frozen=True, kw_only=True)
class Command(RecordingOptions, PersonOptions, RunOptions, JobOptions):
    """Rebuild a recorded gait from three ordered tasks; several make a study.

    Of the recording the tasks see the contacts of the feet, the paths of the heels over the ground
    and of the centre of mass, and the posture at the end of each phase; all else follows.
    """

    files: Annotated[
        tyro.conf.Positional[tuple[Path, ...]],
        tyro.conf.arg(metavar="FILE [FILE ...]", help_behavior_hint=""),
    ]
    """Recordings of somebody who walks (.c3d, .trc, .amc, .bvh, .mot, ...), or folders of them."""
    tasks: Literal["default", "paper", "two-phases", "split-com", "no-posture"] = "default"
    """The default set, the paper's own, or what the paper tried without."""
    no_dynamics: Flag = False
    """Leave out the hierarchy of forces: no ground reactions, no joint moments."""

    def run(self) -> Outcome:
        """Do it."""
        if not self.files:
            raise ParameterError("no recording was named; write plantigrade reproduce FILE")
        if self.jobs == 0:
            raise ParameterError(
                "jobs=0 reproduces nothing; allowed are 1, 2, … or -1 for one per core"
            )
        if len(self.files) == 1 and not self.files[0].is_dir():
            out = self.out or Path("runs") / f"reproduce-{self.files[0].stem}"
            text, metrics, _ = self.reproduce_one(self.files[0], out)
            return Outcome(text, metrics)
        return self._study()

    def reproduce_one(
        self, path: Path, out: Path, *, quiet: bool | None = None
    ) -> tuple[str, dict[str, Any], "Comparison"]:
        """Reproduce one recording and write its run folder.

        Args:
            path: The recording.
            out: The run folder.
            quiet: Say nothing but warnings; as the option says if absent.

        Returns:
            Words, metrics, and the reproduced gait held against the recorded one.
        """
        from plantigrade.commands.progress import Progress
        from plantigrade.workflows import fit as fitting
        from plantigrade.workflows import reproduce as reproducing

        progress = Progress(quiet=self.quiet if quiet is None else quiet)
        settings = self.settings()
        fitting.refuse_existing(out, overwrite=self.overwrite)
        with progress.step(f"reading {path.name}"):
            loaded = fitting.load(path, settings)
        with progress.step("fitting"):
            fitted = fitting.fit(loaded, settings)
        with progress.step("analysing"):
            trial = fitting.analyse(fitted, settings)
        with progress.step("reproducing"):
            made = reproducing.reproduce_trial(trial, settings.tasks, settings.dynamics)
        with progress.step("writing the report and the viewer"):
            folder, metrics = reproducing.write(
                made,
                out,
                title=f"{path.name}, reproduced",
                command=["plantigrade", *sys.argv[1:]],
                settings=settings,
                sources=loaded.sources,
                seed=self.seed,
                overwrite=self.overwrite,
            )
        if quiet is None:
            for sentence in metrics["warnings"]:
                progress.warn(sentence)
            if metrics["status"] != "ok":
                progress.warn(metrics["status"])
        return summary(folder, metrics), metrics, made.comparison

    def settings(self):
        """Return what decides the result."""
        from plantigrade.workflows.reproduce import ReproduceSettings

        return ReproduceSettings(
            **fit_settings(self), tasks=self.tasks, dynamics=not self.no_dynamics
        )

    def _study(self) -> Outcome:
        from plantigrade.commands.progress import Progress
        from plantigrade.workflows import study as gait_study
        from plantigrade.workflows.fit import refuse_existing

        progress = Progress(quiet=self.quiet)
        files, named = recordings(self.files)
        out = self.out or Path("runs") / f"reproduce-study-{study_name(self.files)}"
        names = run_names(files)
        folders = [out.parent / f"reproduce-{name}" for name in names]
        for folder in (out, *folders):
            refuse_existing(folder, overwrite=self.overwrite)
        members, left_out = [], {}
        of = len(files)
        for k, (path, name, done) in enumerate(
            zip(files, names, self._each(files, folders), strict=True), start=1
        ):
            words, metrics, comparison = done
            if comparison is None:
                left_out[str(path)] = words
                (progress.warn if path in named else progress.say)(f"{k}/{of} {path}: {words}")
                continue
            members.append(gait_study.Member(name, path, folders[k - 1], comparison, metrics))
            progress.say(f"{k}/{of} {path}: {members[-1].words}")
        if not members:
            raise ParameterError(
                f"none of {of} recordings could be reproduced; the first: {files[0]}: "
                f"{left_out[str(files[0])]}"
            )
        with progress.step("writing the study"):
            found = gait_study.GaitStudy(tuple(members), left_out)
            metrics = found.metrics(failed=[p for p in left_out if Path(p) in named])
            folder = gait_study.write(
                found,
                metrics,
                out,
                command=["plantigrade", *sys.argv[1:]],
                settings=self.settings(),
                seed=self.seed,
                overwrite=self.overwrite,
            )
        return Outcome(study_summary(folder, found), metrics)

    def _each(self, files: Sequence[Path], folders: Sequence[Path]) -> Iterator[Any]:
        """Yield what came of each recording, in their order."""
        from joblib import Parallel, delayed, parallel_config

        words = {f.name: getattr(self, f.name) for f in fields(self)}
        with parallel_config(ready(self.backend), n_jobs=self.jobs):
            how = "generator" if self.backend in GENERATING else "list"
            work: Any = Parallel(return_as=how)(
                delayed(_reproduce_alone)(words, path, folder)
                for path, folder in zip(files, folders, strict=True)
            )
            yield from work


def _reproduce_alone(words: dict, path: Path, out: Path):
    try:
        return Command(**words).reproduce_one(path, out, quiet=True)
    except (PlantigradeError, OSError) as error:
        return str(error), {}, None


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


def study_name(given: Sequence[Path]) -> str:
    """Return what a study is called after: its folder, or its first recording and their number.

    Example:
        >>> study_name([Path("a/walk.c3d"), Path("b/run.c3d"), Path("c.trc")])
        'walk-and-2-more'
    """
    first = given[0].resolve().name if given[0].is_dir() else given[0].stem
    return first if len(given) == 1 else f"{first}-and-{len(given) - 1}-more"


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
            f"  ranges of motion {metrics['rom_error_mean_deg']:.1f}° off on the mean, "
            f"{metrics['rom_error_max_deg']:.1f}° at most (the paper, nine people: "
            f"{sum(paper) / len(paper):.1f}°, {max(paper)}°)"
        )
    lines.append(
        f"  centre of mass   {metrics['com_error_max_mm']:.1f} mm off its path at most; "
        f"contacts drift {metrics['contact_drift_max_mm']:.1f} mm, "
        f"soles reach {metrics['sole_lowest_mm']:.1f} mm"
    )
    if metrics.get("vertical_force_rmse_bw") is not None:
        lines.append(
            f"  vertical force   {metrics['vertical_force_rmse_bw']:.3f} body weights off the "
            f"measured one, r {metrics['vertical_force_correlation']:.2f}"
        )
    if metrics.get("dynamics_status", "ok") != "ok":
        lines.append(f"  moved by forces  {metrics['dynamics_status']}")
    if "time_per_cycle_s" in metrics:
        lines.append(f"  time             {metrics['time_per_cycle_s']:.2f} s per gait cycle")
    return lines


def study_summary(folder: Path, found) -> str:
    """Return Table I as text, what was left out, and where to look."""
    from plantigrade.workflows.study import PAGE

    lines = [f"{folder}: {len(found.members)} gaits reproduced", *found.table_text()]
    lines += [f"  left out         {path}: {why}" for path, why in found.left_out.items()]
    return "\n".join([*lines, f"  study            {folder / PAGE}"])

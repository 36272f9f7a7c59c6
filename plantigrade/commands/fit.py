"""Fit recordings to scaled humans."""

import sys
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any

import tyro

from plantigrade.commands.options import (
    JobOptions,
    PersonOptions,
    RecordingOptions,
    RunOptions,
    fit_settings,
)
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError, PlantigradeError
from plantigrade.extras import require


@dataclass(frozen=True, kw_only=True)
class Command(RecordingOptions, PersonOptions, RunOptions, JobOptions):
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
        """Do it."""
        if not self.files:
            raise ParameterError("no recording was named; write plantigrade fit FILE")
        if len(self.files) > 1 and self.out is not None:
            raise ParameterError(
                "--out names one folder but several recordings were given; leave it out (each goes "
                "to runs/fit-<name>) or fit them one by one"
            )
        if self.jobs == 0:
            raise ParameterError("jobs=0 fits nothing; allowed are 1, 2, … or -1 for one per core")
        if len(self.files) == 1:
            text, metrics = self.fit_one(self.files[0])
            return Outcome(text, metrics)
        return self._many()

    def fit_one(
        self, path: Path, *, name: str | None = None, quiet: bool | None = None
    ) -> tuple[str, dict]:
        """Fit one recording and write its run folder; return the words and the metrics.

        Args:
            path: The recording.
            name: What the run folder is called after; the recording if absent.
            quiet: Say nothing but warnings; as the option says if absent.
        """
        import time

        from plantigrade.commands.progress import Progress
        from plantigrade.workflows import fit as fitting

        started = time.perf_counter()
        progress = Progress(quiet=self.quiet if quiet is None else quiet)
        settings = self.settings()
        out = self.out or Path("runs") / f"fit-{name or path.stem}"
        fitting.refuse_existing(out, overwrite=self.overwrite)
        with progress.step(f"reading {path.name}"):
            loaded = fitting.load(path, settings)
        with progress.step("fitting"):
            fitted = fitting.fit(loaded, settings)
        with progress.step("analysing"):
            trial = fitting.analyse(fitted, settings)
        with progress.step("writing the report and the viewer"):
            folder, metrics = fitting.write(
                trial,
                out,
                title=path.name,
                command=["plantigrade", *sys.argv[1:]],
                settings=settings,
                sources=loaded.sources,
                seed=self.seed,
                overwrite=self.overwrite,
                extra={"fit_time_s": time.perf_counter() - started},
                loaded=loaded,
            )
        of = f"{path.name}: " if len(self.files) > 1 else ""
        for sentence in trial.record.warnings:
            progress.warn(of + sentence)
        if metrics["status"] != "ok":
            progress.warn(of + metrics["status"])
        return summary(folder, metrics), metrics

    def settings(self):
        """Return what decides the result."""
        from plantigrade.workflows.fit import FitSettings

        return FitSettings(**fit_settings(self))

    def _many(self) -> Outcome:
        from joblib import Parallel, delayed, parallel_config

        from plantigrade.workflows.fit import refuse_existing

        words = {f.name: getattr(self, f.name) for f in fields(self)}
        names = run_names(self.files)
        for name in names:
            refuse_existing(Path("runs") / f"fit-{name}", overwrite=self.overwrite)
        with parallel_config(ready(self.backend), n_jobs=self.jobs):
            done: Any = Parallel()(
                delayed(_fit_alone)(words, path, name)
                for path, name in zip(self.files, names, strict=True)
            )
        texts, metrics = [], {}
        failed = 0
        for path, (text, found) in zip(self.files, done, strict=True):
            texts.append(f"{path}: {text}")
            metrics[str(path)] = found
            failed += found.get("status") != "ok"
        status = "ok" if not failed else f"{failed} of {len(self.files)} recordings failed"
        return Outcome("\n".join(texts), {"status": status, **metrics})


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


def _fit_alone(words: dict, path: Path, name: str) -> tuple[str, dict]:
    try:
        return Command(**words).fit_one(path, name=name, quiet=True)
    except (PlantigradeError, OSError) as error:
        return f"error: {error}", {"status": str(error)}


def ready(backend: str) -> str:
    """Return the name of a joblib backend once the library behind it is there and known to joblib.

    Raises:
        MissingExtra: If it is not installed.
    """
    if backend == "ray":
        require("ray.util.joblib", "ray").register_ray()
    elif backend == "dask":
        require("distributed", "dask").Client(processes=True)
    return backend


def summary(folder: Path, metrics: dict) -> str:
    """Return what a reader wants to know first."""
    lines = [f"{folder}: {metrics['frames']} frames, {metrics['duration_s']:.2f} s"]
    error = metrics.get("marker_rms_mean_mm", metrics.get("joint_rms_mm"))
    if error is not None:
        what = "marker" if "marker_rms_mean_mm" in metrics else "joint centre"
        lines.append(f"  {what} error   {error:.1f} mm RMS")
    lines.append(f"  person         {metrics['height_m']:.3f} m, {metrics['mass_kg']:.1f} kg")
    if "walking_speed_m_s" in metrics:
        lines.append(
            f"  walking        {metrics['walking_speed_m_s']:.2f} m/s, "
            f"{metrics['cadence_steps_min']:.0f} steps/min"
        )
    lines.append(f"  report         {folder / 'report.html'}")
    lines.append(f"  viewer         {folder / 'viewer.html'}")
    return "\n".join(lines)

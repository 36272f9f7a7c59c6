"""Make a motion from a task alone, or a recorded one physical: one subcommand for each task."""

import signal
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, ClassVar

import tyro

from plantigrade.commands.options import RunOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress
from plantigrade.errors import ParameterError
from plantigrade.synthesize.tasks.settings import TASKS, TaskSettings
from plantigrade.workflows.settings import (
    PaperSettings,
    SolveSettings,
    TrackSettings,
)

SAID = 8  # findings that are printed
EVERY = 0.5  # between two lines of progress [s]
TRACK, PAPER = "track", "zhakatayev2023"


@dataclass(frozen=True, kw_only=True)
class Command(RunOptions):
    """Make a motion from a task alone, by trajectory optimisation.

    The motion obeys the equations of motion with true contact forces; an independent checker
    decides whether it is valid. Ctrl-C stops with the best so far, which is checked and written.
    """

    def run(self) -> Outcome:
        """Make the motion and write its run folder."""
        from plantigrade.record.folder import refuse_existing
        from plantigrade.workflows.save import save

        progress = Progress(quiet=self.quiet)
        out = self.out or Path("runs") / f"synthesize-{self.name}"
        refuse_existing(out, self.overwrite)
        watch = Watch(progress)
        with watch.listening():
            run = self.make(watch)
        watch.close(run.figures)
        with progress.step("writing the report and the viewer"):
            run = save(run, out, overwrite=self.overwrite)
        findings = run.record.signals.get("check.findings", ())
        for line in (*run.record.notes, *findings[:SAID]):
            progress.warn(str(line))
        if len(findings) > SAID:
            progress.warn(f"{len(findings) - SAID} more of that kind are in the report")
        return Outcome(summary(out, run.metrics), run.metrics)

    @property
    def name(self) -> str:
        """What the run is called."""
        raise NotImplementedError

    def make(self, watch: "Watch") -> Any:
        """Return the run."""
        raise NotImplementedError

    def context(self, watch: "Watch", title: str, *files: Path) -> dict[str, Any]:
        """Return who watches, and where the run comes from."""
        from plantigrade.workflows.synthesize import Origin

        command = " ".join(["plantigrade", *sys.argv[1:]])
        return {"progress": watch, "origin": Origin(title, command, files, self.seed)}


@dataclass(frozen=True, kw_only=True)
class _Task(SolveSettings, Command):
    """A task of the registry, or of a file."""

    task: ClassVar[str]
    file: tyro.conf.Suppress[Path | None] = None

    @property
    def name(self) -> str:
        """The task, or the file."""
        return self.task if self.file is None else self.file.stem

    def make(self, watch: "Watch") -> Any:
        """Solve the task."""
        from plantigrade.synthesize.tasks.task_file import read_task_file
        from plantigrade.workflows.synthesize import synthesize_task

        kind, files = TASKS[self.task], () if self.file is None else (self.file,)
        task = kind(**{f.name: getattr(self, f.name) for f in fields(kind)})
        title = f"{self.name.replace('-', ' ').capitalize()}, from the task alone"
        file = None if self.file is None else read_task_file(self.file)
        how = SolveSettings.of(self)
        return synthesize_task(task, how, file=file, **self.context(watch, title, *files))


@dataclass(frozen=True, kw_only=True)
class Paper(PaperSettings, Command):
    """Solve a motion of Zhakatayev et al. (2023) as the paper sets it."""

    @property
    def name(self) -> str:
        """The paper and its motion."""
        return f"{PAPER}-{self.motion}"

    def make(self, watch: "Watch") -> Any:
        """Solve the paper's problem."""
        from plantigrade.workflows.synthesize import synthesize_paper

        title = f"{self.motion.replace('-', ' ').capitalize()}, as in the paper"
        return synthesize_paper(PaperSettings.of(self), **self.context(watch, title))


@dataclass(frozen=True, kw_only=True)
class Track(TrackSettings, Command):
    """Make a recorded motion physical: near it, and on true contact forces."""

    recording: Annotated[Path, tyro.conf.arg(metavar="FILE", help_behavior_hint="(required)")]
    """Recording to track: C3D, TRC, BVH, AMC or MOT."""

    @property
    def name(self) -> str:
        """The recording."""
        return f"{TRACK}-{self.recording.stem}"

    def make(self, watch: "Watch") -> Any:
        """Fit the recording and move it by forces."""
        from plantigrade.workflows.track import track

        title = f"{self.recording.name}, on forces of the ground"
        return track(self.recording, TrackSettings.of(self), **self.context(watch, title))


def _subcommand(name: str, kind: type[TaskSettings]) -> type:
    """Return the command of a task: its own options, then those of all tasks."""
    own = {"__doc__": kind.__doc__, "__module__": __name__, "task": name}
    return dataclass(frozen=True, kw_only=True)(type(kind.__name__, (_Task, kind), own))


SUBCOMMANDS: dict[str, type] = {
    **{name: _subcommand(name, kind) for name, kind in TASKS.items()},
    TRACK: Track,
    PAPER: Paper,
}
"""Name of a task → its command."""


def parse(words: Sequence[str], config: Any) -> Any:
    """Return the command that words say.

    Raises:
        SystemExit: If the parser has printed its help (code 0) or its complaint (code 2).
        ParameterError: If there is no such task, or a value is out of range.
        FileError: If a task file cannot be read.
    """
    first, options = words[0] if words else "--help", {}
    if first.startswith("-"):
        print(usage())
        if first in ("-h", "--help"):
            raise SystemExit(0)
        raise ParameterError(f"{first} must follow the task: plantigrade synthesize TASK {first}")
    kind = SUBCOMMANDS.get(first)
    if first.lower().endswith(".toml"):
        from plantigrade.synthesize.tasks.task_file import read_task_file

        file = read_task_file(first)
        kind = SUBCOMMANDS[file.base]
        options["default"] = kind(**file.parameters, file=Path(first))
    if kind is None:
        raise ParameterError(f"no task {first!r}; there are {', '.join(SUBCOMMANDS)}")
    prog = f"plantigrade synthesize {first}"
    return tyro.cli(kind, prog=prog, args=list(words[1:]), config=config, **options)


def usage() -> str:
    """Return the help page: every task."""
    width = max(map(len, SUBCOMMANDS))
    listed = "\n".join(
        f"  {name:{width}}  {(kind.__doc__ or '').splitlines()[0]}"
        for name, kind in SUBCOMMANDS.items()
    )
    about = (Command.__doc__ or "").replace("\n    ", "\n").strip()
    return (
        f"usage: plantigrade synthesize TASK [OPTIONS]\n\n{about}\n\ntasks:\n{listed}\n"
        f"  {'FILE.toml':{width}}  A task of your own.\n\n"
        "`plantigrade synthesize TASK --help` lists the options of a task, and those of all tasks\n"
        "(who does it, how it is solved, --out, --json, --quiet)."
    )


class Watch:
    """Says what the solver does, and stops it when asked from the keyboard."""

    def __init__(self, progress: Progress):
        self.progress, self.asked = progress, False
        self._stage, self._said = "", -EVERY
        self._last: Any = None

    def __call__(self, stage: str, iterate: Any) -> bool:
        """Say where the solver is, now and then; return whether it shall stop."""
        now = time.perf_counter()
        if stage != self._stage:
            self._say()
            self._stage, self._said = stage, -EVERY
        self._last = iterate
        if now - self._said >= EVERY:
            self._said = now
            self._say()
        return self.asked

    def close(self, figures: dict[str, Any]) -> None:
        """Say how it ended."""
        self._say()
        self.progress.say(
            f"{figures['solver_status']}: {figures['iterations']} iterations, "
            f"{figures['solve_time_s']:.1f} s; checked in {figures['frames']} frames"
        )

    def _say(self) -> None:
        it = self._last
        if it is None:
            return
        worst = getattr(it, "worst", "")
        named = f" ({worst.replace('_', ' ')})" if worst else ""
        self.progress.say(
            f"{self._stage}: iteration {it.number:3d}, cost {it.objective:.4g}, "
            f"off by {it.violation:.1e}{named}"
        )

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Stop with the best so far at the first Ctrl-C, and at once at the second."""

        def ask(*_: Any) -> None:
            if self.asked:
                raise KeyboardInterrupt
            self.asked = True
            self.progress.warn("stopping with the best so far; press Ctrl-C again to give up")

        try:
            before = signal.signal(signal.SIGINT, ask)
        except ValueError:  # not the main thread, where no keys are heard
            yield
            return
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)


def summary(folder: Path, metrics: dict[str, Any]) -> str:
    """Return what a reader wants to know first."""
    m, ok = metrics, metrics["status"] == "ok"
    rows = {
        "verdict": "passed the check" if ok else "DID NOT PASS THE CHECK",
        "unexplained": f"{m['check_root_force_rms_bw_percent']:.2f} % of body weight RMS, "
        f"{m['check_root_force_max_bw_percent']:.2f} % at most; "
        f"slip {m['check_slip_max_mm']:.2f} mm, "
        f"{m['check_penetration_max_mm']:.2f} mm in the ground",
    }
    if m.get("walking_speed_m_s") is not None:
        rows["walk"] = (
            f"{m['walking_speed_m_s']:.2f} m/s, {m['cadence_steps_min']:.0f} steps/min, "
            f"stance {m['stance_r_pct']:.0f} %, step width {100 * m['step_width_m']:.0f} cm"
        )
    if m.get("cost_of_transport") is not None:
        rows["cost"] = (
            f"{m['cost_of_transport']:.2f} of transport (joint work "
            f"{m['joint_work_absolute_j']:.0f} J over {m['displacement_m']:.2f} m)"
        )
    rows |= {page: str(folder / f"{page}.html") for page in ("report", "viewer")}
    lines = (f"  {name:15}  {text}" for name, text in rows.items())
    return "\n".join([f"{folder}: {m['sentence']}", *lines])

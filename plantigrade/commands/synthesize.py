"""Generate a motion from a task, or a dynamically consistent one from a recording."""

import glob
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cache, cached_property, partial
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import tyro

from plantigrade.commands import parsing
from plantigrade.commands.batch_options import BatchOptions, batch_folder, batch_outcome
from plantigrade.commands.live_options import LiveOptions, written_live
from plantigrade.commands.options import PageOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress, SolverProgress
from plantigrade.errors import ParameterError, known_names
from plantigrade.options import Flag, optional, refuse_unknown
from plantigrade.trajopt.tasks.settings import TASKS
from plantigrade.workflows.settings import PAPER, TRACK, PaperSettings, SolveSettings, TrackSettings

if TYPE_CHECKING:
    from plantigrade.record.inputs import Inputs

MAX_FINDINGS = 8  # findings that are printed


@dataclass(frozen=True, kw_only=True)
class Command(PageOptions, BatchOptions):
    """Generate a motion from a task description by trajectory optimisation.

    The motion satisfies the equations of motion with unilateral contact forces; an independent
    check decides whether it is valid. Ctrl-C stops with the best solution so far. Several task
    files, a folder of them, or --vary make a batch with one table; one that was interrupted
    continues where it stopped.
    """

    word: ClassVar[str] = ""
    option_kinds: ClassVar[tuple[type, ...]] = ()

    vary: Annotated[
        tuple[tuple[str, ...], ...], tyro.conf.UseAppendAction, optional("OPTION VALUE [VALUE ...]")
    ] = ()
    """Option to vary and its values, such as speed 0.8 1.2; repeatable, all combined."""

    @property
    def tasks(self) -> Sequence[str | Path]:
        """The tasks, one or several."""
        return [self.task]

    def varied(self) -> dict[str, list[Any]]:
        """Return what varies, and its values as the options take them.

        Raises:
            ParameterError: If there is no such option, or a combination is not allowed.
        """
        from plantigrade.commands.simulate_batch import varied

        names = {f.name for kind in self.option_kinds for f in fields(kind)}
        found: dict[str, list[Any]] = {}
        for name, words in varied(self.vary).items():
            refuse_unknown(self.word or "a task", [name], names)
            found[name] = [self._typed(name, word) for word in words]
            for value in found[name]:
                replace(self, **{name: value})  # refuses what is not allowed
        return found

    def _typed(self, name: str, word: str) -> Any:
        """Return a value of an option as a word of the command line gives it."""
        words = [f"--{name.replace('_', '-')}", *([] if word == "true" else [word])]
        return getattr(parse([self.word, *self.required, *words]), name)

    required: ClassVar[tuple[str, ...]] = ()

    def run(self) -> Outcome:
        """Make the motion, or many, and write the run folder or the batch."""
        if self.vary or self.listed is not None or len(self.tasks) != 1:
            return self._several()
        self.refuse_batch_options("name several task files, a folder of them, or add --vary")
        return self._one()

    def _several(self) -> Outcome:
        from plantigrade.workflows.synthesize_many import synthesize_batch

        progress = Progress(quiet=self.quiet)
        tasks, vary = self.tasks, self.varied()
        common = {k: v for k, v in self.chosen().items() if k not in vary}
        return batch_outcome(
            batch_folder(
                self,
                f"synthesize-batch-{self.name}",
                lambda out: synthesize_batch(
                    tasks, vary, common, self.batch_settings(out, progress), command=command_line()
                ),
            ),
            progress,
        )

    def _one(self) -> Outcome:
        from plantigrade.workflows.motions import run_synthesis

        progress = Progress(quiet=self.quiet)
        self.refuse_existing(f"synthesize-{self.name}")
        watch = SolverProgress(progress)
        with watch.listening():
            run = run_synthesis(
                self.task,
                None,
                self.chosen(),
                progress=watch,
                step=progress.step,
                command=command_line(),
            )
        watch.close(run.metrics)
        findings = [str(each) for each in run.record.signals.get("check.findings", ())]
        more = len(findings) - MAX_FINDINGS
        findings[MAX_FINDINGS:] = [f"{more} more findings are in the report"] if more > 0 else []
        return self.written(run, progress, summary, *findings)

    @property
    def task(self) -> str | Path:
        """The task, as :func:`~plantigrade.workflows.motions.synthesize` takes it."""
        return self.word

    @property
    def name(self) -> str:
        """Name of the run."""
        return self.word

    def chosen(self) -> dict[str, Any]:
        """Every option that decides the result, by name."""
        return {f.name: getattr(self, f.name) for kind in self.option_kinds for f in fields(kind)}


@dataclass(frozen=True, kw_only=True)
class _Task(SolveSettings, LiveOptions, Command):
    """A task of the registry, or of a file."""

    file: tyro.conf.Suppress[Path | None] = None
    live: Flag = False
    """Open a page on which sliders and dragging change the task, and it is solved again."""

    def __post_init__(self):
        super().__post_init__()
        if self.live and (self.vary or self.listed):
            raise ParameterError("several motions are a batch, which cannot be --live")
        slow = [f for f in ("replay", "optimise_timing", "free_time") if getattr(self, f, False)]
        if self.live and (slow or self.restarts > 1):
            raise ParameterError("replay, restarts and free times take too long for --live")

    @property
    def task(self) -> str | Path:
        """The task, or its file."""
        return self.word if self.file is None else self.file

    @property
    def name(self) -> str:
        """The task, or its file."""
        return self.word if self.file is None else self.file.stem

    def run(self) -> Outcome:
        """Make the motion, or many, and write the run folder or the batch; or open the page."""
        return self._live() if self.live else super().run()

    def _live(self) -> Outcome:
        """Show the task in the browser; write its run where one is named or Save is pressed."""
        from plantigrade.workflows.live_task import live_task

        progress = Progress(quiet=self.quiet)
        where = {"port": self.port, "open": not self.no_open, "command": command_line()}
        live = partial(live_task, self.task, **where, **self.chosen())
        return written_live(self, progress, live, summary)


@dataclass(frozen=True, kw_only=True)
class Paper(PaperSettings, Command):
    """Solve a motion of Zhakatayev et al. (2023) as posed in the paper."""

    word, option_kinds = PAPER, (PaperSettings,)

    @property
    def name(self) -> str:
        """The paper and its motion."""
        return f"{PAPER}-{self.motion}"


@dataclass(frozen=True, kw_only=True)
class Track(TrackSettings, Command):
    """Track a recorded motion with a dynamically consistent one, or many."""

    word, option_kinds, required = TRACK, (TrackSettings,), ("--recording", "-")
    recording: Annotated[
        tuple[Path, ...], tyro.conf.arg(metavar="FILE|FOLDER ...", help_behavior_hint="(required)")
    ] = ()
    """Recording to track (.c3d, .trc, .bvh, .amc, .mot), with or without this option; several, or
    folders or patterns of them, make a batch."""

    @cached_property
    def recordings(self) -> "Inputs":
        """The recordings."""
        from plantigrade.workflows.fit_many import recordings

        if not self.recording and self.listed is None:
            raise ParameterError(
                "no recording given: plantigrade synthesize track --recording FILE"
            )
        return recordings(self.recording, self.listed)

    @property
    def name(self) -> str:
        """The recording."""
        return f"{TRACK}-{self.recordings.title}"

    def varied(self) -> dict[str, list[Any]]:
        """Return what varies: the recording where there are several, and options."""
        return {"recording": list(self.recordings.files), **super().varied()}

    def chosen(self) -> dict[str, Any]:
        """The recording, and how it is tracked."""
        return {"recording": self.recordings.files[0], **super().chosen()}

    def run(self) -> Outcome:
        """Track one recording, or many."""
        if self.recordings.several:
            return self._several()
        return super().run()


@dataclass(frozen=True, kw_only=True)
class Files(SolveSettings, Command):
    """Generate the motions of several task files, or of folders or patterns of them."""

    option_kinds = (SolveSettings,)
    files: Annotated[tyro.conf.Positional[tuple[Path, ...]], optional("FILE.toml|FOLDER ...")] = ()
    """Task files."""

    @cached_property
    def found(self) -> "Inputs":
        """The task files."""
        from plantigrade.record.inputs import inputs

        fits = lambda path: path.suffix.lower() == ".toml"  # noqa: E731
        return inputs(self.files, fits=fits, what="task file", listed=self.listed)

    @property
    def tasks(self) -> Sequence[str | Path]:
        """The task files."""
        return self.found.files

    @property
    def name(self) -> str:
        """Their common name."""
        return self.found.title

    def run(self) -> Outcome:
        """Make them."""
        return self._several()


@cache
def _subcommand(name: str) -> type:
    """Return the command of a task: its own options, then those of all tasks."""
    if name in (TRACK, PAPER):
        return Track if name == TRACK else Paper
    kind = TASKS[name]
    own = {"__doc__": kind.__doc__, "__module__": __name__}
    own |= {"word": name, "option_kinds": (kind, SolveSettings)}
    return dataclass(frozen=True, kw_only=True)(type(kind.__name__, (_Task, kind), own))


class _Subcommands(Mapping[str, type]):
    """Name of a task → its command, made when it is asked for: that takes milliseconds each."""

    def __getitem__(self, name: str) -> type:
        """Return the command of a task."""
        return _subcommand(name)

    def __iter__(self) -> Iterator[str]:
        """Return the names of all tasks, in the order of the help page."""
        return iter((*TASKS, TRACK, PAPER))

    def __len__(self) -> int:
        return len(TASKS) + 2


SUBCOMMANDS = _Subcommands()


def parse(words: Sequence[str]) -> Any:
    """Return the command that words say.

    Raises:
        SystemExit: If the parser has printed its help (code 0) or its complaint (code 2).
        ParameterError: If there is no such task, or a value is out of range.
        FileError: If a task file cannot be read.
    """
    words = [_joint_strength(words, k) for k in range(len(words))]
    first, options = words[0] if words else "--help", {}
    leading = list(takewhile(lambda word: not word.startswith("-"), words))
    extra = leading[1:] if first in SUBCOMMANDS else []
    if extra and first == TRACK:
        if any(word.partition("=")[0] == "--recording" for word in words):
            raise ParameterError(
                f"{extra[0]!r} stands before --recording, which takes all recordings: name them in "
                "one place"
            )
        words = [first, "--recording", *extra, *words[len(leading) :]]
    elif extra:
        raise ParameterError(
            f"{first} takes options only, not {extra[0]!r}: see plantigrade synthesize {first} "
            "--help"
        )
    folder = first not in SUBCOMMANDS and not first.endswith(".toml") and (
        Path(first).is_dir() or glob.has_magic(first)
    )  # fmt: skip
    if first == "--list" or len(leading) - len(extra) > 1 or (leading and folder):
        return parsing.parse(Files, "plantigrade synthesize", words)
    if first.startswith("-"):
        print(usage())
        if first in ("-h", "--help"):
            raise SystemExit(0)
        raise ParameterError(
            f"{first} must come after the task: plantigrade synthesize TASK {first}"
        )
    kind = SUBCOMMANDS.get(first)
    if first.lower().endswith(".toml"):
        from plantigrade.trajopt.tasks.task_file import read_task_file

        file = read_task_file(first)
        kind = SUBCOMMANDS[file.base]
        options["default"] = kind(**file.parameters, **file.options, file=Path(first))
    if kind is None:
        raise ParameterError(f"no task {first!r}; {known_names(first, list(SUBCOMMANDS))}")
    return parsing.parse(kind, f"plantigrade synthesize {first}", words[1:], **options)


def _joint_strength(words: Sequence[str], k: int) -> str:
    """Return a word; ``--joint-strength`` for a ``--strength`` that names a joint."""
    option, equals, value = words[k].partition("=")
    named = value or (words[k + 1] if k + 1 < len(words) else "")
    return (
        f"--joint-{option[2:]}{equals}{value}"
        if option == "--strength" and "=" in named
        else words[k]
    )


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
        f"  {'FILE.toml':{width}}  Your own task.\n\n"
        "`plantigrade synthesize TASK --help` lists the options of a task and those common\n"
        "to all tasks (person, solver, --out, --json, --quiet)."
    )


def summary(folder: Path, metrics: dict[str, Any]) -> str:
    """Return the summary that is printed."""
    m, ok = metrics, metrics["status"] == "ok"
    rows = {
        "verdict": "check passed" if ok else f"CHECK FAILED: {m['status'].split('; ')[0]}",
        "residual force": f"{m['check_root_force_rms_bw_percent']:.2f} % of body weight RMS, "
        f"{m['check_root_force_max_bw_percent']:.2f} % peak; "
        f"slip {m['check_slip_max_mm']:.2f} mm, "
        f"penetration {m['check_penetration_max_mm']:.2f} mm",
    }
    if {"rmse_max_deg", "rmse_max_limit_deg", "rom_error_max_deg"} <= m.keys():
        rows["recording"] = (
            f"hips, knees and ankles within {m['rmse_max_deg']:.1f}° RMS of it (at most "
            f"{m['rmse_max_limit_deg']:g}°), ranges of motion within {m['rom_error_max_deg']:.1f}° "
            f"(at most {m['rom_error_max_limit_deg']:g}°)"
        )
    if m.get("free_times"):
        rows["free times"] = ", ".join(
            f"{name.replace('_', ' ')} {value:.3g}" for name, value in m["free_times"].items()
        )
        rows["free times"] += f" cost least of {len(m['free_times_costs'])} motions"
    if m.get("walking_speed_m_s") is not None:
        rows["walk"] = (
            f"{m['walking_speed_m_s']:.2f} m/s, {m['cadence_steps_min']:.0f} steps/min, "
            f"stance {m['stance_r_pct']:.0f} %"
        )
        if m.get("step_width_m") is not None:
            rows["walk"] += f", step width {100 * m['step_width_m']:.0f} cm"
    if m.get("running_speed_m_s") is not None:
        rows["run"] = (
            f"{m['running_speed_m_s']:.2f} m/s, {m['cadence_steps_min']:.0f} steps/min, "
            f"flight {m['flight_time_s']:.2f} s, peak force {m['ground_force_max_bw']:.1f} body "
            "weights"
        )
    if m.get("cost_of_transport") is not None:
        rows["transport"] = (
            f"cost of transport {m['cost_of_transport']:.2f} (joint work "
            f"{m['joint_work_absolute_j']:.0f} J over {m['displacement_m']:.2f} m)"
        )
    rows |= {page: str(folder / f"{page}.html") for page in ("report", "viewer")}
    lines = (f"  {name:15}  {text}" for name, text in rows.items())
    return "\n".join([f"{folder}: {m['sentence']}", *lines])

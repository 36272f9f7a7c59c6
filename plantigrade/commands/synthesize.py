"""Make a motion from a task alone, or a recorded one physical."""

import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from plantigrade.commands.options import (
    Flag,
    Metres,
    OptionalPath,
    PersonOptions,
    RecordingOptions,
    RunOptions,
    fit_settings,
    optional,
)
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress
from plantigrade.errors import FileError, ParameterError

SAID = 8  # findings that are printed
EVERY = 0.5  # between two lines of progress [s]

Number = Annotated[float | None, optional("NUMBER")]
Count = Annotated[int | None, optional("COUNT")]
Degrees = Annotated[float | None, optional("DEG")]
Seconds = Annotated[float | None, optional("S")]
Speed = Annotated[float | None, optional("M/S")]
Formulation = Annotated[Literal["default", "paper"] | None, optional("{default,paper}")]
Solver = Annotated[Literal["interior-point", "ipopt"] | None, optional("{interior-point,ipopt}")]
Basis = Annotated[
    Literal["trigonometric", "polynomial"] | None, optional("{trigonometric,polynomial}")
]

Told = Annotated[
    tuple[str, ...],
    tyro.conf.arg(metavar="NAME=VALUE", help_behavior_hint=""),
    tyro.conf.UseAppendAction,
]

OPTIONS = {
    "speed": "speed",
    "step_length": "step_length",
    "cadence": "cadence",
    "steps": "steps",
    "periodic": "periodic",
    "turn": "turn",
    "slope": "slope",
    "step_height": "step_height",
    "duration": "duration",
    "chair_height": "chair_height",
    "distance": "distance",
    "jump_height": "height",
    "depth": "depth",
}
"""Options that are parameters of tasks, and what tasks call them."""
TRACK = "track"
ANGLES = ("turn", "slope")  # given in degrees


@dataclass(frozen=True, kw_only=True)
class Command(PersonOptions, RecordingOptions, RunOptions):
    """Make a motion from a task alone, by trajectory optimisation.

    The motion obeys the equations of motion with true contact forces; an independent checker
    decides whether it is valid. Ctrl-C stops with the best so far, which is checked and written.
    """

    task: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="TASK")]
    """What to do: walk, sit-to-stand, side-step, jump, squat, reach, a task file (.toml), or track:
    a recording made physical."""

    recording: OptionalPath = None
    """Recording to track."""
    start: Seconds = None
    """From when it is tracked [s]."""
    stop: Seconds = None
    """To when it is tracked [s]."""

    speed: Speed = None
    """Walking speed [m/s]."""
    step_length: Metres = None
    """From foot to foot [m]; what people prefer at the speed if absent."""
    steps: Count = None
    """Number of steps of a walk from standing to standing."""
    cadence: Number = None
    """Steps per minute instead of the step length [1/min]."""
    periodic: Flag = False
    """A walk that goes on for ever instead of one that starts and stops."""
    turn: Degrees = None
    """How far the way turns to the left [deg]."""
    slope: Degrees = None
    """How far the ground rises along the way, negative downhill [deg]."""
    step_height: Metres = None
    """Height of a step up in the middle of the way, down if negative [m]."""
    duration: Seconds = None
    """How long the motion lasts [s]."""
    chair_height: Metres = None
    """Height of the seat [m]."""
    distance: Metres = None
    """How far to the side, or how far to reach [m]."""
    jump_height: Metres = None
    """How far the centre of mass rises in flight [m]."""
    depth: Metres = None
    """How far a squat goes down [m]."""

    tell: Told = ()
    """Anything else a task may be told, as side=l; may be given several times."""

    formulation: Formulation = None
    """True contact forces (default), or the problem of the paper."""
    solver: Solver = None
    """The banded interior point, or IPOPT as the reference."""
    basis: Basis = None
    """Splines the motion is made of."""
    nodes_per_second: Number = None
    """Nodes a second; more are finer and slower."""
    warm: OptionalPath = None
    """Run folder of a similar motion to start from."""
    tries: int = 1
    """First guesses, all but the first with noise; the cheapest motion is taken."""
    free_timing: bool = False
    """Let a periodic walk choose its own step length, stance and heel rise."""
    strides: int = 2
    """Strides of a periodic walk that are written."""

    def run(self) -> Outcome:
        """Do it.

        Raises:
            ParameterError: If an option does not belong to the task, or its value makes no sense.
            FileError: If the task file or the run to start from cannot be read.
        """
        from plantigrade.workflows import synthesis_folder
        from plantigrade.workflows import synthesize as synthesizing
        from plantigrade.workflows.fit import refuse_existing

        if self.task == TRACK:
            return self._track()
        for option in ("recording", "start", "stop"):
            if getattr(self, option) is not None:
                raise ParameterError(f"{_flag(option)} belongs to the task {TRACK} alone")
        progress = Progress(quiet=self.quiet)
        settings, name = self.settings()
        out = self.out or Path("runs") / f"synthesize-{name}"
        refuse_existing(out, overwrite=self.overwrite)
        watch = Watch(progress)
        with watch.listening():
            made = synthesizing.synthesize_task(settings, watch)
        watch.close(made)
        with progress.step("writing the report and the viewer"):
            folder, metrics = synthesis_folder.write(
                made,
                out,
                title=f"{name.replace('-', ' ').capitalize()}, from the task alone",
                command=["plantigrade", *sys.argv[1:]],
                sources=[Path(self.task)] if _is_file(self.task) else [],
                overwrite=self.overwrite,
            )
        return self._told(progress, made, folder, metrics)

    def _track(self) -> Outcome:
        """Move a recorded motion by forces of the ground.

        Raises:
            ParameterError: If there is no recording, or an option of other tasks is given.
        """
        from plantigrade.workflows import synthesis_folder
        from plantigrade.workflows.fit import FitSettings, refuse_existing
        from plantigrade.workflows.track import TrackSettings, track_recording

        others = [
            o
            for o in (*OPTIONS, "warm", "nodes_per_second", "basis", "solver", "formulation")
            if _given(getattr(self, o))
        ]
        if others:
            raise ParameterError(f"{_flag(others[0])} means nothing to {TRACK}")
        if self.recording is None:
            raise ParameterError(f"{TRACK} needs --recording FILE: C3D, TRC, BVH, AMC or MOT")
        progress = Progress(quiet=self.quiet)
        out = self.out or Path("runs") / f"synthesize-{TRACK}-{self.recording.stem}"
        refuse_existing(out, overwrite=self.overwrite)
        how = TrackSettings(FitSettings(**fit_settings(self)), self.start, self.stop)
        watch = Watch(progress)
        with watch.listening():
            tracked = track_recording(self.recording, how, watch)
        watch.close(tracked.made)
        with progress.step("writing the report and the viewer"):
            folder, metrics = synthesis_folder.write(
                tracked.made,
                out,
                title=f"{self.recording.name}, on forces of the ground",
                command=["plantigrade", *sys.argv[1:]],
                sources=[self.recording],
                overwrite=self.overwrite,
            )
        return self._told(progress, tracked.made, folder, metrics)

    def _told(self, progress: Progress, made, folder: Path, metrics: dict[str, Any]) -> Outcome:
        """Say what the checker found, and return what is printed."""
        for line in metrics["warnings"]:
            progress.warn(line)
        if not made.check.ok:
            words = made.check.words()
            for line in words[:SAID]:
                progress.warn(line)
            if len(words) > SAID:
                progress.warn(f"{len(words) - SAID} more of that kind are in the report")
        return Outcome(summary(folder, metrics), metrics)

    def settings(self) -> tuple[Any, str]:
        """Return what decides the result, and what the run is called.

        Raises:
            ParameterError: If an option does not belong to the task.
            FileError: If the task file cannot be read.
        """
        import math

        from plantigrade.synthesize.tasks.registry import parameters_of
        from plantigrade.synthesize.tasks.task_file import STANDING, parse_task_file
        from plantigrade.workflows.synthesize import SynthesizeSettings

        base, name, text = self.task, self.task, ""
        known: Any = ("duration",)
        if _is_file(self.task):
            path = Path(self.task)
            text = _text_of(path)
            base, name = parse_task_file(text, path).base, path.stem
        if base != STANDING:
            known = parameters_of(base)
        told = {o: v for o in OPTIONS if _given(v := getattr(self, o))}
        wrong = [o for o in told if OPTIONS[o] not in known]
        if wrong:
            options = [_flag(o) for o, parameter in OPTIONS.items() if parameter in known]
            raise ParameterError(
                f"{_flag(wrong[0])} means nothing to {base}; it knows {', '.join(options)}"
            )
        parameters = {
            OPTIONS[o]: math.radians(v) if o in ANGLES else v for o, v in told.items()
        } | told_words(self.tell)
        chosen = ("height", "mass", "sex", "joints", "feet", "formulation", "solver", "basis")
        mine = {n: getattr(self, n) for n in (*chosen, "nodes_per_second", "warm")}
        settings = SynthesizeSettings(
            **{n: v for n, v in mine.items() if v is not None},
            task=base,
            file=text,
            parameters=parameters,
            seed=self.seed,
            tries=self.tries,
            free_timing=self.free_timing,
            strides=self.strides,
        )
        return settings, name


def _given(value: Any) -> bool:
    """Return whether an option was given; a number may be zero."""
    return value is not None and value is not False


class Watch:
    """Says what the solver does, and stops it when asked from the keyboard."""

    def __init__(self, progress: Progress):
        """Open.

        Args:
            progress: Where to say it.
        """
        self.progress = progress
        self.asked = False
        self._stage, self._said = "", -EVERY
        self._last: Any = None

    def __call__(self, stage: str, iterate: Any) -> bool:
        """Say where the solver is, now and then; return whether it shall stop."""
        now = time.perf_counter()
        if stage != self._stage:
            if self._last is not None:
                self._say()
            self._stage, self._said = stage, -EVERY
        self._last = iterate
        if now - self._said >= EVERY:
            self._said = now
            self._say()
        return self.asked

    def close(self, made: Any) -> None:
        """Say how it ended."""
        if self._last is not None:
            self._say()
        synthesis = made.synthesis
        self.progress.say(
            f"{synthesis.status}: {synthesis.iterations} iterations, {synthesis.seconds:.1f} s; "
            f"checked in {len(made.check.time)} frames"
        )

    def _say(self) -> None:
        it = self._last
        worst = f" ({it.worst.replace('_', ' ')})" if it.worst else ""
        self.progress.say(
            f"{self._stage}: iteration {it.number:3d}, cost {it.objective:.4g}, "
            f"off by {it.violation:.1e}{worst}"
        )

    @contextmanager
    def listening(self) -> Iterator[None]:
        """Take the first Ctrl-C as the wish to stop with the best so far, the second as ever."""

        def ask(*_: Any) -> None:
            if self.asked:
                raise KeyboardInterrupt
            self.asked = True
            self.progress.warn("stopping with the best so far; press Ctrl-C again to give up")

        try:
            before = signal.signal(signal.SIGINT, ask)
        except ValueError:  # not the main thread: nobody presses keys here
            yield
            return
        try:
            yield
        finally:
            signal.signal(signal.SIGINT, before)


def told_words(words: tuple[str, ...]) -> dict[str, Any]:
    """Return values by name from words like ``side=l`` or ``target=[0.6,-0.2,1.1]``.

    Example:
        >>> told_words(("side=l", "seat-off=0.3", "back=true"))
        {'side': 'l', 'seat_off': 0.3, 'back': True}

    Raises:
        ParameterError: If a word is not of that form.
    """
    import tomllib

    found: dict[str, Any] = {}
    for word in words:
        name, sign, value = word.partition("=")
        if not (sign and name.strip()):
            raise ParameterError(f"--tell {word}: write NAME=VALUE, as side=l")
        try:
            found[name.strip().replace("-", "_")] = tomllib.loads(f"x = {value}")["x"]
        except tomllib.TOMLDecodeError:
            found[name.strip().replace("-", "_")] = value.strip()
    return found


def _flag(option: str) -> str:
    return f"--{option.replace('_', '-')}"


def _text_of(path: Path) -> str:
    try:
        return path.read_text("utf-8")
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror})") from error
    except UnicodeDecodeError as error:
        raise FileError(
            path, f"is not text ({error})", remedy="name a task file (.toml)"
        ) from error


def _is_file(task: str) -> bool:
    return task.lower().endswith(".toml")


def summary(folder: Path, metrics: dict[str, Any]) -> str:
    """Return what a reader wants to know first."""
    ok = metrics["status"] == "ok"
    lines = [f"{folder}: {metrics['sentence']}"]
    lines.append(f"  verdict          {'passed the check' if ok else 'DID NOT PASS THE CHECK'}")
    rms, most = (metrics[f"check_root_force_{n}_bw_percent"] for n in ("rms", "max"))
    lines.append(
        f"  unexplained      {rms:.2f} % of body weight RMS, {most:.2f} % at most; "
        f"slip {metrics['check_slip_max_mm']:.2f} mm, "
        f"{metrics['check_penetration_max_mm']:.2f} mm in the ground"
    )
    if metrics.get("walking_speed_m_s") is not None:
        lines.append(
            f"  walk             {metrics['walking_speed_m_s']:.2f} m/s, "
            f"{metrics['cadence_steps_min']:.0f} steps/min, "
            f"stance {metrics['stance_r_pct']:.0f} %, "
            f"step width {100 * metrics['step_width_m']:.0f} cm"
        )
    if metrics.get("cost_of_transport") is not None:
        lines.append(
            f"  cost             {metrics['cost_of_transport']:.2f} of transport (joint work "
            f"{metrics['joint_work_absolute_j']:.0f} J over {metrics['displacement_m']:.2f} m)"
        )
    lines += [f"  report           {folder / 'report.html'}"]
    lines += [f"  viewer           {folder / 'viewer.html'}"]
    return "\n".join(lines)

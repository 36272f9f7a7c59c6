"""Make a motion from a task alone: nobody was recorded."""

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
    Metres,
    OptionalPath,
    PersonOptions,
    RunOptions,
    optional,
)
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress
from plantigrade.errors import ParameterError

EVERY = 0.5  # between two lines of progress [s]

Number = Annotated[float | None, optional("NUMBER")]
Count = Annotated[int | None, optional("COUNT")]
Degrees = Annotated[float | None, optional("DEG")]
Seconds = Annotated[float | None, optional("S")]
Speed = Annotated[float | None, optional("M/S")]
Formulation = Annotated[Literal["default", "paper"] | None, optional("{default,paper}")]
Solver = Annotated[Literal["band", "ipopt"] | None, optional("{band,ipopt}")]
Basis = Annotated[
    Literal["trigonometric", "polynomial"] | None, optional("{trigonometric,polynomial}")
]
OptionalFlag = Annotated[bool | None, optional("{True,False}")]

OPTIONS = (
    "speed",
    "step_length",
    "steps",
    "periodic",
    "turn",
    "slope",
    "step_height",
    "duration",
    "chair_height",
    "distance",
    "jump_height",
    "depth",
)
"""Options that are parameters of tasks; which task knows which, the task says."""
ANGLES = ("turn", "slope")  # given in degrees


@dataclass(frozen=True, kw_only=True)
class Command(PersonOptions, RunOptions):
    """Make a motion from a task alone, by trajectory optimisation; nobody was recorded.

    The motion obeys the equations of motion with true contact forces; an independent checker
    decides whether it is valid. Ctrl-C stops with the best so far, which is checked and written.
    """

    task: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="TASK")]
    """What to do: walk, sit-to-stand, side-step, jump, squat, reach, or a task file (.toml)."""

    speed: Speed = None
    """Walking speed [m/s]."""
    step_length: Metres = None
    """From foot to foot [m]; what people prefer at the speed if absent."""
    steps: Count = None
    """Number of steps of a walk from standing to standing."""
    periodic: OptionalFlag = None
    """A walk that goes on for ever instead of one that starts and stops."""
    turn: Degrees = None
    """How far the way turns to the left [deg]."""
    slope: Degrees = None
    """Slope of the ground, upwards positive [deg]."""
    step_height: Metres = None
    """Height of a step that is walked onto [m]."""
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

    formulation: Formulation = None
    """True contact forces (default), or the problem of the paper."""
    solver: Solver = None
    """The banded interior point, or IPOPT as the reference."""
    basis: Basis = None
    """Splines the motion is made of."""
    density: Number = None
    """Nodes a second; more are finer and slower."""
    warm: OptionalPath = None
    """Run folder of a similar motion to start from."""
    tries: int = 1
    """First guesses, all but the first with noise; the cheapest motion is taken."""
    strides: int = 2
    """Strides of a periodic walk that are written."""

    def run(self) -> Outcome:
        """Do it.

        Raises:
            ParameterError: If an option does not belong to the task, or its value makes no sense.
            FileError: If the task file or the run to start from cannot be read.
        """
        from plantigrade.workflows import synthesis_folder, synthesizing
        from plantigrade.workflows.fitting import refuse_existing

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
        for line in metrics["warnings"]:
            progress.warn(line)
        for line in () if metrics["status"] == "ok" else made.check.words():
            progress.warn(line)
        return Outcome(summary(folder, metrics), metrics)

    def settings(self) -> tuple[Any, str]:
        """Return what decides the result, and what the run is called.

        Raises:
            ParameterError: If an option does not belong to the task.
            FileError: If the task file cannot be read.
        """
        import math

        from plantigrade.workflows.synthesizing import SynthesizeSettings
        from plantigrade.workflows.task_catalogue import known_parameters, read_task_file

        name, given = self.task, {}
        if _is_file(self.task):
            path = Path(self.task)
            given, name = read_task_file(path), path.stem
        task = given.pop("task", name)
        parameters = dict(given.pop("parameters", {}))
        told = {o: getattr(self, o) for o in OPTIONS if getattr(self, o) is not None}
        known = known_parameters(task)
        wrong = [o for o in told if o not in known]
        if wrong:
            options = [f"--{o.replace('_', '-')}" for o in OPTIONS if o in known]
            raise ParameterError(
                f"--{wrong[0].replace('_', '-')} means nothing to {task}; it knows "
                f"{', '.join(options) or 'no such option'}"
            )
        for option in told.keys() & set(ANGLES):
            told[option] = math.radians(told[option])
        chosen = ("height", "mass", "sex", "joints", "feet", "formulation", "solver", "basis")
        mine = {n: getattr(self, n) for n in (*chosen, "density", "warm")}
        given |= {n: v for n, v in mine.items() if v is not None}
        settings = SynthesizeSettings(
            **given,
            task=task,
            parameters=parameters | told,
            seed=self.seed,
            tries=self.tries,
            strides=self.strides,
        )
        return settings, name


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

"""Simulate a person under a controller."""

import re
import textwrap
from collections.abc import Collection, Sequence
from dataclasses import dataclass, field, fields, make_dataclass
from functools import partial
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import tyro

from plantigrade.commands import parsing
from plantigrade.commands.batch_options import BatchOptions
from plantigrade.commands.live_options import LiveOptions, written_live
from plantigrade.commands.options import PageOptions, command_line
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.simulate_batch import several, varied
from plantigrade.errors import ParameterError
from plantigrade.options import Flag, is_policy, optional
from plantigrade.workflows.controller_options import (
    OPTIONS,
    AnyOptions,
    SpringOptions,
    StepOptions,
    WalkOptions,
    users,
)
from plantigrade.workflows.simulate_settings import SimulateSettings

PROGRAM, INDENT = "plantigrade simulate", 6 * " "


@dataclass(frozen=True, kw_only=True)
class Command(
    SimulateSettings,
    AnyOptions,
    SpringOptions,
    StepOptions,
    WalkOptions,
    LiveOptions,
    PageOptions,
    BatchOptions,
):
    """Simulate a person, standing or moving, under a controller.

    A recording is fitted first, a run is used as it is; without either the person stands. The exit
    code is 0 if the person is on their feet at the end, 3 after a fall or a diverged simulation.

    With several recordings, a folder of them, --seeds or --vary a batch is run and tabulated; a
    fall is then a valid result, and the exit code is 3 only if a member failed or diverged. An
    interrupted batch continues where it stopped.
    """

    sources: Annotated[
        tyro.conf.Positional[tuple[Path, ...]], optional("[FILE|RUN|FOLDER ...]")
    ] = ()
    """Recording or run folder whose motion is simulated, or several, or folders or patterns of
    recordings."""
    seeds: int = 1
    """Number of simulations, with consecutive seeds from --seed on."""
    vary: Annotated[
        tuple[tuple[str, ...], ...], tyro.conf.UseAppendAction, optional("OPTION VALUE [VALUE ...]")
    ] = ()
    """Option to vary and its values, such as ground flat slope:5; repeatable, all combined."""
    live: Flag = False
    """Run interactively in the browser: push, drag, change ground and controller."""

    ranges = {"seeds": (1, 100000, "")}

    def __post_init__(self):
        super().__post_init__()
        if self.live and (self.seeds > 1 or self.vary or self.listed or len(self.sources) > 1):
            raise ParameterError("several simulations are a batch, which cannot be --live")

    def run(self) -> Outcome:
        """Simulate and write the run folder."""
        from plantigrade.commands.progress import Progress
        from plantigrade.workflows.simulate import run_simulation

        if self.live:
            return self.show()
        sources, folders = self._sources()
        if folders or len(sources) > 1 or self.seeds > 1 or self.vary:
            settings = SimulateSettings.of(self)
            return several(self, settings, sources, varied(self.vary), self.seeds)
        self.refuse_batch_options("name several recordings, or add --seeds or --vary")
        progress = Progress(quiet=self.quiet)
        source = sources[0] if sources else None
        what = source or Path(self.motion or "standing")
        self.refuse_existing(f"simulate-{what.stem}")
        settings = SimulateSettings.of(self)
        run = run_simulation(source, settings, step=progress.step, command=command_line())
        return self.written(run, progress, summary)  # how it ended is among its notes

    def _sources(self) -> tuple[list[Path], bool]:
        """Return the recordings and runs that are simulated, and whether they make a batch."""
        from plantigrade.record.metrics import METRICS
        from plantigrade.workflows.fit_many import recordings

        runs = [path for path in self.sources if (path / METRICS).is_file()]
        others = [path for path in self.sources if path not in runs]
        if not others and self.listed is None:
            return runs, False
        given = recordings(others, self.listed)
        return [*runs, *given.files], given.several

    def show(self) -> Outcome:
        """Simulate in the browser; write the run where one is named, or where Save is pressed."""
        from plantigrade.commands.progress import Progress
        from plantigrade.workflows.live import live

        progress = Progress(quiet=self.quiet)
        source = self.sources[0] if self.sources else None
        where = {"port": self.port, "open": not self.no_open}
        how = {"step": progress.step, "command": command_line()}
        session = partial(live, source, SimulateSettings.of(self), **where, **how)
        return written_live(self, progress, session, summary)


def parse(words: Sequence[str]) -> Command:
    """Return the command that words fill; the help has the options and settings of a controller.

    Raises:
        SystemExit: If the parser has printed its help (code 0) or its complaint (code 2).
        ParameterError: If a value is not allowed.
    """
    if not {"-h", "--help"} & {*words}:
        return parsing.parse(Command, PROGRAM, words)
    name = controller_in(words)
    others = [each for each in OPTIONS if name is None or name not in users(each)]
    own = "Options of a controller: plantigrade simulate --controller NAME --help"
    own = own if name is None else settings_help(name)
    try:
        return parsing.parse(hidden(Command, others), PROGRAM, words)
    finally:
        print(own)


def hidden(kind: type, names: Collection[str]) -> type:
    """Return a dataclass of options of which the help shows all but some."""
    hints = get_type_hints(kind, include_extras=True)
    shut = [
        (f.name, tyro.conf.Suppress[hints[f.name]], field(default=f.default))
        for f in fields(kind)
        if f.name in names
    ]
    return make_dataclass(kind.__name__, shut, bases=(kind,), frozen=True, kw_only=True)


def controller_in(words: Sequence[str]) -> str | None:
    """Return the controller that is named; None if there is none.

    Example:
        >>> controller_in(["walk.c3d", "--controller=replay", "--help"])
        'replay'
    """
    for word, following in zip(words, (*words[1:], ""), strict=True):
        name, equals, value = word.partition("=")
        if name == "--controller":
            return value if equals else following or None
    return None


def settings_help(name: str) -> str:
    """Return what can be set of a controller, for its help."""
    from plantigrade.control.choices import CONTROLLERS, checked
    from plantigrade.control.numbers import numbers_of

    if is_policy(name):
        return "A trained policy has no settings."
    kind = CONTROLLERS[checked(name)].settings
    if kind is None:
        return f"{name} has no settings."
    lines = [f"settings of {name} (--set NAME=VALUE), with their values:"]
    for each in numbers_of(kind()):
        meaning = re.sub(r":\w+:|`+|\]_", lambda mark: "]" * (mark[0] == "]_"), each.meaning)
        lines.append(f"  {each.name}={word_of(each.value)}")
        lines += textwrap.wrap(meaning, 78, initial_indent=INDENT, subsequent_indent=INDENT)
    return "\n".join(lines)


def word_of(value: Any) -> str:
    """Return a value as the command line takes it.

    Example:
        >>> word_of((0.25, 0.5)), word_of(True)
        ('0.25,0.5', 'true')
    """
    if isinstance(value, tuple):
        return ",".join(map(word_of, value))
    return str(value).lower() if isinstance(value, bool) else str(value)


def summary(folder: Path, metrics: dict[str, Any]) -> str:
    """Return the summary that is printed."""
    seconds = metrics["seconds"]["simulate"]
    ended = "on their feet at the end" if metrics["status"] == "ok" else metrics["status"]
    lines = [
        f"{folder}: {metrics['duration_s']:.2f} s simulated in {seconds:.1f} s, {ended}",
        f"  controller       {metrics['controller']}; motor torques up to "
        f"{metrics['motor_torque_max_pct']:.0f} % of joint strength",
        f"  vertical force   {metrics['vertical_force_mean_bw']:.2f} body weights (mean), "
        f"{metrics['vertical_force_max_bw']:.2f} (peak)",
    ]
    if "tracking_error_rms_deg" in metrics:
        lines.append(f"  tracking error   {metrics['tracking_error_rms_deg']:.1f}° RMS")
    if "trunk_lean_mean_followed_deg" in metrics:
        ahead, aside, ahead_was, aside_was = (
            metrics[f"trunk_{what}{of}_deg"]
            for of in ("", "_followed")
            for what in ("lean_mean", "sideways_rms")
        )
        lines.append(
            f"  trunk            {ahead:.1f}° forward lean (reference {ahead_was:.1f}°), "
            f"{aside:.1f}° RMS sideways (reference {aside_was:.1f}°)"
        )
    lines += [
        f"  report           {folder / 'report.html'}",
        f"  viewer           {folder / 'viewer.html'}",
    ]
    return "\n".join(lines)

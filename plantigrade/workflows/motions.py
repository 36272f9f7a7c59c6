"""The motions of ``plantigrade synthesize``: a task, a task file, a paper's motion, or tracking."""

import sys
import time
from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any

from plantigrade.errors import ParameterError, known_names
from plantigrade.extras import require
from plantigrade.options import as_path, refuse_unknown
from plantigrade.record import Run
from plantigrade.signatures import Option, of_variants, options_of, takes
from plantigrade.threads import on_one_thread
from plantigrade.trajopt.solve import Progress
from plantigrade.trajopt.solvers.result import Iterate
from plantigrade.trajopt.tasks.settings import TASKS
from plantigrade.trajopt.tasks.task_file import read_task_file
from plantigrade.trajopt.warm_start import WarmStart
from plantigrade.workflows.settings import (
    PAPER,
    TRACK,
    PaperSettings,
    Settings,
    SolveSettings,
    TrackSettings,
)
from plantigrade.workflows.steps import Step, silent
from plantigrade.workflows.synthesize import Origin, synthesize_paper, synthesize_task

INTERVAL = 0.2  # [s] between two updates; chosen
RECORDING = Option("recording", str | Path | None, None, f"Recording to track ({TRACK}).")
_OF_ALL = options_of(SolveSettings)
_OF_SOME = of_variants(
    {**TASKS, TRACK: TrackSettings, PAPER: PaperSettings}, without=[o.name for o in _OF_ALL]
)
SYNTHESIS_OPTIONS = [*_OF_SOME, RECORDING, *_OF_ALL]
"""Options of a synthesis: those of one task or a few, then those of all."""


@takes(more=SYNTHESIS_OPTIONS)
def synthesize(
    task: str | Path,
    settings: Settings | None = None,
    *,
    progress: Progress | None = None,
    **options: Any,
) -> Run:
    """Generate a motion from a task by trajectory optimisation, and check it.

    Args:
        task: A task of :data:`~plantigrade.trajopt.tasks.settings.TASKS` (``"walk"``,
            ``"sit-to-stand"``, …), a task file (``"mine.toml"``), ``"zhakatayev2023"`` for a
            motion as the paper sets it, or ``"track"`` to move a ``recording`` by forces.
        settings: How it is solved: ``SolveSettings``, for the last two ``PaperSettings`` or
            ``TrackSettings``; options replace its fields.
        progress: Called with every iteration; returning True stops with the best so far.
        options: Parameters of the task (SI units and radians), and fields of ``settings``.

    Raises:
        ParameterError: If there is no such task or option, or a value is not allowed.
        FileError: If a file or the run to start from cannot be read.
        FitError: If a recording to track cannot be fitted.
        ReproduceError: If a recording to track is not on level ground.
        MissingExtra: If the extra ``synthesis`` is not installed.

    Example:
        >>> import plantigrade as pg
        >>> run = pg.synthesize("walk", speed=1.3, periodic=True)  # doctest: +SKIP
    """
    return run_synthesis(task, settings, options, progress=progress or cell_progress())


@on_one_thread
def run_synthesis(
    task: str | Path,
    settings: Settings | None,
    options: Mapping[str, Any],
    *,
    warm: WarmStart | None = None,
    progress: Progress | None = None,
    step: Step = silent,
    command: str = "",
) -> Run:
    """Generate a motion: what :func:`synthesize` and the command do.

    ``warm`` is a similar motion for a task to start from, ``step`` shows progress of the fit of
    ``"track"``, and ``command`` is for the provenance.
    """
    require("casadi", "synthesis")
    word, options = str(as_path(task, "a task")), {**options}
    common: dict[str, Any] = {"command": command}
    if word == TRACK:
        from plantigrade.workflows.track import track  # what reads and fits recordings

        recording = options.pop(RECORDING.name, None)
        if recording is None:
            raise ParameterError("track needs recording=FILE")
        path = as_path(recording, "recording")
        refuse_unknown(word, options, [RECORDING.name, *_names(TrackSettings)])
        how = TrackSettings.given(word, settings, options)
        title = f"{path.name}, tracked with ground forces"
        origin = Origin(title, name=_folder(word, path.stem), **common)
        return track(path, how, progress=progress, step=step, origin=origin)
    if word == PAPER:
        how = PaperSettings.given(word, settings, options)
        title = f"{how.motion.replace('-', ' ').capitalize()}, as in the paper"
        origin = Origin(title, name=_folder(word, how.motion), **common)
        return synthesize_paper(how, progress=progress, origin=origin)
    file = read_task_file(word) if word.lower().endswith(".toml") else None
    base = word if file is None else file.base
    if base not in TASKS:
        raise ParameterError(f"no task {word!r}; {known_names(word, (*TASKS, TRACK, PAPER))}")
    own = _names(TASKS[base])
    refuse_unknown(word, options, [*own, *_names(SolveSettings)])
    parameters = {} if file is None else dict(file.parameters)
    parameters |= {name: value for name, value in options.items() if name in own}
    how = {} if file is None else dict(file.options)
    how |= {name: value for name, value in options.items() if name not in own}
    name = base if file is None else Path(word).stem
    title = f"{name.replace('-', ' ').capitalize()}, generated from the task"
    files = () if file is None else (Path(word),)
    return synthesize_task(
        TASKS[base](**parameters),
        SolveSettings.given(word, settings, how),
        file=file,
        warm=warm,
        progress=progress,
        origin=Origin(title, files=files, name=_folder(name), **common),
    )


def _names(kind: type) -> list[str]:
    return [f.name for f in fields(kind)]


def _folder(*words: str) -> str:
    return "-".join(("synthesize", *words))


def cell_progress() -> Progress | None:
    """Return a line that follows the iterations in place; None outside of a Jupyter kernel."""
    shell: Any = _shell()
    if shell is None:
        return None
    from IPython.display import display

    line: Any = display({"text/plain": "starting"}, raw=True, display_id=True)
    last = -INTERVAL

    def follow(stage: str, iterate: Iterate) -> None:
        nonlocal last
        now = time.monotonic()
        if iterate.number == 0 or now - last >= INTERVAL:
            last = now
            line.update({"text/plain": iteration_text(stage, iterate)}, raw=True)

    return follow


def iteration_text(stage: str, iterate: Iterate) -> str:
    """Return an iteration in one line."""
    text = f"{stage}: iteration {iterate.number}, largest violation {iterate.violation:.1e}"
    return text if iterate.seconds != iterate.seconds else f"{text}, {iterate.seconds:.0f} s"


def _shell() -> Any:
    """Return the shell of the running Jupyter kernel; None elsewhere."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell if hasattr(shell, "kernel") else None

"""A task that is solved again in the browser whenever somebody changes it."""

import time as clock
import traceback
import webbrowser
from collections.abc import Callable, Mapping
from pathlib import Path
from threading import Event
from typing import Any

from plantigrade.errors import ParameterError, PlantigradeError, known_names
from plantigrade.live.task_controls import Value, controls_of, options_from, strengths_in
from plantigrade.live.task_session import Progress, TaskSession
from plantigrade.live.task_session import run as solve_until
from plantigrade.options import as_path
from plantigrade.pages.live_task import LiveTask
from plantigrade.record import Record, Run
from plantigrade.trajopt.tasks.settings import TASKS
from plantigrade.trajopt.tasks.task_file import read_task_file
from plantigrade.trajopt.warm_start import WarmStart
from plantigrade.workflows.live_page import look_on
from plantigrade.workflows.motions import run_synthesis
from plantigrade.workflows.settings import SolveSettings


def prepare(
    task: str | Path, options: Mapping[str, Any], *, command: str = ""
) -> tuple[str, TaskSession]:
    """Return the name of a task and its session, not yet solved.

    Args:
        task: A task, or a task file, as ``synthesize`` takes them.
        options: Its parameters, and fields of ``SolveSettings``.
        command: Command line, for the provenance.

    Raises:
        ParameterError: If there is no such task, or it cannot be changed while it is solved.
        FileError: If a task file cannot be read.
    """
    word = str(as_path(task, "a task"))
    file = read_task_file(word) if word.lower().endswith(".toml") else None
    base = word if file is None else file.base
    if base not in TASKS:
        raise ParameterError(f"no task {word!r} to change live; {known_names(word, list(TASKS))}")
    given = {} if file is None else {**file.parameters, **file.impairments}
    given |= options
    own = {f: v for f, v in given.items() if f in TASKS[base].__dataclass_fields__}
    SolveSettings.given(word, None, {f: v for f, v in given.items() if f not in own})  # or refuses
    strengths, others = strengths_in(given.get("joint_strength", ()))
    controls = controls_of(TASKS[base](**own), strengths)
    by_name = {control.name: control for control in controls}

    def solve(values: Mapping[str, Value], warm: Record | None, progress: Progress) -> Run:
        chosen = options_from(by_name, values)
        words = (*others, *chosen.pop("joint_strength", ()))
        return run_synthesis(
            task,
            None,
            {**options, **chosen, "joint_strength": words},
            warm=None if warm is None else WarmStart.of_record(warm),
            progress=progress,
            command=command,
        )

    return base, TaskSession(controls, solve)


def live_task(
    task: str | Path,
    *,
    port: int = 8080,
    open: bool = True,  # noqa: A002 - the word of the command line's option
    show: Callable[[str], object] = webbrowser.open,
    tell: Callable[[str], None] = print,
    save: Callable[[Run], Run] | None = None,
    stop: Event | None = None,
    command: str = "",
    **options: Any,
) -> Run:
    """Solve a task in the browser until interrupted, again whenever it is changed there.

    Args:
        task: A task, or a task file, as ``synthesize`` takes them.
        port: Port to listen on; the next free one is taken where it is in use.
        open: Whether to open the page.
        show: Opens the page at an address; in the default browser by default.
        tell: Called with the address.
        save: Saves a run; called by its button, which is shown if this is given.
        stop: Ends the session when set (for tests and notebooks).
        command: Command line, for the provenance.
        options: Further arguments of ``synthesize``.

    Returns:
        The run that is shown at the end.

    Raises:
        PlantigradeError: As ``synthesize`` does.
        Exception: A fault of the solver.
    """
    stop = stop or Event()
    name, session = prepare(task, options, command=command)
    began = clock.perf_counter()
    tell("solving the task for the first time …")
    session.advance()
    if session.shown is None:
        raise ParameterError(session.message)
    tell(f"solved in {clock.perf_counter() - began:.1f} s")
    page = LiveTask(
        session, task=name, port=port, title=session.shown.run.title, can_save=save is not None
    )
    failed: list[BaseException] = []

    look_on(
        page,
        lambda: solve_until(session),
        "solver",
        stop,
        failed,
        tell=tell,
        show=show if open else None,
        save=lambda: _save(page, save),
        end=session.ended.set,
    )
    if failed:
        tell("".join(traceback.format_exception(failed[0])))
        raise failed[0]
    return session.shown.run


def _save(page: LiveTask, save: Callable[[Run], Run] | None) -> None:
    """Save the motion that is shown, and say where, or why not."""
    solved = page.session.shown
    if save is None or solved is None:
        return
    try:
        page.say(f"Saved: {save(solved.run).folder}")
    except PlantigradeError as error:
        page.say(str(error))

"""Free times of a task: which they are, and what a run says of those that were found."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.trajopt.free_times import FoundTimes, TaskAt
from plantigrade.trajopt.tasks.free_time import FreeTime
from plantigrade.trajopt.tasks.gait_parameters import (
    free_walking_times,
    gait_parameters,
    with_walking_times,
)
from plantigrade.trajopt.tasks.gait_settings import WalkSettings
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.tasks.task_file import TaskFile
from plantigrade.trajopt.tasks.task_settings import TaskSettings
from plantigrade.trajopt.tasks.walking import periodic_walk
from plantigrade.workflows.settings import SolveSettings
from plantigrade.workflows.task import refined, the_task


def refuse_beside_free_times(how: SolveSettings) -> None:
    """Refuse what means nothing where times are free: every trial is solved one way."""
    plain = SolveSettings()
    for name in ("solver", "warm", "restarts"):
        if getattr(how, name) != getattr(plain, name):
            raise ParameterError(f"{name} has no effect with free times: leave out one")


def free_times(
    human: Human, parameters: TaskSettings, how: SolveSettings, file: TaskFile | None = None
) -> tuple[tuple[FreeTime, ...], TaskAt]:
    """Return the free times of a task, none if there are none, and the task by their values.

    Raises:
        ParameterError: If one is no time of the task, or its bounds or guess are not allowed.
    """
    own = how.free_times(parameters)
    written = () if file is None else file.free_times
    if isinstance(parameters, WalkSettings) and parameters.optimise_timing:
        if own or file is not None:
            raise ParameterError("optimise_timing has its own free times: leave out others")
        return _walking_times(human, parameters, how)
    if names := {t.name for t in own} & {t.name for t in written}:
        raise ParameterError(f"free time {min(names)} is given twice, in the file and as an option")

    def task(values: Mapping[str, float]) -> MotionTask:
        chosen, then = {t.name: values[t.name] for t in own}, file
        if file is not None and written:
            then = file.at(values)
            kept = {n for n in file.free_parameters if getattr(parameters, n) != file.parameters[n]}
            chosen = {n: then.parameters[n] for n in file.free_parameters - kept} | chosen
        return the_task(human, replace(parameters, **chosen), how, then)

    return (*own, *written), task


def _walking_times(
    human: Human, parameters: WalkSettings, how: SolveSettings
) -> tuple[tuple[FreeTime, ...], TaskAt]:
    """Return the free times of a periodic walk, and the walk by their values."""
    chosen = {"step_length": parameters.step_length, "cadence": parameters.cadence}
    usual = gait_parameters(human, parameters.speed, **chosen)

    def task(values: Mapping[str, float]) -> MotionTask:
        p = with_walking_times(usual, values)
        return how.task(human, refined(periodic_walk(human, p, slope=parameters.slope), how))

    return free_walking_times(usual), task


def free_time_figures(found: FoundTimes) -> dict[str, Any]:
    """Return figures of a search for times."""
    return {
        "restarts": 1,
        "free_times": {name: float(value) for name, value in found.times.items()},
        "free_times_at_bounds": list(found.at_bounds),
        "free_times_costs": [float(c) for c in found.costs],
    }


def free_time_words(found: FoundTimes) -> list[str]:
    """Return the times that were found, in words."""
    return [f"{name.replace('_', ' ')} {value:.3g} found" for name, value in found.times.items()]


def free_time_notes(found: FoundTimes) -> list[str]:
    """Return what the user should know of a search for times."""
    notes = []
    if found.at_bounds:
        names = " and ".join(name.replace("_", " ") for name in found.at_bounds)
        notes.append(f"On a bound, beyond which the cost may be lower: {names}.")
    if found.stopped:
        notes.append("The search for times was stopped; this is the best motion so far.")
    return notes

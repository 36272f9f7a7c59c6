"""The person and the task that options name."""

from dataclasses import asdict, replace

from plantigrade.models import Human
from plantigrade.trajopt.tasks.registry import task_for
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.tasks.task_file import TaskFile
from plantigrade.trajopt.tasks.task_settings import TaskSettings
from plantigrade.workflows.settings import DEFAULT_JOINTS, PaperSettings, SolveSettings


def person(how: SolveSettings | PaperSettings) -> Human:
    """Return the person who does a task."""
    human = replace(how, joints=how.joints or DEFAULT_JOINTS).human()
    return how.person(human) if isinstance(how, SolveSettings) else human


def the_task(
    human: Human, parameters: TaskSettings, how: SolveSettings, file: TaskFile | None = None
) -> MotionTask:
    """Return the task of a person, on the basis and the mesh asked for.

    Raises:
        ParameterError: If a value is out of range for this person.
    """
    if file is None:
        task = task_for(human, parameters)
    else:
        task = replace(file, parameters=asdict(parameters)).task(human)
    return how.task(human, refined(task, how))


def refined(task: MotionTask, how: SolveSettings) -> MotionTask:
    """Return a task on the basis and the mesh of the options."""
    given = {"basis": how.basis, "nodes_per_second": how.nodes_per_second}
    return replace(task, **{name: x for name, x in given.items() if x is not None})

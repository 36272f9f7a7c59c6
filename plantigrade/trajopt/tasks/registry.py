"""Tasks by name: which function makes the task of which settings."""

from collections.abc import Callable, Mapping
from typing import Any

from plantigrade.models import Human
from plantigrade.trajopt.tasks import gait_settings, settings
from plantigrade.trajopt.tasks.chair import sit_to_stand
from plantigrade.trajopt.tasks.getting_up import get_up
from plantigrade.trajopt.tasks.hopping import hop
from plantigrade.trajopt.tasks.jumping import jump, take_off
from plantigrade.trajopt.tasks.lifting import lift
from plantigrade.trajopt.tasks.reach import reach
from plantigrade.trajopt.tasks.running import run
from plantigrade.trajopt.tasks.settings import settings_for
from plantigrade.trajopt.tasks.side_step import side_step
from plantigrade.trajopt.tasks.standing import squat, stand
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.tasks.task_settings import TaskSettings
from plantigrade.trajopt.tasks.walking import walk
from plantigrade.trajopt.tasks.walking_backward import walk_backward
from plantigrade.trajopt.tasks.walking_sideways import walk_sideways

MAKERS: Mapping[type[TaskSettings], Callable[[Human, Any], MotionTask]] = {
    gait_settings.WalkSettings: walk,
    gait_settings.WalkBackwardSettings: walk_backward,
    gait_settings.WalkSidewaysSettings: walk_sideways,
    gait_settings.RunSettings: run,
    gait_settings.HopSettings: hop,
    settings.SitToStandSettings: sit_to_stand,
    settings.StandToSitSettings: sit_to_stand,
    settings.GetUpSettings: get_up,
    settings.SquatSettings: squat,
    settings.ReachSettings: reach,
    settings.LiftSettings: lift,
    settings.SideStepSettings: side_step,
    settings.JumpSettings: jump,
    settings.TakeOffSettings: take_off,
    settings.StandSettings: stand,
}


def task_for(human: Human, parameters: TaskSettings) -> MotionTask:
    """Return the task of a person.

    Raises:
        ParameterError: If a value is out of range for that person.
    """
    return MAKERS[type(parameters)](human, parameters)


def make_task(name: str, human: Human, parameters: Mapping[str, Any] | None = None) -> MotionTask:
    """Return a task by name.

    Args:
        name: One of :data:`~plantigrade.trajopt.tasks.settings.TASKS`.
        parameters: Parameters of the task; the defaults if absent.

    Raises:
        ParameterError: If there is no such task or parameter, or a value is out of range.
    """
    return task_for(human, settings_for(name, **(parameters or {})))

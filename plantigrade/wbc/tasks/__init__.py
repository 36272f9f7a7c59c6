"""Tasks: what a motion is to achieve, each a small class with one interface.

:class:`Task` asks for an error, its Jacobian and its drift; an ordered list of tasks is a
hierarchy (:mod:`plantigrade.wbc.ordered_motion`).
"""

from plantigrade.wbc.tasks.com import ComTask
from plantigrade.wbc.tasks.contact import ContactTask
from plantigrade.wbc.tasks.floor import FloorTask
from plantigrade.wbc.tasks.orientation import OrientationTask
from plantigrade.wbc.tasks.point import PointTask
from plantigrade.wbc.tasks.posture import PostureTask
from plantigrade.wbc.tasks.task import Task

__all__ = [
    "ComTask",
    "ContactTask",
    "FloorTask",
    "OrientationTask",
    "PointTask",
    "PostureTask",
    "Task",
]

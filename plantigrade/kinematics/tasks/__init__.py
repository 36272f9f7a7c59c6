"""Tasks: what a motion is to achieve, each a small class with one interface.

:class:`Task` asks for an error, its Jacobian and its drift; an ordered list of tasks is a
hierarchy (:mod:`plantigrade.reproduce.ordered_motion`).
"""

from plantigrade.kinematics.tasks.com import ComTask
from plantigrade.kinematics.tasks.contact import ContactTask
from plantigrade.kinematics.tasks.floor import FloorTask
from plantigrade.kinematics.tasks.orientation import OrientationTask
from plantigrade.kinematics.tasks.point import PointTask
from plantigrade.kinematics.tasks.posture import PostureTask
from plantigrade.kinematics.tasks.task import Task

__all__ = [
    "ComTask",
    "ContactTask",
    "FloorTask",
    "OrientationTask",
    "PointTask",
    "PostureTask",
    "Task",
]

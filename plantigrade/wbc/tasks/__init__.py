"""Tasks of a motion, each a small class with one interface.

A :class:`Task` gives an error, its Jacobian and its bias acceleration; an ordered list of tasks is
a hierarchy (:mod:`plantigrade.wbc.order`).
"""

from plantigrade.wbc.tasks.contact import ContactTask, FloorTask, SoleContactTask
from plantigrade.wbc.tasks.landing import LandingTask, PlacingHeelTask
from plantigrade.wbc.tasks.momentum import AngularMomentumTask, ComTask
from plantigrade.wbc.tasks.point import OrientationTask, PointTask
from plantigrade.wbc.tasks.posture import PassingPosture, PostureOnCurve, PostureTask
from plantigrade.wbc.tasks.task import Task

__all__ = [
    "AngularMomentumTask",
    "ComTask",
    "ContactTask",
    "FloorTask",
    "LandingTask",
    "OrientationTask",
    "PassingPosture",
    "PlacingHeelTask",
    "PointTask",
    "PostureOnCurve",
    "PostureTask",
    "SoleContactTask",
    "Task",
]

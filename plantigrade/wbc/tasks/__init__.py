"""Tasks of a motion, each a small class with one interface.

A :class:`Task` gives an error, its Jacobian and its bias acceleration, and makes rows of the
generalised acceleration: of a hierarchy, where tasks are in strict order
(:mod:`plantigrade.wbc.order`), or of a weighted program (:mod:`plantigrade.wbc.whole_body`).
"""

from plantigrade.wbc.tasks.contact import ContactTask, FloorTask, SoleContactTask
from plantigrade.wbc.tasks.landing import LandingTask, PlacingHeelTask
from plantigrade.wbc.tasks.momentum import AngularMomentumTask, ComTask, LinearMomentumTask
from plantigrade.wbc.tasks.point import AlignmentTask, OrientationTask, PointTask
from plantigrade.wbc.tasks.posture import PostureTask, TimedPosture
from plantigrade.wbc.tasks.task import Task

__all__ = [
    "AlignmentTask",
    "AngularMomentumTask",
    "ComTask",
    "ContactTask",
    "FloorTask",
    "LandingTask",
    "LinearMomentumTask",
    "OrientationTask",
    "PlacingHeelTask",
    "PointTask",
    "PostureTask",
    "SoleContactTask",
    "Task",
    "TimedPosture",
]

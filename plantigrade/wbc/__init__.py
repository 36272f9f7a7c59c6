"""Whole-body control: tasks, strict orders and weighted programs of them, forces, friction, limits.

A weighted program finds accelerations, torques and contact forces that serve all tasks best; a
controller of your own is a few tasks and one call of it per tick::

    program = WholeBody(human)
    rows = [task.rows(body) for task in (feet, centre_of_mass)]
    answer = program.solve(body, touching, rows, desired=posture.acceleration(body, time))

The tasks are in :mod:`plantigrade.wbc.tasks`. A strict order of them moves a body, with or without
forces: :func:`move`.
"""

from plantigrade.wbc import tasks
from plantigrade.wbc.forces import Footing
from plantigrade.wbc.hierarchy import solve_hierarchy
from plantigrade.wbc.joint_limits import JointLimits
from plantigrade.wbc.level import Level
from plantigrade.wbc.order import TaskOrder
from plantigrade.wbc.rows import PointRows, Rows
from plantigrade.wbc.stepping import OrderedMotion, move
from plantigrade.wbc.touching import Touching
from plantigrade.wbc.whole_body import Answer, WholeBody

__all__ = [
    "Answer",
    "Footing",
    "JointLimits",
    "Level",
    "OrderedMotion",
    "PointRows",
    "Rows",
    "TaskOrder",
    "Touching",
    "WholeBody",
    "move",
    "solve_hierarchy",
    "tasks",
]

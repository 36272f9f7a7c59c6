"""Motion from a task alone: tasks and their terms, trajectories on splines, and who solves them.

A person and a task become a motion in three lines::

    task = make_task("walk", human, {"periodic": True})
    solution = synthesize(ContactBody.for_plan(human, task.plan), task)
    record = solution.record()

Names are loaded when they are first used. A run with its check and its folder is made by
``plantigrade.synthesize("walk")``.
"""

from typing import TYPE_CHECKING

from plantigrade.lazy import lazy

if TYPE_CHECKING:
    from plantigrade.trajopt.problem.builder import ProblemBuilder
    from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
    from plantigrade.trajopt.problem.contact_body import ContactBody
    from plantigrade.trajopt.problem.nlp import PeriodicClosure, Problem
    from plantigrade.trajopt.solution import Solution
    from plantigrade.trajopt.solve import synthesize
    from plantigrade.trajopt.solvers.interior_point import InteriorPoint, Options
    from plantigrade.trajopt.tasks.registry import make_task
    from plantigrade.trajopt.tasks.settings import TASKS
    from plantigrade.trajopt.tasks.task import MotionTask
    from plantigrade.trajopt.tasks.task_file import TaskFile, parse_task_file, read_task_file
    from plantigrade.trajopt.terms.term import Term

__all__ = [
    "TASKS",
    "ConstraintFamily",
    "ContactBody",
    "InteriorPoint",
    "MotionTask",
    "Options",
    "PeriodicClosure",
    "Problem",
    "ProblemBuilder",
    "Solution",
    "TaskFile",
    "Term",
    "make_task",
    "parse_task_file",
    "read_task_file",
    "synthesize",
]

__getattr__ = lazy(__name__)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

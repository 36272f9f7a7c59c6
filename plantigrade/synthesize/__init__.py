"""Motion from a task alone: tasks and their terms, trajectories on splines, and who solves them.

A person and a task become a motion in three lines::

    task = make_task("walk", human, {"periodic": True})
    motion = synthesize(body_for(human, task.plan), task)
    sampled = motion.sample(motion.times())

What is named here is loaded when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from plantigrade.synthesize.splines.banded import BandedMatrix
from plantigrade.synthesize.splines.basis import Basis
from plantigrade.synthesize.splines.knots import clamped_knots, periodic_knots, uniform_knots
from plantigrade.synthesize.splines.polynomial import PolynomialBasis
from plantigrade.synthesize.splines.trigonometric import TrigonometricBasis

if TYPE_CHECKING:
    from plantigrade.synthesize.diagnose.post_mortem import Broken, broken_rows
    from plantigrade.synthesize.problem.assembly import Assembly
    from plantigrade.synthesize.problem.contact_body import ContactBody
    from plantigrade.synthesize.problem.nlp import ConstraintFamily, PeriodicClosure, Problem
    from plantigrade.synthesize.solution import Sampled, Solution, Stage
    from plantigrade.synthesize.solve import synthesize
    from plantigrade.synthesize.solvers.interior_point import (
        InteriorPoint,
        Iterate,
        Multipliers,
        Options,
        Result,
    )
    from plantigrade.synthesize.tasks.registry import TASKS, body_for, make_task
    from plantigrade.synthesize.tasks.task import MotionTask
    from plantigrade.synthesize.tasks.task_file import TaskFile, parse_task_file, read_task_file
    from plantigrade.synthesize.terms.terms import Term

_HOMES = {
    "problem.assembly": ("Assembly",),
    "problem.formulation": ("ContactBody",),
    "solvers.interior_point": ("InteriorPoint", "Iterate", "Multipliers", "Options", "Result"),
    "diagnose.post_mortem": ("Broken", "broken_rows"),
    "problem.nlp": ("PeriodicClosure", "Problem", "ConstraintFamily"),
    "solve": ("synthesize",),
    "solution": ("Sampled", "Stage", "Solution"),
    "tasks.task": ("MotionTask",),
    "tasks.task_file": ("TaskFile", "parse_task_file", "read_task_file"),
    "tasks.registry": ("TASKS", "body_for", "make_task"),
    "terms.terms": ("Term",),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}

__all__ = [
    "TASKS",
    "Assembly",
    "BandedMatrix",
    "Basis",
    "ContactBody",
    "Broken",
    "PeriodicClosure",
    "InteriorPoint",
    "Iterate",
    "Multipliers",
    "Options",
    "PolynomialBasis",
    "Problem",
    "Result",
    "ConstraintFamily",
    "Sampled",
    "Stage",
    "Solution",
    "MotionTask",
    "TaskFile",
    "Term",
    "TrigonometricBasis",
    "body_for",
    "broken_rows",
    "clamped_knots",
    "make_task",
    "parse_task_file",
    "periodic_knots",
    "read_task_file",
    "synthesize",
    "uniform_knots",
]


def __getattr__(name: str) -> Any:
    """Load what is named here and not loaded yet."""
    if name not in _HOME:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOME[name]}"), name)


def __dir__() -> list[str]:
    """Return every name, loaded or not."""
    return sorted({*globals(), *__all__})

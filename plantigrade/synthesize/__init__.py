"""Motion from a task alone: tasks and their terms, trajectories on splines, and who solves them.

A person and a task become a motion in three lines::

    task = make_task("walk", human, {"periodic": True})
    motion = synthesize(body_for(human, task.plan), task)
    sampled = motion.sample(motion.times())

What is named here is loaded when it is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from plantigrade.synthesize.band import Band
from plantigrade.synthesize.basis import Basis
from plantigrade.synthesize.knots import clamped_knots, periodic_knots, uniform_knots
from plantigrade.synthesize.splines import PolynomialBasis, TrigonometricBasis

if TYPE_CHECKING:
    from plantigrade.synthesize.assembly import Assembly
    from plantigrade.synthesize.contact_plan import (
        ContactPlan,
        Footprint,
        Site,
        Stance,
        Support,
        foot_sites,
    )
    from plantigrade.synthesize.formulation import Body
    from plantigrade.synthesize.interior_point import (
        InteriorPoint,
        Iterate,
        Multipliers,
        Options,
        Result,
    )
    from plantigrade.synthesize.post_mortem import Broken, broken_rows
    from plantigrade.synthesize.problem import Closure, Problem, Rows
    from plantigrade.synthesize.solve import synthesize
    from plantigrade.synthesize.synthesis import Sampled, Stage, Synthesis
    from plantigrade.synthesize.task import Task
    from plantigrade.synthesize.task_file import TaskFile, parse_task_file, read_task_file
    from plantigrade.synthesize.tasks import TASKS, body_for, make_task
    from plantigrade.synthesize.terms import Term

_HOMES = {
    "assembly": ("Assembly",),
    "contact_plan": ("ContactPlan", "Footprint", "Site", "Stance", "Support", "foot_sites"),
    "formulation": ("Body",),
    "interior_point": ("InteriorPoint", "Iterate", "Multipliers", "Options", "Result"),
    "post_mortem": ("Broken", "broken_rows"),
    "problem": ("Closure", "Problem", "Rows"),
    "solve": ("synthesize",),
    "synthesis": ("Sampled", "Stage", "Synthesis"),
    "task": ("Task",),
    "task_file": ("TaskFile", "parse_task_file", "read_task_file"),
    "tasks": ("TASKS", "body_for", "make_task"),
    "terms": ("Term",),
}
_HOME = {name: module for module, names in _HOMES.items() for name in names}

__all__ = [
    "TASKS",
    "Assembly",
    "Band",
    "Basis",
    "Body",
    "Broken",
    "Closure",
    "ContactPlan",
    "Footprint",
    "InteriorPoint",
    "Iterate",
    "Multipliers",
    "Options",
    "PolynomialBasis",
    "Problem",
    "Result",
    "Rows",
    "Sampled",
    "Site",
    "Stage",
    "Stance",
    "Support",
    "Synthesis",
    "Task",
    "TaskFile",
    "Term",
    "TrigonometricBasis",
    "body_for",
    "broken_rows",
    "clamped_knots",
    "foot_sites",
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

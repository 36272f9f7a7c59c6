"""Tasks by name: what the command line and task files know."""

import inspect
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import foot_sites
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.synthesize.problem.contact_body import ContactBody
from plantigrade.synthesize.tasks.jumping import jump, take_off
from plantigrade.synthesize.tasks.side_step import side_step
from plantigrade.synthesize.tasks.standing import reach, sit_to_stand, squat, stand_to_sit
from plantigrade.synthesize.tasks.task import MotionTask
from plantigrade.synthesize.tasks.walking import walk

TASKS: Mapping[str, Callable[..., MotionTask]] = {
    "walk": walk,
    "sit-to-stand": sit_to_stand,
    "stand-to-sit": stand_to_sit,
    "squat": squat,
    "reach": reach,
    "side-step": side_step,
    "jump": jump,
    "take-off": take_off,
}
"""Name of a task → function of a person and the task's parameters."""


def parameters_of(name: str) -> Mapping[str, inspect.Parameter]:
    """Return the parameters of a task by name.

    Raises:
        ParameterError: If there is no such task.
    """
    if name not in TASKS:
        raise ParameterError(f"no task {name!r}; there are {', '.join(TASKS)}")
    found = dict(inspect.signature(TASKS[name]).parameters)
    found.pop("human")
    return found


def make_task(name: str, human: Human, parameters: Mapping[str, Any] | None = None) -> MotionTask:
    """Return a task by name.

    Args:
        name: One of :data:`TASKS`.
        human: The person.
        parameters: The task's own; its defaults if not given.

    Raises:
        ParameterError: If there is no such task or parameter, or a value is out of range.
    """
    known = parameters_of(name)
    given = dict(parameters or {})
    unknown = [p for p in given if p not in known]
    if unknown:
        raise ParameterError(
            f"{name} has no parameter {unknown[0]!r}; it has {', '.join(known) or 'none'}"
        )
    for key, value in given.items():
        _check_kind(name, key, value, str(known[key].annotation))
    return TASKS[name](human, **given)


def _check_kind(name: str, key: str, value: Any, kind: str) -> None:
    """Refuse a value of another kind than a parameter's."""

    def number(x: Any) -> bool:
        return (
            isinstance(x, int | float | np.number)
            and not isinstance(x, bool)
            and bool(np.isfinite(x))
        )

    if value is None and "None" in kind:
        return
    if "tuple" in kind or "Sequence" in kind:
        good = isinstance(value, list | tuple) and all(number(x) for x in value)
        needed = "numbers in brackets are"
    elif "bool" in kind:
        good, needed = isinstance(value, bool), "true or false is"
    elif "float" in kind or "int" in kind:
        good, needed = number(value), "a number is"
    else:
        good, needed = isinstance(value, str), "a word is"
    if not good:
        raise ParameterError(f"{key} of {name} is {value!r}; {needed} needed")


def body_for(human: Human, plan: ContactPlan) -> ContactBody:
    """Return a person with all places that carry force in a plan: both feet, and its supports."""
    places = {s.site.name: s.site for s in plan.supports}
    return ContactBody(human, (*foot_sites(human), *places.values()), plan=plan)

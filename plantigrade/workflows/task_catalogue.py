"""Tasks by name, as a command or a file asks for them."""

import difflib
import inspect
import re
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plantigrade.errors import FileError, ParameterError

if TYPE_CHECKING:
    from plantigrade.models import Human
    from plantigrade.synthesize.task import Task
    from plantigrade.synthesize.terms import Term


def walk(human: "Human", speed: float = 1.3, step_length: float | None = None) -> "Task":
    """Return a periodic walk."""
    from plantigrade.synthesize.gait_parameters import gait_parameters
    from plantigrade.synthesize.guess import walking_guess
    from plantigrade.synthesize.task import Task
    from plantigrade.synthesize.terms import (
        Acceleration,
        Contact,
        Dynamics,
        Forces,
        Limits,
        Torque,
    )
    from plantigrade.synthesize.walking_plan import advance, periodic_walk_plan

    gait = gait_parameters(human, speed, step_length=step_length)
    plan = periodic_walk_plan(human, gait)
    return Task(
        "walk",
        plan,
        (Dynamics(), Contact(), Limits(), Torque(), Acceleration(), Forces()),
        lambda body, plan, times: walking_guess(body.human, plan, gait, times),
        step=advance(plan)[0],
    )


TASKS = {"walk": walk}


def known_parameters(name: str) -> tuple[str, ...]:
    """Return what a task may be told.

    Raises:
        ParameterError: If there is no such task.
    """
    return tuple(p for p in inspect.signature(_task(name)).parameters if p != "human")


def make_task(
    name: str,
    human: "Human",
    parameters: Mapping[str, Any],
    changes: Mapping[str, Any] | None = None,
) -> "Task":
    """Return a task by name.

    Args:
        name: One of :data:`TASKS`.
        human: Who does it.
        parameters: What it is told.
        changes: Of its terms, as :func:`changed` takes them.

    Raises:
        ParameterError: If there is no such task or it does not know a parameter.
    """
    known = known_parameters(name)
    wrong = [p for p in parameters if p not in known]
    if wrong:
        raise ParameterError(f"{name} does not know {wrong[0]!r}; it knows {', '.join(known)}")
    try:
        task = _task(name)(human, **parameters)
    except TypeError as error:  # a word where a number was wanted
        raise ParameterError(f"{name} cannot be made of {dict(parameters)}: {error}") from error
    return changed(task, changes or {})


def changed(task: "Task", changes: Mapping[str, Any]) -> "Task":
    """Return a task whose terms are changed.

    Args:
        task: The task.
        changes: Kind of term (``"limits"``) → fields, which replace those of the task's own term
            of that kind or make a new one; a list of such tables adds new terms.

    Raises:
        ParameterError: If there is no such kind or field.
    """
    kept = list(task.terms)
    for kind, given in changes.items():
        cls = _kind(kind)
        if isinstance(given, list | tuple):
            kept += [_made(cls, kind, fields) for fields in given]
            continue
        own = [i for i, t in enumerate(kept) if type(t) is cls]
        for i in own:
            kept[i] = _made(cls, kind, given, kept[i])
        if not own:
            kept.append(_made(cls, kind, given))
    return replace(task, terms=tuple(kept))


def term_kinds() -> "dict[str, type[Term]]":
    """Return every kind of term a file may name, by the word it is named with."""
    from plantigrade.synthesize import terms

    found = {}
    for name, cls in vars(terms).items():
        if isinstance(cls, type) and is_dataclass(cls) and hasattr(cls, "put"):
            found[re.sub(r"(?<!^)(?=[A-Z])", "_", name).lower()] = cls
    return found


def _kind(kind: str):
    kinds = term_kinds()
    if kind.replace("-", "_") not in kinds:
        raise ParameterError(f"no term {kind!r}; there are {', '.join(sorted(kinds))}")
    return kinds[kind.replace("-", "_")]


def _made(cls: Any, kind: str, given: Any, old: Any = None) -> Any:
    known = [f.name for f in fields(cls)]
    if not isinstance(given, Mapping):
        raise ParameterError(f"term {kind}: write fields, as {known[0]} = …; {given!r} came")
    wrong = [k for k in given if k not in known]
    if wrong:
        raise ParameterError(
            f"term {kind} does not know {wrong[0]!r}; it knows {', '.join(known) or 'nothing'}"
        )
    try:
        return cls(**given) if old is None else replace(old, **given)
    except TypeError as error:
        raise ParameterError(f"term {kind}: {error}") from error


def _task(name: str) -> Callable[..., "Task"]:
    if name not in TASKS:
        near = difflib.get_close_matches(name, TASKS, n=1)
        hint = f"did you mean {near[0]}? " if near else ""
        raise ParameterError(
            f"no task {name!r}; {hint}there are {', '.join(TASKS)}, or name a file (.toml)"
        )
    return TASKS[name]


PERSON = ("height", "mass", "sex", "joints", "feet")
SOLVING = ("formulation", "solver", "basis", "density")


def read_task_file(path: Path) -> dict[str, Any]:
    """Return the settings a task file holds: task, parameters, terms, person, solving.

    The file names a task, what it is told, and what is changed of its terms::

        task = "walk"

        [parameters]
        speed = 1.2

        [person]
        height = 1.65

        [terms.limits]
        strength = 0.8

    Raises:
        FileError: If it cannot be read, or holds something unknown.
    """
    import tomllib

    remedy = "see docs/synthesize.md for what a task file may hold"
    try:
        held = tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise FileError(path, f"is not TOML ({error})", remedy=remedy) from error
    tables = {"parameters": None, "terms": None, "person": PERSON, "solving": SOLVING}
    if not isinstance(held.get("task"), str):
        raise FileError(path, "names no task", where="task", remedy='write task = "walk", say')
    found: dict[str, Any] = {"task": held.pop("task")}
    for name, value in held.items():
        if name not in tables:
            raise FileError(
                path,
                f"is unknown; allowed are task, {', '.join(tables)}",
                where=name,
                remedy=remedy,
            )
        if not isinstance(value, dict):
            raise FileError(path, "is no table", where=name, remedy=f"write [{name}] above it")
        allowed = tables[name]
        if allowed is None:
            found[name] = value
            continue
        wrong = [k for k in value if k not in allowed]
        if wrong:
            raise FileError(
                path,
                f"is unknown; allowed are {', '.join(allowed)}",
                where=f"{name}.{wrong[0]}",
                remedy=remedy,
            )
        found |= {k: str(v) if k == "joints" else v for k, v in value.items()}
    return found

"""Motion from prioritised tasks: a gait reproduced from a recording, or your own movements.

A recorded gait, once it is a motion of a Human with its gait events, is rebuilt in two lines::

    reference = reference_of(human, motion.time, motion.qpos, motion.events)
    record = rebuild(reference, gait_tasks("paper")).record()

What is named here is loaded when it is first used. To reproduce a recording from its file, call
``plantigrade.reproduce("walk.c3d")``.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plantigrade.ordered_tasks.gait import GaitTasks, gait_tasks
    from plantigrade.ordered_tasks.reference import Reference, reference_of
    from plantigrade.ordered_tasks.result import ReproducedGait, ReproduceSettings, rebuild

_HOMES = {
    "GaitTasks": "gait",
    "Reference": "reference",
    "ReproduceSettings": "result",
    "ReproducedGait": "result",
    "gait_tasks": "gait",
    "rebuild": "result",
    "reference_of": "reference",
}

__all__ = [
    "GaitTasks",
    "Reference",
    "ReproduceSettings",
    "ReproducedGait",
    "gait_tasks",
    "rebuild",
    "reference_of",
]


def __getattr__(name: str) -> Any:
    """Load what is named here and not loaded yet."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    """Return every name, loaded or not."""
    return sorted({*globals(), *__all__})

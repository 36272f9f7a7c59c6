"""Motion from prioritised tasks: a gait reproduced from a recording, or your own movements.

A recorded gait, once it is a motion of a Human with its gait events, is rebuilt in two lines::

    reference = reference_of(human, motion.time, motion.qpos, motion.events)
    record = rebuild(reference, gait_tasks("paper")).record()

Names are loaded on first use. ``plantigrade.reproduce("walk.c3d")`` reproduces a recording from its
file.
"""

from typing import TYPE_CHECKING

from plantigrade.lazy import lazy

if TYPE_CHECKING:
    from plantigrade.ordered_tasks.gait import TASKS, GaitTasks, gait_order, gait_tasks
    from plantigrade.ordered_tasks.gait_reference import GaitReference, reference_of
    from plantigrade.ordered_tasks.reproduced_gait import (
        ReproducedGait,
        ReproducedGaitSettings,
        rebuild,
    )

__all__ = [
    "TASKS",
    "GaitTasks",
    "GaitReference",
    "ReproducedGaitSettings",
    "ReproducedGait",
    "gait_order",
    "gait_tasks",
    "rebuild",
    "reference_of",
]

__getattr__ = lazy(__name__)


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})

"""The textbook walk rebuilt from tasks, cached by body and task set."""

from functools import cache

import numpy as np

from plantigrade.kinematics.state import sweep
from plantigrade.kinematics.textbook_recording import textbook_walk
from plantigrade.ordered_tasks import TASKS, GaitReference, rebuild, reference_of
from plantigrade.ordered_tasks.schedule import ContactSchedule
from plantigrade.wbc import OrderedMotion
from tests.models.presets import person


@cache
def reference(joints: str = "42", feet: str = "two-segment", cycles: int = 2) -> GaitReference:
    """Reference of the textbook walk."""
    walk = textbook_walk(person(joints, feet), cycles=cycles)
    return reference_of(walk.human, walk.time, walk.qpos, walk.events)


@cache
def rebuilt(
    tasks: str = "default", joints: str = "42", feet: str = "two-segment", cycles: int = 2
) -> OrderedMotion:
    """The walk reproduced from the tasks."""
    known = reference(joints, feet, cycles)
    return rebuild(known, TASKS[tasks]).motion


@cache
def soles(joints: str = "42", feet: str = "two-segment", cycles: int = 2) -> ContactSchedule:
    """Contact schedule of the tasks."""
    known = reference(joints, feet, cycles)
    return ContactSchedule(known, known.held)


def paths(human, qpos, points) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass (n, 3) and points (n, k, 3) of a motion."""
    both = [(state.com, state.position(points)) for state in sweep(human, qpos)]
    com, place = zip(*both, strict=True)
    return np.array(com), np.array(place)

"""The textbook walk rebuilt from tasks, once per body and set of tasks for all tests."""

from functools import cache

import numpy as np

from plantigrade.kinematics.state import State
from plantigrade.reproduce.gait import TASKS, ContactSchedule, gait_order
from plantigrade.reproduce.reference import Reference, reference_of
from plantigrade.wbc.ordered_motion import OrderedMotion, move
from plantigrade.workflows.textbook import textbook_walk
from tests.models.presets import person


@cache
def reference(joints: str = "42", feet: str = "two-segment", cycles: int = 2) -> Reference:
    """What the tasks see of the textbook walk."""
    walk = textbook_walk(person(joints, feet), cycles=cycles)
    return reference_of(walk.human, walk.time, walk.qpos, walk.events)


@cache
def rebuilt(
    tasks: str = "default", joints: str = "42", feet: str = "two-segment", cycles: int = 2
) -> OrderedMotion:
    """The walk made of the tasks."""
    known = reference(joints, feet, cycles)
    order = gait_order(known, TASKS[tasks])
    start = known.at(known.start), known.velocity_at(known.start)
    return move(known.human, order, *start, start=known.start, stop=known.stop)


@cache
def soles(joints: str = "42", feet: str = "two-segment", cycles: int = 2) -> ContactSchedule:
    """Which points touch when."""
    return ContactSchedule(reference(joints, feet, cycles))


def paths(human, qpos, points) -> tuple[np.ndarray, np.ndarray]:
    """Centre of mass (n, 3) and points (n, k, 3) of a motion."""
    state, still = State(human, qpos[0]), np.zeros(human.model.nv)
    com, place = [], []
    for q in qpos:
        state.move_to(q, still)
        com.append(state.com)
        place.append(state.position(points))
    return np.array(com), np.array(place)

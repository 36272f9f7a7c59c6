"""One periodic walk on a coarse mesh, solved once for all tests."""

from dataclasses import replace
from functools import cache

from plantigrade.models import Human
from plantigrade.trajopt import ContactBody, MotionTask, Solution, make_task, synthesize

NODES_PER_SECOND = 24.0
SPEED = 1.2


@cache
def person() -> Human:
    """The walking person."""
    return Human.create(1.72, 68.0, joints="42", feet="two-segment")


def task(speed: float = SPEED) -> MotionTask:
    """A periodic walk."""
    made = make_task("walk", person(), {"speed": speed, "periodic": True})
    return replace(made, nodes_per_second=NODES_PER_SECOND)


@cache
def body() -> ContactBody:
    """The person with the places that carry force."""
    return ContactBody.for_plan(person(), task().plan)


@cache
def solved(speed: float = SPEED) -> Solution:
    """The walk."""
    return synthesize(body(), task(speed))

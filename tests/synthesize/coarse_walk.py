"""One periodic walk on a coarse mesh, solved once for all tests."""

from dataclasses import replace
from functools import cache

from plantigrade.models import Human
from plantigrade.synthesize.problem.formulation import Body
from plantigrade.synthesize.solution import Synthesis
from plantigrade.synthesize.solve import synthesize
from plantigrade.synthesize.tasks.registry import body_for
from plantigrade.synthesize.tasks.task import Task
from plantigrade.synthesize.tasks.walking import walk

NODES_PER_SECOND = 24.0
SPEED = 1.2


@cache
def person() -> Human:
    """Who walks."""
    return Human.create(1.72, 68.0, joints="42", feet="two-segment")


def task(speed: float = SPEED) -> Task:
    """A periodic walk."""
    return replace(walk(person(), speed=speed, periodic=True), nodes_per_second=NODES_PER_SECOND)


@cache
def body() -> Body:
    """The person with the places that carry force."""
    return body_for(person(), task().plan)


@cache
def solved(speed: float = SPEED) -> Synthesis:
    """The walk."""
    return synthesize(body(), task(speed))

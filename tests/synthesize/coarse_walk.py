"""One periodic walk on a coarse mesh, solved once for all tests."""

from dataclasses import replace
from functools import cache

from plantigrade.models import Human
from plantigrade.synthesize.formulation import Body
from plantigrade.synthesize.solve import synthesize
from plantigrade.synthesize.synthesis import Synthesis
from plantigrade.synthesize.task import Task
from plantigrade.synthesize.tasks import body_for
from plantigrade.synthesize.walking import walk

DENSITY = 24.0
SPEED = 1.2


@cache
def person() -> Human:
    """Who walks."""
    return Human.create(1.72, 68.0, joints="42", feet="two-segment")


def task(speed: float = SPEED) -> Task:
    """A periodic walk."""
    return replace(walk(person(), speed=speed, periodic=True), density=DENSITY)


@cache
def body() -> Body:
    """The person with the places that carry force."""
    return body_for(person(), task().plan)


@cache
def solved(speed: float = SPEED) -> Synthesis:
    """The walk."""
    return synthesize(body(), task(speed))

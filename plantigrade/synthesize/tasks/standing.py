"""Standing on both feet: what every task on the spot begins or ends in."""

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.models import Human
from plantigrade.spatial.conventions import PELVIS
from plantigrade.synthesize.guess.postures import (
    KeyPostures,
    standing_feet,
    standing_posture,
    standing_stances,
)
from plantigrade.synthesize.tasks.settings import Stand
from plantigrade.synthesize.tasks.task import MotionTask
from plantigrade.synthesize.terms.contact import Contact, Dynamics, Forces
from plantigrade.synthesize.terms.effort import Acceleration, Torque
from plantigrade.synthesize.terms.limits import Limits
from plantigrade.synthesize.terms.posture import Pose, Quiet
from plantigrade.synthesize.terms.term import Term


def basics() -> tuple[Term, ...]:
    """Return the conditions and costs every task on true forces has."""
    return (Dynamics(), Contact(), Limits(), Torque(), Acceleration(1e-3), Forces())


def at_rest(human: Human, time: float, q: Float[Array, " nv"]) -> tuple[Term, ...]:
    """Return the terms of a posture that is held."""
    names = PELVIS + human.coordinates
    return (
        Pose(time, dict(zip(names, map(float, q), strict=True))),
        Quiet(time),
    )


def stand(human: Human, told: Stand) -> MotionTask:
    """Return a person who stands on both feet, with the usual conditions and costs."""
    plan = ContactPlan(told.duration, standing_stances(standing_feet(human), told.duration))
    q = standing_posture(human)
    return MotionTask("standing", plan, basics(), KeyPostures((0.0, told.duration), (q, q)))

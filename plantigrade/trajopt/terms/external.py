"""Terms of what acts on a person from outside: a wrench on a body, and hands that hold a thing."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import Point
from plantigrade.errors import ParameterError
from plantigrade.motion.blends import cubic_rise
from plantigrade.record.conditions import Condition
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.terms.term import Term, point_conditions

Triple = tuple[float, float, float]
RAMP = 0.1  # [s] in which a wrench comes and goes; a step would need a node at every instant


@dataclass(frozen=True)
class Wrench(Term):
    """A force and a moment on a body: a push, a pull, wind, a cable.

    The task makes the body with it (:meth:`~plantigrade.trajopt.tasks.task.MotionTask.body_of`).
    Between ``start`` and ``stop`` it acts, and comes and goes within a tenth of a second; a
    periodic motion has it all the time.
    """

    point: Point  #: Where the force acts
    force: Triple = (0.0, 0.0, 0.0)  #: World axes: x forward, y to the left, z up [N]
    moment: Triple = (0.0, 0.0, 0.0)  #: World axes [N m]
    start: float = -np.inf  #: When it has come [s]
    stop: float = np.inf  #: When it goes [s]

    def values(self, times: Float[Array, " n"], plan: ContactPlan) -> Float[Array, "n 6"]:
        """Return force [N] and moment [N m] at times [s], world axes."""
        share = np.ones(len(times))
        if np.isfinite(self.start):
            share *= cubic_rise((times - self.start) / RAMP + 1.0)
        if np.isfinite(self.stop):
            share *= cubic_rise((self.stop - times) / RAMP + 1.0)
        return share[:, None] * np.array([*self.force, *self.moment])

    def add_to(self, b: ProblemBuilder) -> None:
        """Check that the body has it.

        Raises:
            ParameterError: If it has not, or comes and goes in a periodic motion.
        """
        if self not in b.body.external.wrenches:
            raise ParameterError(
                f"the task has a wrench on {self.point.body}, and the body was made without: make "
                "it with task.body_of(human)"
            )
        if b.plan.periodic and (np.isfinite(self.start) or np.isfinite(self.stop)):
            raise ParameterError(
                "a wrench on a periodic motion acts all the time: leave out start and stop"
            )

    def mirrored(self) -> "Wrench":
        """Return the same wrench on the other side."""
        (x, y, z), (a, b, c) = self.force, self.moment
        turned = replace(super().mirrored(), force=(x, -y, z), moment=(-a, b, -c))  # type: ignore[arg-type]
        return turned  # type: ignore[return-value]


@dataclass(frozen=True)
class Hold(Term):
    """A point of the body stays on a thing that stands or moves: a handle, a rail, a wall."""

    point: Point  #: The point
    place: Triple  #: Where the thing is at the start, world [m]; NaN for an axis that is free
    velocity: Triple = (0.0, 0.0, 0.0)  #: How it moves, world [m/s]
    start: float = 0.0  #: From when [s]
    stop: float = np.inf  #: Until when [s]

    def add_to(self, b: ProblemBuilder) -> None:
        """Fix the position at nodes."""
        family = b.place_of(self.point, "holds")
        axes = ~np.isnan(self.place)
        for k in b.during(self.start, self.stop):
            there = np.add(self.place, np.multiply(self.velocity, b.nodes[k]))
            family.lower[k, axes] = family.upper[k, axes] = there[axes]

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return where the point is, axis by axis."""
        times = (max(self.start, 0.0), min(self.stop, plan.duration))
        places = self.place + np.multiply.outer(times, self.velocity)
        return point_conditions(self.point, times, places)

    def mirrored(self) -> "Hold":
        """Return the same of the other side's point."""
        (x, y, z), (u, v, w) = self.place, self.velocity
        turned = replace(super().mirrored(), place=(x, -y, z), velocity=(u, -v, w))  # type: ignore[arg-type]
        return turned  # type: ignore[return-value]

"""Targets at an instant: a point of the body, the centre of mass."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import Point
from plantigrade.errors import ParameterError
from plantigrade.record.conditions import AXES, Condition
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.terms.term import AtInstant, point_conditions

Triple = tuple[float, float, float]
FREE: Triple = (np.nan, np.nan, np.nan)


@dataclass(frozen=True)
class Reach(AtInstant):
    """A point of the body is at a place at one instant: a hand at its target."""

    point: Point  #: The point
    target: Triple  #: Where it shall be, world [m]; NaN for an axis that is free

    def add_to(self, b: ProblemBuilder) -> None:
        """Fix the position."""
        family = b.place_of(self.point, "reaches")
        k, target = b.node(self.time), np.array(self.target, dtype=float)
        if target.shape != (3,) or np.isinf(target).any():
            raise ParameterError(f"a target is three places [m], not {self.target}")
        axes = ~np.isnan(target)
        family.lower[k, axes] = family.upper[k, axes] = target[axes]

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return where the point is, axis by axis."""
        return point_conditions(self.point, (self.time,), [self.target])

    def mirrored(self) -> "Reach":
        """Return the target of the other side's point."""
        x, y, z = self.target
        return replace(super().mirrored(), target=(x, -y, z))  # type: ignore[arg-type]


@dataclass(frozen=True)
class CentreOfMass(AtInstant):
    """Position and velocity of the centre of mass at one instant, required or rewarded."""

    position: Triple = FREE  #: World [m]; NaN where free
    velocity: Triple = FREE  #: World [m/s]; NaN where free
    #: Reduction of the cost by 1 m and by 1 m/s upwards at this instant
    gain: tuple[float, float] = (0.0, 0.0)

    def add_to(self, b: ProblemBuilder) -> None:
        """Fix or reward rows of the centre of mass."""
        import casadi as ca

        sym = b.body.symbolic

        def expression(q, v, a, u):
            return ca.vertcat(sym.com()(q), sym.momentum()(q, v)[0] / sym.mass)

        place = [f"{axis} of the centre of mass" for axis in AXES]
        names = (*place, *(f"speed {n}" for n in place))
        family = b.custom_family("centre of mass", names, expression, "m")
        k, desired = b.node(self.time), np.array([*self.position, *self.velocity], float)
        given = ~np.isnan(desired)
        family.lower[k, given] = family.upper[k, given] = desired[given]
        family.gain[k, [2, 5]] -= self.gain

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return position and velocity, axis by axis."""
        return tuple(
            Condition(
                f"{name} of the centre of mass, {axis}",
                quantity,  # type: ignore[arg-type]
                (self.time,), (float(x),), (float(x),), "", axis,
            )
            for name, quantity, given in (
                ("place", "com", self.position), ("velocity", "com speed", self.velocity),
            )
            for axis, x in zip(AXES, given, strict=True)
            if not np.isnan(x)
        )  # fmt: skip

    def mirrored(self) -> "CentreOfMass":
        """Return the same in the mirror."""
        (x, y, z), (vx, vy, vz) = self.position, self.velocity
        return replace(self, position=(x, -y, z), velocity=(vx, -vy, vz))

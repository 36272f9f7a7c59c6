"""Terms of a thing that hands carry from one place to another on a given trajectory.

The acceleration of the thing follows from the trajectory, and with it the force on each hand: half
of the weight and inertia. Before the thing moves and after it has come to rest, ground or table
take over its weight within the time of a ramp.
"""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import Point
from plantigrade.motion.blends import quintic_rise
from plantigrade.record.conditions import Condition
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.terms.external import RAMP, Wrench
from plantigrade.trajopt.terms.targets import Triple
from plantigrade.trajopt.terms.term import Term, point_conditions

CONDITION_RATE = 100.0
"""Rate at which a trajectory is a condition [Hz]; between, straight lines are off by .03 mm at 2
m/s²."""


@dataclass(frozen=True)
class CarryingPath:
    """A trajectory from place to place: each coordinate rests, moves as a quintic, and rests.

    Hands of people move so [Flash1985]_.
    """

    start: float  #: When it leaves [s]
    stop: float  #: When it arrives [s]
    places: tuple[Triple, ...]  #: Places it passes, one after another [m]
    #: For each of them when it is there, as shares of the time, for x, y and z [1]
    shares: tuple[Triple, ...]

    def at(self, times: Float[Array, " n"], order: int = 0) -> Float[Array, "n 3"]:
        """Return its place [m], or that differentiated, at times [s]."""
        span = self.stop - self.start
        s = np.clip((times - self.start) / span, 0.0, 1.0)
        out = np.zeros((len(times), 3))
        if order == 0:
            out[:] = self.places[0]
        for axis in range(3):
            for k in range(len(self.places) - 1):
                a, b = self.shares[k][axis], self.shares[k + 1][axis]
                step = self.places[k + 1][axis] - self.places[k][axis]
                u = np.clip((s - a) / (b - a), 0.0, 1.0)
                curve = (
                    quintic_rise(u),
                    30 * u**2 * (1 - u) ** 2,
                    60 * u * (1 - u) * (1 - 2 * u),
                )[order]
                out[:, axis] += step * curve / ((b - a) * span) ** order
        return out


@dataclass(frozen=True)
class Carried(Wrench):
    """The weight and inertia of a thing on a given trajectory, or of a part of it, on a point."""

    mass: float = 0.0  #: Its mass, or the part that this point carries [kg]
    gravity: float = 0.0  #: Acceleration of gravity [m/s²]
    way: CarryingPath | None = None  #: How it moves

    def values(self, times: Float[Array, " n"], plan: ContactPlan) -> Float[Array, "n 6"]:
        """Return force [N] and moment [N m] at times [s], world axes."""
        assert self.way is not None
        weight = replace(self, force=(0.0, 0.0, -self.mass * self.gravity))
        out = Wrench.values(weight, times, plan)
        moving = (times >= self.start) & (times <= self.stop)
        out[moving, :3] -= self.mass * self.way.at(times[moving], 2)
        return out


@dataclass(frozen=True)
class FollowTrajectory(Term):
    """A point of the body follows a trajectory: a hand on a box."""

    point: Point  #: The point
    way: CarryingPath  #: Where it goes
    offset: Triple = (0.0, 0.0, 0.0)  #: Of the point from the trajectory, world [m]

    @property
    def instants(self) -> tuple[float, ...]:
        """When the point comes and goes, and the thing leaves and arrives."""
        way = self.way
        return way.start - RAMP, way.start, way.stop, way.stop + RAMP

    def add_to(self, b: ProblemBuilder) -> None:
        """Fix the position at nodes, and the speed where the point comes and goes."""
        import casadi as ca

        family = b.place_of(self.point, "carries")
        positions = b.body.symbolic.positions([self.point])
        nodes = b.during(self.way.start - RAMP, self.way.stop + RAMP)
        there = self.way.at(b.nodes[nodes]) + self.offset
        family.lower[nodes] = family.upper[nodes] = there
        speeds = b.custom_family(
            f"speed at the {family.name}",
            tuple(f"speed {n}" for n in family.names),
            lambda q, v, a, u: ca.jtimes(positions(q), q, v),
            "m/s",
        )
        ends = [nodes[0], nodes[-1]]
        speeds.lower[ends] = speeds.upper[ends] = 0.0

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return where the point is, axis by axis."""
        times, there = _sampled(self.way)
        return point_conditions(self.point, times, there + self.offset)


@dataclass(frozen=True)
class BehindTrajectory(Term):
    """A point of the body stays behind a thing on a way, along x: a knee behind a box."""

    point: Point  #: The point
    way: CarryingPath  #: Trajectory of the thing
    distance: float  #: From the way back to the side of the thing [m]
    label: str  #: What the point and the thing are called: ``"patella_r behind the box"``

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit the position at nodes."""
        positions = b.body.symbolic.positions([self.point])
        family = b.custom_family(self.label, (self.label,), lambda q, v, a, u: positions(q)[0], "m")
        nodes = b.during(self.way.start - RAMP, self.way.stop + RAMP)
        most = self.way.at(b.nodes[nodes])[:, :1] - self.distance - self.point.radius
        b.limit(family, upper=most, nodes=nodes)

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return the largest x of the point."""
        times, there = _sampled(self.way)
        most = (there[:, 0] - self.distance - self.point.radius).tolist()
        p = self.point
        return (
            Condition(
                self.label, "point", tuple(times), (-np.inf,) * len(times), tuple(most),
                p.body, "x", p.position, p.radius,
            ),
        )  # fmt: skip


def _sampled(way: CarryingPath) -> tuple[list[float], Float[Array, "n 3"]]:
    start, stop = way.start - RAMP, way.stop + RAMP
    times = np.linspace(start, stop, round((stop - start) * CONDITION_RATE) + 1)
    return times.tolist(), way.at(times)

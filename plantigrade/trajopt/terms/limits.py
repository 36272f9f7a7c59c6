"""Terms that limit: joint ranges, speeds and torques, single coordinates, power."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.models import Human
from plantigrade.models.mirror import mirror_sign, mirrored_name
from plantigrade.record.conditions import Condition
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.problem.dynamics import WORK_RATE_ROUNDING
from plantigrade.trajopt.terms.term import Term


@dataclass(frozen=True)
class Limits(Term):
    """Joint ranges, speeds and torques of the person."""

    #: Narrower ranges of coordinates, by name without or with side [rad]
    ranges: Mapping[str, tuple[float, float]] = field(
        default_factory=lambda: {"knee_angle": (0.0, 2.6)}
    )
    #: Ranges in place of the person's, by name: of angles that count on past a half turn [rad]
    counted: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    speed: float = 15.0  #: Largest speed of a joint [rad/s]
    strength: float = 1.0  #: Part of the person's joint torques that may be used
    #: How far within their ranges joints stay at nodes [rad]; between nodes they may swing out a
    #: little
    margin: float = 0.01
    reserve: float = 0.08  #: Part of the strength that is not used at nodes, for the same reason

    def coordinates(self, human: Human) -> Float[Array, "2 n_hinges"]:
        """Return lower and upper limits of the hinges [rad]."""
        limits = human.limits.copy()
        for i, name in enumerate(human.coordinates):
            limits[:, i] = self.counted.get(name, limits[:, i])
            own = self.ranges.get(name, self.ranges.get(name[:-2]))
            if own is not None:
                limits[:, i] = max(limits[0, i], own[0]), min(limits[1, i], own[1])
        return limits

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return nothing: ranges, speeds and torques are limits of the Record."""
        return ()

    def torques(self, human: Human) -> Float[Array, "2 n_hinges"]:
        """Return lower and upper limits of the hinges' torques [N m]."""
        return human.model.jnt_actfrcrange[1:].T * self.strength

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit coordinates, rates and torques."""
        low, high = self.coordinates(b.body.human)
        room = np.minimum(self.margin, (high - low) / 4)
        b.limit(b.family("coordinates"), low + room, high - room, columns=slice(6, None))
        b.limit(b.family("speeds"), -self.speed, self.speed, columns=slice(6, None))
        # what a joint bears, tissue and muscles together, where the two differ much
        hinges, stiff = b.names[6:], b.body.stiff
        torque = self.torques(b.body.human) / b.body.torque * (1.0 - self.reserve)
        own = [i for i, name in enumerate(hinges) if name not in stiff]
        whole = [hinges.index(name) for name in stiff]
        b.limit(b.family("muscle torque"), *torque[:, own], columns=own)
        b.limit(b.family("joint torque"), *torque[:, whole])


@dataclass(frozen=True)
class Within(Term):
    """A coordinate stays between limits for a while."""

    coordinate: str  #: Its name
    low: float = -np.inf  #: Lower limit [rad, m]
    high: float = np.inf  #: Upper limit [rad, m]
    start: float = 0.0  #: From when [s]
    stop: float = np.inf  #: Until when [s]; to the end if infinite

    def add_to(self, b: ProblemBuilder) -> None:
        """Narrow the limits."""
        column, nodes = b.column(self.coordinate), b.during(self.start, self.stop)
        b.limit(b.family("coordinates"), self.low, self.high, columns=[column], nodes=nodes)

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return the limits."""
        if plan.slope and self.coordinate.startswith("pelvis"):
            return ()  # in the axes of the ground, which the recorded motion is not
        when, name = (float(self.start), float(self.stop)), self.coordinate
        return (Condition(name, "coordinate", when, (self.low,) * 2, (self.high,) * 2, name),)

    def mirrored(self) -> "Within":
        """Return the limits of the same coordinate on the other side."""
        name, low, high = mirrored_name(self.coordinate), self.low, self.high
        if mirror_sign(self.coordinate) < 0:
            low, high = -high, -low
        return replace(self, coordinate=name, low=low, high=high)


@dataclass(frozen=True)
class PowerLimit(Term):
    """Limits the power of every joint, which isometric strength alone does not.

    In good jumps the whole body reaches 50 to 60 W/kg, which six joints share (estimate).

    Attributes:
        limit: Limit of each joint, per body mass [W/kg].
        reserve: Part of it that is not used at nodes: between them power may swing out a little.
    """

    limit: float = 10.0
    reserve: float = 0.04

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit work rates."""
        most = (1.0 - self.reserve) * self.watts(b.body) / b.body.torque
        b.limit(
            b.family("work rate"),
            upper=float(np.hypot(most, WORK_RATE_ROUNDING)) - WORK_RATE_ROUNDING,
        )

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return the limit of every joint."""
        most = (self.watts(body),) * 2
        least = (-most[0],) * 2
        return tuple(
            Condition(f"power of {n}", "power", (0.0, np.inf), least, most, n)
            for n in body.symbolic.names[6:]
        )

    def watts(self, body: ContactBody) -> float:
        """Return the limit of this person [W]."""
        return self.limit * body.symbolic.mass

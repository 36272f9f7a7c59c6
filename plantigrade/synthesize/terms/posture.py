"""Terms of posture: fixed or preferred, at an instant or throughout."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from plantigrade.contact.plan import ContactPlan
from plantigrade.models.mirror import mirrored_name
from plantigrade.record.conditions import Condition
from plantigrade.synthesize.problem.builder import ProblemBuilder
from plantigrade.synthesize.problem.contact_body import ContactBody
from plantigrade.synthesize.terms.term import AtInstant, Term, mirrored_values, per_coordinate


@dataclass(frozen=True)
class Pose(AtInstant):
    """Coordinates, and rest, at one instant.

    Attributes:
        coordinates: Values [rad, m].
        at_rest: Whether all rates are zero.
        held: Whether the pose fixes the feet; contact constraints at this node are then dropped
            as redundant.
    """

    coordinates: Mapping[str, float]
    at_rest: bool = True
    held: bool = True

    def add_to(self, b: ProblemBuilder) -> None:
        """Fix coordinates and rates."""
        k = b.node(self.time)
        q, v = b.family("coordinates"), b.family("speeds")
        for name, value in self.coordinates.items():
            i = b.column(name)
            q.lower[k, i] = q.upper[k, i] = value
        if self.at_rest:
            v.lower[k] = v.upper[k] = 0.0
        if self.held:
            for family in (b.family("contact"), b.family("contact speed")):
                family.lower[k], family.upper[k] = -np.inf, np.inf

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return every coordinate, and rest."""
        when = (self.time,)
        fixed = [
            Condition(name, "coordinate", when, (float(x),), (float(x),), name)
            for name, x in self.coordinates.items()
            if not (plan.slope and name.startswith("pelvis"))
        ]
        return (*fixed, *(Rest(self.time).conditions(body, plan) if self.at_rest else ()))

    def mirrored(self) -> "Pose":
        """Return the pose in the mirror."""
        return replace(self, coordinates=mirrored_values(self.coordinates))


@dataclass(frozen=True)
class Rest(AtInstant):
    """Zero velocity at an instant, in any posture."""

    def add_to(self, b: ProblemBuilder) -> None:
        """Fix rates."""
        family, k = b.family("speeds"), b.node(self.time)
        family.lower[k] = family.upper[k] = 0.0

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return that nothing moves."""
        return (Condition("rest", "rest", (self.time,), (0.0,), (0.0,)),)


@dataclass(frozen=True)
class Quiet(AtInstant):
    r"""Cost :math:`\sum w \ddot q_j^2` at one instant, so that a movement starts or ends smoothly.

    It is a cost because requiring :math:`\ddot q = 0` of a straight leg would leave the
    neighbouring nodes hardly any freedom.

    Attributes:
        weight: Weight [s⁴/rad²].
    """

    weight: float = 1e-2

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh accelerations."""
        family, k = b.family("accelerations"), b.node(self.time)
        w = np.zeros(family.weight.shape)
        w[k] = 2.0 * self.weight / b.weights[k]  # at an instant, not an integral
        b.penalise(family, w)


@dataclass(frozen=True)
class Posture(Term):
    r"""Cost :math:`\int \sum w_j (q_j - \bar q_j)^2 dt` of being away from a posture.

    Attributes:
        weights: Weight of coordinates, by name without or with side.
        targets: Their targets [rad, m]; zero if absent.
    """

    weights: Mapping[str, float]
    targets: Mapping[str, float] = field(default_factory=dict)

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh coordinates."""
        family = b.family("coordinates")
        w = 2.0 * per_coordinate(b.names, self.weights, 0.0)
        b.penalise(family, w, per_coordinate(b.names, self.targets, 0.0))

    def mirrored(self) -> "Posture":
        """Return the posture in the mirror."""
        weights = {mirrored_name(k): w for k, w in self.weights.items()}
        return replace(self, weights=weights, targets=mirrored_values(self.targets))


@dataclass(frozen=True)
class PostureAt(AtInstant):
    r"""Cost :math:`w \sum (q_j - \bar q_j)^2` of a posture to start from or end in.

    It is a cost, not an equation, because the posture may not quite fit the feet on the ground.

    Attributes:
        q: The posture, in the order of the person's coordinates [rad, m].
        weight: Weight.
    """

    q: tuple[float, ...]
    weight: float = 0.5

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh coordinates at a node."""
        k, family = b.node(self.time), b.family("coordinates")
        w = np.zeros(family.weight.shape)
        w[k] = 2.0 * self.weight / b.weights[k]  # at an instant, not an integral
        b.penalise(family, w, np.array(self.q))


@dataclass(frozen=True)
class HeadStability(Term):
    r"""Cost :math:`\int w_\omega |\omega|^2 + w_l \vartheta^2 dt` of a head that turns, or leans.

    Attributes:
        turning: Weight of its angular velocity :math:`\omega` [s/rad²].
        leaning: Weight of its lean :math:`\vartheta` from the vertical [1/(s rad²)].
    """

    turning: float = 0.05
    leaning: float = 0.05

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the head's rates and lean."""
        import casadi as ca

        sym = b.body.symbolic
        i = b.body.human.body("head") - 1

        def expression(q, v, a, u):
            R = sym.frames()(q)[1][:, 3 * i : 3 * i + 3]
            return ca.vertcat(sym.angular_velocities()(q, v)[:, i], R[0, 2], R[1, 2])

        names = (*(f"turning of the head about {x}" for x in "xyz"), "head forward", "head left")
        family = b.custom_family("head", names, expression)
        b.penalise(family, 2.0 * np.repeat([self.turning, self.leaning], [3, 2]))


@dataclass(frozen=True)
class Symmetry(Term):
    r"""Cost :math:`\int w \sum (q_r - q_l)^2 dt` of joints that differ between the sides.

    Bending and turning of trunk and head count as well, and the pelvis' list and rotation.

    Attributes:
        weight: Weight [1/(s rad²)].
    """

    weight: float = 1.0

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the differences."""
        import casadi as ca

        names = b.names
        pairs = [(i, names.index(n[:-2] + "_l")) for i, n in enumerate(names) if n.endswith("_r")]
        lateral = ("_list", "_bending", "_rotation")
        middle = [i for i, n in enumerate(names) if mirrored_name(n) == n and n.endswith(lateral)]

        def expression(q, v, a, u):
            return ca.vertcat(*(q[i] - q[j] for i, j in pairs), *(q[i] for i in middle))

        family = b.custom_family(
            "symmetry",
            (*(f"difference of {names[i][:-2]}" for i, _ in pairs), *(names[i] for i in middle)),
            expression,
        )
        b.penalise(family, 2.0 * self.weight)

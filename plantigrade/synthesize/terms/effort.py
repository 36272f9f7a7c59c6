"""Costs of effort and of haste: torque, work, acceleration, jerk."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from plantigrade.synthesize.problem.builder import ProblemBuilder
from plantigrade.synthesize.terms.term import Term, per_coordinate


@dataclass(frozen=True)
class Torque(Term):
    r"""Cost :math:`\int \sum w_j (\tau_j / \tau_1)^2 dt` of muscles' torques (Eq. 15).

    Attributes:
        weight: Weight of every joint [1/s].
        joints: Factor of single coordinates, by name without or with side.
    """

    weight: float = 1.0
    joints: Mapping[str, float] = field(default_factory=dict)

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh torques."""
        family = b.family("muscle torque")
        w = 2.0 * self.weight * per_coordinate(b.names[6:], self.joints)
        b.penalise(family, np.broadcast_to(w, family.weight.shape))


@dataclass(frozen=True)
class Work(Term):
    r"""Cost :math:`\int \sum w_j |\tau_j \dot q_j| dt` of what muscles work, per 100 J.

    Attributes:
        weight: Weight of every joint.
        joints: Factor of single coordinates, by name without or with side.
    """

    weight: float = 0.1
    joints: Mapping[str, float] = field(default_factory=dict)

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh work rates."""
        w = self.weight * per_coordinate(b.names[6:], self.joints)
        b.family("work rate").gain[:] += w * b.weights[:, None]


@dataclass(frozen=True)
class Acceleration(Term):
    r"""Cost :math:`\int \sum w_j \ddot q_j^2 dt`: what keeps a spline quiet between its nodes.

    Attributes:
        weight: Weight [s³/rad²].
        joints: Factor of single coordinates, by name without or with side.
    """

    weight: float = 1e-3
    joints: Mapping[str, float] = field(default_factory=dict)

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh accelerations."""
        family = b.family("accelerations")
        w = 2.0 * self.weight * per_coordinate(b.names, self.joints)
        b.penalise(family, np.broadcast_to(w, family.weight.shape))


@dataclass(frozen=True)
class Jerk(Term):
    r"""Cost :math:`\int \sum w_j \dddot q_j^2 dt`: quiet between nodes, and free to be quick.

    Attributes:
        weight: Weight [s⁵/rad²].
        joints: Factor of single coordinates, by name without or with side.
    """

    weight: float = 1e-8
    joints: Mapping[str, float] = field(default_factory=dict)

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh jerk."""
        b.jerk += 2.0 * self.weight * per_coordinate(b.names, self.joints)

"""Costs of effort and abruptness: torque, work, acceleration, jerk."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from plantigrade.arrays import Array, Float
from plantigrade.synthesize.problem.builder import ProblemBuilder
from plantigrade.synthesize.terms.term import Term, per_coordinate


@dataclass(frozen=True)
class Effort(Term):
    """A cost of every joint.

    Attributes:
        weight: Weight of every joint.
        joints: Factor of single coordinates, by name without or with side.
    """

    weight: float
    joints: Mapping[str, float] = field(default_factory=dict)

    def weights(self, names: tuple[str, ...]) -> Float[Array, " n"]:
        """Return the weight of every coordinate."""
        return self.weight * per_coordinate(names, self.joints)


@dataclass(frozen=True)
class Torque(Effort):
    r"""Cost :math:`\int \sum w_j (\tau_j / \tau_1)^2 dt` of muscle torques (Eq. 15); [1/s]."""

    weight: float = 1.0

    def add_to(self, b: ProblemBuilder) -> None:
        """Weight torques."""
        b.penalise(b.family("muscle torque"), 2.0 * self.weights(b.names[6:]))


@dataclass(frozen=True)
class Endurance(Term):
    r"""Cost :math:`\int w \sum |e_j|^3 dt` of ankle torques: an effort a muscle can go on with.

    Endurance falls with about the third power of a muscle's stress [Crowninshield1981]_.
    :math:`e_j` is the muscles' torque over :attr:`ContactBody.torque`; where the weaker muscles
    make it, the dorsiflexors, it is as much greater as they are weaker (216 against 54 N m).
    It is rounded off at :data:`~plantigrade.synthesize.problem.dynamics.SMALL`.

    Attributes:
        weight: :math:`w` [1/s].
    """

    weight: float = 0.3

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the rows."""
        b.penalise(b.family("endurance"), 2.0 * self.weight)


@dataclass(frozen=True)
class Work(Effort):
    r"""Cost :math:`\int \sum w_j |\tau_j \dot q_j| dt` of the work of muscles, per 100 J."""

    weight: float = 0.1

    def add_to(self, b: ProblemBuilder) -> None:
        """Weight work rates."""
        b.family("work rate").gain[:] += self.weights(b.names[6:]) * b.weights[:, None]


@dataclass(frozen=True)
class Acceleration(Effort):
    r"""Cost :math:`\int \sum w_j \ddot q_j^2 dt`, which keeps a spline smooth; [s³/rad²]."""

    weight: float = 1e-3

    def add_to(self, b: ProblemBuilder) -> None:
        """Weight accelerations."""
        b.penalise(b.family("accelerations"), 2.0 * self.weights(b.names))


@dataclass(frozen=True)
class Jerk(Effort):
    r"""Cost :math:`\int \sum w_j \dddot q_j^2 dt`: smooth, but free to be quick; [s⁵/rad²]."""

    weight: float = 1e-8

    def add_to(self, b: ProblemBuilder) -> None:
        """Weight jerk."""
        b.jerk += 2.0 * self.weights(b.names)

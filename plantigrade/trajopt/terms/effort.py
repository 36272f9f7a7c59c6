"""Costs of effort and abruptness: torque, work, acceleration, jerk."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.contact_body import TORQUE_SCALE
from plantigrade.trajopt.terms.term import Term, per_coordinate


@dataclass(frozen=True)
class Effort(Term):
    """A cost of every joint."""

    weight: float  #: Weight of every joint
    #: Factor of single coordinates, by name without or with side
    joints: Mapping[str, float] = field(default_factory=dict)
    others: float = 1.0  #: Factor of all other coordinates

    def weights(self, names: tuple[str, ...]) -> Float[Array, " n"]:
        """Return the weight of every coordinate."""
        return self.weight * per_coordinate(names, self.joints, self.others)


REFERENCE_STRENGTH = 200.0
"""Joint strength at which costs of torque and relative torque are equal, for the reference mass and
height [N m]."""


@dataclass(frozen=True)
class Torque(Effort):
    r"""Cost :math:`\int \sum w_j (\tau_j / \tau_1)^2 dt` of muscle torques (Eq. 15); [1/s].

    Attributes:
        by_strength: Whether joints count by what part of their strength they use, as muscles do by
            their stress [Crowninshield1981]_: an arm that is held up costs more than a hip that
            bears as much.
    """

    weight: float = 1.0
    by_strength: bool = False

    def add_to(self, b: ProblemBuilder) -> None:
        """Weight torques."""
        weights = self.weights(b.names[6:])
        if self.by_strength:
            strength = np.abs(b.body.human.model.jnt_actfrcrange[1:]).max(axis=1)
            strong = REFERENCE_STRENGTH / TORQUE_SCALE * b.body.torque
            weights = weights * (strong / np.where(strength > 0, strength, strong)) ** 2
        b.penalise(b.family("muscle torque"), 2.0 * weights)


@dataclass(frozen=True)
class Endurance(Term):
    r"""Cost :math:`\int w \sum |e_j|^3 dt` of ankle torques: an effort a muscle can go on with.

    Endurance falls with about the third power of a muscle's stress [Crowninshield1981]_.
    :math:`e_j` is the muscles' torque over :attr:`ContactBody.torque`; where the weaker muscles
    make it, the dorsiflexors, it is as much greater as they are weaker (216 against 54 N m).
    It is rounded off at :data:`~plantigrade.trajopt.problem.dynamics.ENDURANCE_ROUNDING`.
    """

    weight: float = 0.3  #: :math:`w` [1/s]

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
class AnklePower(Term):
    r"""Cost :math:`\int w \sum p_j^4 dt` of power of the ankles' muscles, made or absorbed [100 W].

    Beyond the speed at which a muscle is most efficient it takes more energy for the same work
    [Hill1938]_. The fourth power lowers great powers, as up a slope, and leaves those on level
    ground nearly as they are; the second does not tell them apart as well.
    """

    weight: float = 0.1  #: :math:`w` [per (100 W)⁴ s]

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh the rows."""
        b.penalise(b.family("squared power"), 2.0 * self.weight)


@dataclass(frozen=True)
class Acceleration(Effort):
    r"""Cost :math:`\int \sum w_j \ddot q_j^2 dt`, which keeps a spline smooth; [s³/rad²]."""

    weight: float = 1e-3

    def add_to(self, b: ProblemBuilder) -> None:
        """Weight accelerations."""
        b.penalise(b.family("accelerations"), 2.0 * self.weights(b.names))


MIN_INERTIA_SHARE = 0.1
"""Minimum inertia of a coordinate relative to the knee's [1], so that light parts such as toes and
hands move smoothly."""


@dataclass(frozen=True)
class Jerk(Effort):
    r"""Cost :math:`\int \sum w_j \dddot q_j^2 dt`: smooth, but free to be quick; [s⁵/rad²].

    Attributes:
        by_inertia: Whether coordinates count by what they move (:func:`relative_inertia`), as in
            the metric of kinetic energy [Biess2007]_: a foot may be flicked, a leg may not.
    """

    weight: float = 1e-8
    by_inertia: bool = False

    def add_to(self, b: ProblemBuilder) -> None:
        """Weight jerk."""
        inertia = relative_inertia(b.body.human) if self.by_inertia else 1.0
        b.jerk += 2.0 * self.weights(b.names) * inertia


def relative_inertia(human: Human) -> Float[Array, " nv"]:
    """Return the inertia of each coordinate relative to the knee's, bounded from below.

    The lower bound is :data:`MIN_INERTIA_SHARE`.

    The inertia is the diagonal of the mass matrix in the neutral posture, where the pelvis' angles
    are about the axes of the world.

    Returns:
        Values for the pelvis' tilt, list, rotation [1] and position [1/m²], then for the hinges
        [1].

    Example:
        >>> person = Human.create(1.75, 77.5)
        >>> inertia = dict(zip(person.coordinates, relative_inertia(person)[6:], strict=True))
        >>> legs = ("hip_flexion_r", "knee_angle_r", "ankle_angle_r")
        >>> [round(float(inertia[name]), 1) for name in legs]
        [6.7, 1.0, 0.1]
    """
    found = np.diag(BodyState(human, human.model.qpos0).mass_matrix)
    about_x, about_y, about_z = found[3:6]
    root = [about_y, about_x, about_z, *found[:3]]
    knee = found[6:][human.coordinates.index("knee_angle_r")]
    return np.maximum(np.concatenate([root, found[6:]]) / knee, MIN_INERTIA_SHARE)

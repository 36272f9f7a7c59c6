"""Terms of impairments: weak muscles, braces, unequal soles."""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.contact.plan import ContactPlan
from plantigrade.models.mirror import mirror_sign, mirrored_name
from plantigrade.record.conditions import Condition
from plantigrade.side_names import opposite
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.terms.limits import Limits
from plantigrade.trajopt.terms.term import Term


@dataclass(frozen=True)
class Weakness(Term):
    """Muscles of a coordinate have part of their strength; tissue keeps its stiffness.

    Attributes:
        coordinate: Its name.
        negative: Part of the strength in the negative direction.
        positive: Part of the strength in the positive direction.
        reserve: Part of it that is not used at nodes: between them torque may swing out a little.
    """

    coordinate: str
    negative: float = 1.0
    positive: float = 1.0
    reserve: float = Limits.reserve

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit the torque of the muscles."""
        low, high = (
            (1.0 - self.reserve) * bound / b.body.torque for bound in self._strength(b.body)
        )
        column = b.names[6:].index(self.coordinate)
        b.limit(b.family("muscle torque"), low, high, columns=[column])

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return the limits of the torque; none beside a brace, which the checker does not know."""
        if self.coordinate in {brace.coordinate for brace in body.braces}:
            return ()
        low, high = self._strength(body)
        name = f"strength of {self.coordinate}"
        bounds = (0.0, np.inf), (low,) * 2, (high,) * 2
        return (Condition(name, "muscle torque", *bounds, self.coordinate),)

    def mirrored(self) -> "Weakness":
        """Return the same weakness of the other side."""
        parts = (self.negative, self.positive)
        negative, positive = parts[::-1] if mirror_sign(self.coordinate) < 0 else parts
        name = mirrored_name(self.coordinate)
        return replace(self, coordinate=name, negative=negative, positive=positive)

    def _strength(self, body: ContactBody) -> tuple[float, float]:
        """Return the least and the largest torque [N m]."""
        low, high = body.human.model.jnt_actfrcrange[1 + body.human.hinge(self.coordinate)]
        return float(self.negative * low), float(self.positive * high)


@dataclass(frozen=True)
class Brace(Term):
    r"""A spring across a joint, as of an orthosis; the moment :math:`-k (q - q_0)`.

    The task makes the body with it (:meth:`~plantigrade.trajopt.tasks.task.MotionTask.body_of`).
    """

    coordinate: str  #: Name of the coordinate
    #: :math:`k` [N m/rad]; of ankle-foot orthoses about 40 (flexible) to 400 (rigid)
    stiffness: float
    neutral: float = 0.0  #: :math:`q_0` [rad]

    def add_to(self, b: ProblemBuilder) -> None:
        """Check that the body wears it.

        Raises:
            ParameterError: If it does not.
        """
        b.body.check_worn(self)

    def mirrored(self) -> "Brace":
        """Return the same brace on the other side."""
        name, neutral = mirrored_name(self.coordinate), self.neutral
        return replace(self, coordinate=name, neutral=neutral * mirror_sign(self.coordinate))


@dataclass(frozen=True)
class Uneven(Term):
    """Soles or loads differ between the sides: no half stride mirrors the other."""

    side: str  #: The foot, ``"r"`` or ``"l"``

    def add_to(self, b: ProblemBuilder) -> None:
        """Add nothing: soles and loads belong to the body."""

    def mirrored(self) -> "Uneven":
        """Return the term of the other foot."""
        return replace(self, side=opposite(self.side))

"""Feet pass over blocks on the ground."""

from dataclasses import dataclass

from plantigrade.contact.plan import ContactPlan
from plantigrade.record.conditions import Condition
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.terms.term import Term

EDGE_MARGIN = 0.06
"""Distance before and behind a block within which the foot is above it [m], because a foot moves by
up to 0.1 m between two nodes."""


@dataclass(frozen=True)
class StepOver(Term):
    r"""Contact sites of the feet are above the blocks of the plan, by a margin.

    A site at :math:`x` of a block at :math:`x_0` is higher than
    :math:`(h + m) \exp(-((x - x_0) / s)^4)`, a smooth hill around it.
    """

    margin: float = 0.04  #: :math:`m`, above the block [m]
    tolerance: float = 0.002
    """How far a site may be below the hill [m]: a sole that stands beside a block is at zero, and
    the hill is not quite zero there."""

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit the height above the hills."""
        import casadi as ca

        feet = [site for site in b.body.sites if site.side]
        positions = b.body.symbolic.positions(feet)
        for block in b.plan.obstacles:
            reach = block.width / 2 + EDGE_MARGIN

            def expression(q, v, a, u, block=block, reach=reach):
                p = positions(q)
                hill = ca.exp(-(((p[0, :] - block.x) / reach) ** 4))
                return (p[2, :] - (block.height + self.margin) * hill).T

            names = tuple(f"{site.name} above the obstacle at {block.x:.2f} m" for site in feet)
            family = b.custom_family(f"obstacle at {block.x:.3f} m", names, expression, "m")
            b.limit(family, lower=-self.tolerance)

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return nothing: blocks belong to the ground of the Record, which the check knows."""
        return ()

"""Feet pass over blocks on the ground."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import Point
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.terms.limb_shapes import leg_rods, sphere_count
from plantigrade.trajopt.terms.term import Spaced, Term

EDGE_MARGIN = 0.06
"""Distance before and behind a block within which the foot is above it [m], because a foot moves by
up to 0.1 m between two nodes."""
PEAK_SPEED = 1.875  # [1] of a smooth swing, relative to its mean speed


@dataclass(frozen=True)
class StepOver(Term):
    r"""Contact sites of the feet, and the shanks, are above the blocks of the plan, by a margin.

    A sphere whose lowest point is at :math:`x` and a block at :math:`x_0`: it is higher than
    :math:`(h + m) \exp(-((x - x_0) / s)^4)`, a smooth hill around the block.
    """

    margin: float = 0.04
    """:math:`m` of the feet, above the block [m]; older people have .13 to .18 [Kuo2022]_; with
    .06 m no way over .4 m was found."""
    shank_margin: float = 0.02  #: :math:`m` of the shanks, which are not as near between nodes [m]
    node_distance: float = 0.06
    """How far a foot moves from node to node as it passes a block [m], about as far as the hill is
    wider than the block."""
    tolerance: float = 0.002
    """How far a site may be below the hill [m]: a sole that leaves the ground beside a block, or
    comes to it, is near zero, and the hill is not quite zero there."""

    def spaced(self, plan: ContactPlan) -> tuple[Spaced, ...]:
        """Return the swings that pass a block."""
        found = []
        for side in SIDES:
            stances = [stance for stance in plan.stances if stance.footprint.side == side]
            for one, two in pairwise(stances):
                here, there = (each.footprint.position[0] for each in (one, two))
                if any(here < block.x < there for block in plan.obstacles):
                    duration = two.heel_strike - one.toe_off
                    longest = self.node_distance * duration / (PEAK_SPEED * (there - here))
                    found.append((one.toe_off, two.heel_strike, longest))
        return tuple(found)

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit the height above the hills."""
        import casadi as ca

        feet = [(site.name, site, self.margin) for site in b.body.sites if site.side]
        shanks = []
        for side in SIDES:
            rod = leg_rods(b.body.human, side)[1]
            for k, ball in enumerate(rod.points(sphere_count(b.body.human, rod))):
                point = Point(ball.body, tuple(map(float, ball.a)), ball.radius)
                shanks.append((f"shank {side} {k + 1}", point, self.shank_margin))
        names, points, margins = zip(*feet, *shanks, strict=True)
        positions = b.body.symbolic.positions(points)
        # what stands beside a block is at zero, and the hill, the higher the wider, is not
        lower = np.full((len(b.nodes), len(names)), -self.tolerance)
        for i, (_, site, _) in enumerate(feet):
            lower[b.plan.standing(site, b.nodes), i] = -np.inf
        for block in b.plan.obstacles:
            reach = block.width / 2 + EDGE_MARGIN
            top = block.height + np.array(margins)

            def expression(q, v, a, u, block=block, reach=reach, top=top):
                p = positions(q)
                hill = ca.exp(-(((p[0, :] - block.x) / reach) ** 4))
                return (p[2, :] - top[None] * hill).T

            rows = tuple(f"{name} above the obstacle at {block.x:.2f} m" for name in names)
            family = b.custom_family(f"obstacle at {block.x:.3f} m", rows, expression, "m")
            b.limit(family, lower=lower)

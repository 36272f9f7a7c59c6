r"""Terms of contact: equations of motion, what stands, what swings, what forces cost."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import FRICTION, SIDES
from plantigrade.contact.flat_foot import flat_sites
from plantigrade.contact.ground import Ground
from plantigrade.contact.plan import TIME_TOLERANCE, ContactPlan, Stance
from plantigrade.errors import ParameterError
from plantigrade.motion.blends import quintic_rise
from plantigrade.record.conditions import Condition
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.contact import (
    MAX_UNLOADED_DEPTH,
    friction_pyramid,
    hold_contacts,
    keep_soles_up,
    site_forces,
    soles_of,
)
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.terms.term import Term

EDGE_MARGIN = 0.02
"""Distance that a swing foot keeps from the edge of a tread until it is as high as the tread [m];
2 cm leaves a few millimetres to the motion between nodes."""


@dataclass(frozen=True)
class Dynamics(Term):
    """The equations of motion: nothing but gravity and contact moves the root."""

    def add_to(self, b: ProblemBuilder) -> None:
        """Ask for the rows; those of the root are equations."""
        b.family("dynamics")


@dataclass(frozen=True)
class Contact(Term):
    """Feet on the ground do not slip, and carry force within the friction cone.

    Attributes:
        friction: Coefficient of friction.
        force: Largest vertical force at a site [body weights].
        used: Share of the friction that a person plans to use, if less than all: people walk as on
            dry ground down to a coefficient of 0.41 [Fong2009]_.
        soft_landing: Whether parts of the feet land at rest. If not, the speed of a part that lands
            is free, and it comes to rest within a step of the nodes.
    """

    friction: float = FRICTION
    force: float = 3.0
    used: float = np.inf
    soft_landing: bool = True

    def add_to(self, b: ProblemBuilder) -> None:
        """Hold sites, and let those carry that stand on both sides of a node."""
        place, speed = b.family("contact"), b.family("contact speed")
        hold_contacts(b.body, b.plan, b.nodes, place, speed, soft_landing=self.soft_landing)
        soles, spheres = soles_of(b.body, len(b.nodes))
        if soles is not None:
            keep_soles_up(b.body, b.plan, b.nodes, b.add(soles), spheres)
        most = min(self.friction, self.used)
        friction = b.add(friction_pyramid(b.body, len(b.nodes), most))
        for k, site in enumerate(b.body.sites):
            carries = b.plan.carrying(site, b.nodes)
            side = float(b.body.friction(most)[k]) * self.force
            low, high = np.array([-side, -side, 0.0]), np.array([side, side, self.force])
            if not np.array_equal(b.body.surfaces[k], np.eye(3)):  # the pyramid says where it acts
                high = np.full(3, float(np.hypot(self.force, side)))
                low = -high
            b.force_lower[carries, 3 * k : 3 * k + 3] = low
            b.force_upper[carries, 3 * k : 3 * k + 3] = high
            friction.lower[carries, 4 * k : 4 * k + 4] = 0.0


@dataclass(frozen=True)
class Above(Term):
    """A site stays above a level whenever it does not rest there: a seat."""

    site: str  #: Name of the contact site
    height: float  #: Height of the level [m]

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit the height of the lowest point."""
        k = self._index(b.body)
        free = ~b.plan.standing(b.body.sites[k], b.nodes)
        free[[0, -1]] = False  # where a posture is stricter
        nodes = np.flatnonzero(free).tolist()
        b.limit(b.family("contact"), self.height, columns=[3 * k + 2], nodes=nodes)

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return that the site is above the level before, between and after it rests."""
        site = body.sites[self._index(body)]
        rests = sorted(plan.intervals(site))
        begins, ends = [0.0, *(b for _, b in rests)], [*(a for a, _ in rests), plan.duration]
        return tuple(
            Condition(
                f"height of {site.name}", "point", (a, b), (self.height,) * 2, (np.inf,) * 2,
                site.body, "z", site.position, site.radius,
            )
            for a, b in zip(begins, ends, strict=True)
            if b - a > TIME_TOLERANCE
        )  # fmt: skip

    def _index(self, body: ContactBody) -> int:
        names = [s.name for s in body.sites]
        if self.site not in names:
            raise ParameterError(f"no site {self.site!r}; there are {', '.join(names)}")
        return names.index(self.site)


@dataclass(frozen=True)
class InFront(Term):
    """A site stays in front of the surface of its support whenever it does not rest there."""

    site: str  #: Name of the contact site

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit the distance along the normal."""
        import casadi as ca

        support = next((s for s in b.plan.supports if s.site.name == self.site), None)
        if support is None:
            names = ", ".join(s.site.name for s in b.plan.supports) or "none"
            raise ParameterError(f"the plan has no support of {self.site!r}; there are {names}")
        positions = b.body.symbolic.positions([support.site])
        normal = np.array(support.normal)

        def expression(q, v, a, u):
            return ca.dot(ca.DM(normal), positions(q))

        name = f"distance of {self.site} from its support"
        family = b.custom_family(name, (name,), expression, "m")
        free = ~b.plan.standing(support.site, b.nodes)
        surface = support.places(b.nodes[free]) @ normal
        b.limit(family, surface[:, None], nodes=np.flatnonzero(free).tolist())


@dataclass(frozen=True)
class Clearance(Term):
    r"""A foot in the air is at least :math:`h \sin^4(\pi s)` high at part :math:`s` of its swing.

    Every edge of a tread on the way is passed round its corner: up, a point of the foot stays
    before the edge up to one node and is above the tread from that node on; down, it is above the
    tread up to one node and beyond the edge from that node on. At the node both hold, so that
    nothing cuts the corner between two nodes. It is the node nearest to the instant at which a
    foot that moves smoothly from footprint to footprint meets the edge.
    """

    height: float = 0.02  #: In the middle of the swing [m]

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit heights of the sites of a swinging foot."""
        family, ground = b.family("contact"), Ground.of_plan(replace(b.plan, obstacles=()))
        for side, one, two in _swings(b.plan):
            swing = (b.nodes > one.toe_off) & (b.nodes < two.heel_strike)
            at = np.flatnonzero(swing).tolist()
            part = (b.nodes[swing] - one.toe_off) / (two.heel_strike - one.toe_off)
            if ground.steps:
                self._round_edges(b, ground, (one, two), part, at)
                continue
            low = ground.height + self.height * np.sin(np.pi * part) ** 4
            columns = [3 * k + 2 for k, site in enumerate(b.body.sites) if site.side == side]
            b.limit(family, low[:, None], columns=columns, nodes=at)

    def _round_edges(
        self,
        b: ProblemBuilder,
        ground: Ground,
        stances: tuple[Stance, Stance],
        part: Float[Array, " n"],
        nodes: list[int],
    ) -> None:
        """Limit places of all spheres of a foot between two stances."""
        one, two = stances
        side, family = one.footprint.side, b.family("contact")
        here, there = one.footprint.position[0], two.footprint.position[0]
        gone = here + (there - here) * quintic_rise(part)
        above = self.height * np.sin(np.pi * part) ** 4
        soles, spheres = soles_of(b.body, len(b.nodes))
        under = b.body.cache.get(
            ("flat spheres", side),
            lambda: flat_sites(b.body.human, (*b.body.sites, *spheres), side),
        )
        for k, site in enumerate(b.body.sites):
            if site.side == side:
                x = gone + float(under[site.name][0])
                low, near, far = _corners(ground, x, site.radius)
                b.limit(family, (low + above)[:, None], columns=[3 * k + 2], nodes=nodes)
                b.limit(family, far[:, None], near[:, None], columns=[3 * k], nodes=nodes)
        for k, sphere in enumerate(spheres):
            if sphere.side == side and soles is not None:
                x, _, deep = under[sphere.name]
                low = _corners(ground, gone + float(x), 0.0)[0]
                low += min(float(deep), 0.0) - MAX_UNLOADED_DEPTH
                b.limit(b.add(soles), low[:, None], columns=[k], nodes=nodes)

    def conditions(self, body: ContactBody, plan: ContactPlan) -> tuple[Condition, ...]:
        """Return how high each site is at least over its swings."""
        part = np.linspace(0.0, 1.0, 17)
        low = tuple(float(x) for x in self.height * np.sin(np.pi * part) ** 4)
        found = []
        for side, one, two in _swings(plan):
            # of a periodic plan, each swing once: in the period in which it begins
            if plan.periodic and not 0.0 <= one.toe_off < plan.duration:
                continue
            time = one.toe_off + part * (two.heel_strike - one.toe_off)
            found += [
                Condition(
                    f"clearance of {site.name}", "clearance", tuple(map(float, time)), low,
                    (np.inf,) * len(low), site.body, "", site.position, site.radius,
                )
                for site in body.sites
                if site.side == side
            ]  # fmt: skip
        return tuple(found)


def _swings(plan: ContactPlan) -> Iterator[tuple[str, Stance, Stance]]:
    """Yield the side of every swing, and the stances before and after it."""
    for side in SIDES:
        stances = [s for s in plan.unrolled() if s.footprint.side == side]
        yield from ((side, one, two) for one, two in pairwise(stances))


def _corners(
    ground: Ground, x: Float[Array, " n"], radius: float
) -> tuple[Float[Array, " n"], Float[Array, " n"], Float[Array, " n"]]:
    """Return least heights, and largest and least places along x, of a point on its way [m].

    Args:
        x: Where the point is at the nodes of a swing if it moves smoothly [m].
        radius: Radius of the sphere that rolls, which places along x leave out [m].
    """
    low = ground.along(x)
    near, far = np.full(len(x), np.inf), np.full(len(x), -np.inf)
    before = ground.height
    for step in ground.steps:
        if x[0] < step.x < x[-1]:
            node = int(np.argmin(np.abs(x - step.x)))
            low[node] = max(low[node], before, step.height)
            if step.height > before:
                near[: node + 1] = np.minimum(near[: node + 1], step.x - EDGE_MARGIN - radius)
            else:
                far[node:] = np.maximum(far[node:], step.x + EDGE_MARGIN)
        before = step.height
    return low, near, far


@dataclass(frozen=True)
class Forces(Term):
    r"""Cost of contact forces [body weights]: :math:`\int w |f|^2 + w_s |\dot f|^2 dt`."""

    #: Weight of the forces themselves, which shares a load between neighbours [1/s]
    size: float = 1e-3
    rate: float = 5e-3  #: Weight of their rates [s]

    def add_to(self, b: ProblemBuilder) -> None:
        """Weigh forces."""
        family = b.add(site_forces(b.body, len(b.nodes)))
        b.penalise(family, 2.0 * self.size)
        b.force_steps += 2.0 * self.rate / b.steps[:, None]

r"""Terms of contact: equations of motion, what stands, what swings, what forces cost."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from plantigrade.constants import FRICTION, SIDES
from plantigrade.contact.flat_foot import flat_sites
from plantigrade.contact.ground import Ground
from plantigrade.contact.plan import TIME_TOLERANCE, ContactPlan, Footprint, Stance
from plantigrade.errors import ParameterError
from plantigrade.record.conditions import Condition
from plantigrade.trajopt.problem.builder import ProblemBuilder
from plantigrade.trajopt.problem.contact import (
    MAX_UNLOADED_DEPTH,
    friction_pyramid,
    hold_contacts,
    keep_soles_up,
    site_forces,
    site_targets,
    soles_of,
)
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.terms.term import Term

STEP_MARGIN = 0.06  #: Lateral margin for the clearance of a swing foot over a step [m]

TILT_MARGIN = 0.005
"""Additional height of this clearance [m], because some spheres of a tilted foot are not contact
sites."""


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
    """

    friction: float = FRICTION
    force: float = 3.0
    used: float = np.inf

    def add_to(self, b: ProblemBuilder) -> None:
        """Hold sites, and let those carry that stand on both sides of a node."""
        hold_contacts(b.body, b.plan, b.nodes, b.family("contact"), b.family("contact speed"))
        soles, spheres = soles_of(b.body, len(b.nodes))
        if soles is not None:
            keep_soles_up(b.body, b.plan, b.nodes, b.add(soles), spheres)
        most = min(self.friction, self.used)
        friction = b.add(friction_pyramid(b.body, len(b.nodes), most))
        for k, site in enumerate(b.body.sites):
            carries = b.plan.carrying(site, b.nodes)
            side = most * self.force
            b.force_lower[carries, 3 * k : 3 * k + 3] = (-side, -side, 0.0)
            b.force_upper[carries, 3 * k : 3 * k + 3] = (side, side, self.force)
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
class Clearance(Term):
    r"""A foot in the air is at least :math:`h \sin^4(\pi s)` high at part :math:`s` of its swing.

    Steps in the ground are cleared where a smoothly moving foot meets them, by the spheres of its
    soles that carry no force, too.
    """

    height: float = 0.02  #: In the middle of the swing [m]

    def add_to(self, b: ProblemBuilder) -> None:
        """Limit heights of the sites of a swinging foot."""
        family, ground = b.family("contact"), Ground.of_plan(b.plan)
        flat = {s: site_targets(b.body, Footprint(s, (0.0, 0.0, 0.0))) for s in SIDES}
        soles, spheres = soles_of(b.body, len(b.nodes)) if ground.steps else (None, ())
        for side, one, two in _swings(b.plan):
            swing = (b.nodes > one.toe_off) & (b.nodes < two.heel_strike)
            at = np.flatnonzero(swing).tolist()
            part = (b.nodes[swing] - one.toe_off) / (two.heel_strike - one.toe_off)
            (here, _, before), (there, _, after) = one.footprint.position, two.footprint.position
            gone = here + (there - here) * part**3 * (10 - 15 * part + 6 * part**2)
            above = self.height * np.sin(np.pi * part) ** 4
            # Both ends of an interval in which a step is crossed are above it.
            moved = np.abs(np.diff(np.concatenate([[here], gone, [there]])))
            margin = np.maximum(STEP_MARGIN, np.maximum(moved[:-1], moved[1:]))
            margin = np.where((part > 0.02) & (part < 0.98), margin, 0.0)
            for k, site in enumerate(b.body.sites):
                if site.side == side:
                    x = gone + float(flat[side][site.name][0])
                    edge = ground.along(x - margin) != ground.along(x + margin)
                    low = ground.along(x, margin) + above + TILT_MARGIN * edge
                    b.limit(family, low[:, None], columns=[3 * k + 2], nodes=at)
                    if after < before:  # it does not lag behind
                        b.limit(family, (x - STEP_MARGIN)[:, None], columns=[3 * k], nodes=at)
            if soles is not None:
                under = flat_sites(b.body.human, (*b.body.sites, *spheres), side)
                for k, sphere in enumerate(spheres):
                    if sphere.side == side:
                        x, _, deep = under[sphere.name]
                        low = (
                            ground.along(gone + float(x), margin)
                            + min(float(deep), 0.0)
                            - MAX_UNLOADED_DEPTH
                        )
                        b.limit(b.add(soles), low[:, None], columns=[k], nodes=at)

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

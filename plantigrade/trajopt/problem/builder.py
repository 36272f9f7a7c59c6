r"""A problem under construction.

Terms ask a :class:`ProblemBuilder` for families of rows by name and limit or weigh them; families
that no term uses are not evaluated. Costs are integrals over time, so a weight means the same on
every mesh: at nodes they are weighed with the trapezoidal rule.
"""

from collections.abc import Callable, Mapping

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import TIME_TOLERANCE, ContactPlan
from plantigrade.contact.site import Point
from plantigrade.errors import CoordinateNotFound, ParameterError, known_names
from plantigrade.record.conditions import AXES
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily, node_symbols
from plantigrade.trajopt.problem.contact import headings, site_places
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.problem.dynamics import dynamics
from plantigrade.trajopt.problem.nlp import PeriodicClosure, Problem
from plantigrade.trajopt.splines.basis import Basis

MOTION = ("coordinates", "speeds", "accelerations")

_MAKERS: Mapping[str, Callable[["ProblemBuilder"], ConstraintFamily]] = {
    "dynamics": lambda b: dynamics(b.body, len(b.nodes), b.body.external.parameters(b.nodes)),
    "contact": lambda b: site_places(b.body, b.headings, rates=False),
    "contact speed": lambda b: site_places(b.body, b.headings, rates=True),
    **{name: lambda b, name=name: b.motion_family(name) for name in MOTION},
}
_PARTS = (
    *("root force", "root moment", "muscle torque", "work rate", "joint torque"),
    *("endurance", "squared power"),
)
"""Families that are parts of the dynamics."""


class ProblemBuilder:
    """Collects terms and builds a problem.

    Raises:
        ParameterError: If the body was made for ground of another slope or motion, or lacks a site
            that the plan rests on.

    Attributes:
        body: The person.
        plan: Contacts.
        nodes: Times of the nodes [s].
        steps: Time from each node to the next [s].
        weights: Weight of each node in an integral over time [s].
        headings: Heading of each site's footprint at each node [rad].
        force_lower: Lower limits of contact forces (n_nodes, 3 n_sites) [body weights]; zero where
            a site does not carry.
        force_upper: Upper limits.
        force_steps: Weights of their squared steps from node to node.
        jerk: Weights of squared jerk of coordinates.
    """

    def __init__(self, body: ContactBody, plan: ContactPlan, nodes: Float[Array, " n_nodes"]):
        self.body, self.plan, self.nodes = body, plan, nodes
        _check(body, plan)
        step = np.diff(nodes)
        self.weights = np.zeros(len(nodes))
        self.weights[:-1] += step / 2
        self.weights[1:] += step / 2
        if plan.periodic:  # the last node is the one before the end, which is the first again
            last = plan.duration - nodes[-1]
            self.weights[-1] += last / 2
            self.weights[0] += last / 2
            step = np.append(step, last)
        self.steps = step
        self.headings = headings(body, plan, nodes)
        n_forces = 3 * len(body.sites)
        self.force_lower = np.zeros((len(nodes), n_forces))
        self.force_upper = np.zeros((len(nodes), n_forces))
        self.force_steps = np.zeros((len(step), n_forces))
        self.jerk = np.zeros(body.symbolic.nv)
        self._families: dict[str, ConstraintFamily] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return self.body.symbolic.names

    def family(self, name: str) -> ConstraintFamily:
        """Return a family by name, made at the first call.

        It is ``"dynamics"`` or one of its parts (``"root force"``, ``"root moment"``,
        ``"muscle torque"``, ``"work rate"``, ``"joint torque"``, ``"endurance"``,
        ``"squared power"``), ``"contact"``, ``"contact speed"``, ``"coordinates"``, ``"speeds"``,
        ``"accelerations"``, or a family that a term has added.

        Raises:
            ParameterError: If there is no such family.
        """
        if name in _PARTS:
            return next(part for part in self.family("dynamics").parts if part.name == name)
        if name not in self._families:
            if name not in _MAKERS:
                known = dict.fromkeys((*_MAKERS, *_PARTS, *self._families))
                raise ParameterError(f"no family {name!r}; there are {', '.join(known)}")
            self._families[name] = _MAKERS[name](self)
        return self._families[name]

    def add(self, family: ConstraintFamily) -> ConstraintFamily:
        """Add a family, or return the one of the same name that was added before."""
        return self._families.setdefault(family.name, family)

    def custom_family(
        self, name: str, names: tuple[str, ...], expression: Callable, unit: str = ""
    ) -> ConstraintFamily:
        """Return a family of a term's own, made at the first call.

        Args:
            expression: (q, qd, qdd, u) ↦ column of rows, in units in which 1 is large.
        """
        import casadi as ca

        given = node_symbols(len(self.names), 3 * len(self.body.sites))
        function = ca.Function("rows", list(given), [expression(*given[:4])])
        return self.add(ConstraintFamily.free(name, function, names, len(self.nodes), unit=unit))

    def place_of(self, point: Point, doing: str) -> ConstraintFamily:
        """Return where a point of the body is as rows, world [m].

        Args:
            doing: What it does there, for the names of the rows: ``"reaches"``.

        Raises:
            ParameterError: If the person has no such body.
        """
        try:
            positions = self.body.symbolic.positions([point])
        except CoordinateNotFound as error:
            raise ParameterError(str(error)) from error
        names = tuple(f"{axis} of {point.body} that {doing}" for axis in AXES)
        name = f"place of {point.body} {point.position} that {doing}"
        return self.custom_family(name, names, lambda q, v, a, u: positions(q), "m")

    def motion_family(self, what: str) -> ConstraintFamily:
        """Return coordinates, their rates or accelerations as rows: one of :data:`MOTION`."""
        i = MOTION.index(what)
        function = self.body.function(what, lambda ca, *states: states[i])
        prefix = ("", "speed of ", "acceleration of ")[i]
        names = tuple(prefix + n for n in self.names)
        return ConstraintFamily.free(what, function, names, len(self.nodes))

    def column(self, coordinate: str) -> int:
        """Return the index of a coordinate.

        Raises:
            ParameterError: If there is no such coordinate.
        """
        if coordinate not in self.names:
            raise ParameterError(
                f"no coordinate {coordinate!r}; {known_names(coordinate, self.names)}"
            )
        return self.names.index(coordinate)

    def node(self, time: float) -> int:
        """Return the node at a time; a task's mesh has one wherever a term requires it.

        Raises:
            ParameterError: If there is none.
        """
        k = int(np.argmin(np.abs(self.nodes - time)))
        if not abs(self.nodes[k] - time) <= 10 * TIME_TOLERANCE:
            raise ParameterError(
                f"no node at {time:g} s: nodes go from {self.nodes[0]:g} to {self.nodes[-1]:g} s, "
                f"the nearest is at {self.nodes[k]:g} s"
            )
        return k

    def during(self, start: float, stop: float) -> list[int]:
        """Return the nodes from ``start`` to ``stop`` [s], both included."""
        inside = (self.nodes >= start - TIME_TOLERANCE) & (self.nodes <= stop + TIME_TOLERANCE)
        return np.flatnonzero(inside).tolist()

    def penalise(
        self,
        family: ConstraintFamily,
        weight: Float[Array, "..."] | float,
        target: Float[Array, "..."] | float = 0.0,
    ) -> None:
        r"""Add :math:`\tfrac12 w (r - \bar r)^2` to the cost, times the time of each node.

        Raises:
            ParameterError: If a weight is negative or not finite.
        """
        _check_weight(weight, family.name)
        w = np.broadcast_to(weight, family.weight.shape) * self.weights[:, None]
        both = family.weight + w
        safe = np.where(both > 0, both, 1.0)
        family.target[:] = np.where(
            w > 0, (family.weight * family.target + w * np.asarray(target)) / safe, family.target
        )
        family.weight[:] = both

    def limit(
        self,
        family: ConstraintFamily,
        lower: Float[Array, "..."] | float = -np.inf,
        upper: Float[Array, "..."] | float = np.inf,
        *,
        columns: "slice | list[int]" = slice(None),
        nodes: "slice | list[int]" = slice(None),
    ) -> None:
        """Narrow the limits of rows; equations stay as they are."""
        grid = np.ix_(np.arange(len(self.nodes))[nodes], np.arange(family.lower.shape[1])[columns])
        low, high = family.lower[grid], family.upper[grid]
        fixed = low == high
        family.lower[grid] = np.where(fixed, low, np.maximum(low, lower))
        family.upper[grid] = np.where(fixed, high, np.minimum(high, upper))

    def problem(self, basis: Basis, closure: PeriodicClosure | None = None) -> Problem:
        """Return the problem; families without limits and costs are left out.

        Raises:
            ParameterError: If a weight is negative or not finite; that of a linear cost, the gain
                of a family, may be negative.
        """
        _check_weight(self.force_steps, "rates of contact forces")
        _check_weight(self.jerk, "jerk")
        for family in self._families.values():
            for part in family.parts or (family,):
                _check_weight(np.abs(part.gain), part.name)
        used = tuple(f for f in self._families.values() if f.matters.any())
        return Problem(
            basis,
            self.nodes,
            self.names,
            used,
            self.body.force_names,
            self.force_lower,
            self.force_upper,
            self.force_steps,
            closure,
            self.jerk if self.jerk.any() else np.zeros(0),
        )


def _check_weight(weight: Float[Array, "..."] | float, cost: str) -> None:
    """Refuse a weight by which a cost has no least value."""
    if not np.all(np.isfinite(weight) & (np.asarray(weight) >= 0.0)):
        raise ParameterError(f"weights of the cost of {cost} must be finite, zero or more")


def _check(body: ContactBody, plan: ContactPlan) -> None:
    """Refuse a body that was made for another plan."""
    remedy = "use ContactBody.for_plan(human, task.plan)"
    g = body.symbolic.gravity
    leaning = plan.to_world.T @ np.array([0.0, 0.0, -np.linalg.norm(g)])
    if not np.allclose(g, leaning, atol=1e-6):
        raise ParameterError(
            f"the ground rises by {np.rad2deg(plan.slope):g}° and the body was made for another "
            f"slope: {remedy}"
        )
    if plan.motion != (None if body.external.plan is None else body.external.plan.motion):
        raise ParameterError(f"the body was made for ground that moves otherwise: {remedy}")
    names = {site.name for site in body.sites}
    missing = [s.site.name for s in plan.supports if s.site.name not in names]
    if missing:
        raise ParameterError(
            f"the plan rests on {missing[0]!r}, and the body has no such site: {remedy}"
        )

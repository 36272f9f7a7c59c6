r"""A problem while terms are being put into it.

Terms ask an :class:`Assembly` for rows by name and limit or weigh them; rows nobody asked for are
not evaluated. Costs are integrals over time, so a weight means the same on every mesh: at nodes
they are weighed with the trapezoidal rule.
"""

from collections.abc import Callable, Mapping

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.errors import ParameterError
from plantigrade.synthesize.problem import formulation
from plantigrade.synthesize.problem.formulation import Body
from plantigrade.synthesize.problem.nlp import ConstraintFamily, PeriodicClosure, Problem
from plantigrade.synthesize.splines.basis import Basis

_BUILDERS: Mapping[str, Callable[["Assembly"], ConstraintFamily]] = {
    "dynamics": lambda a: formulation.dynamics_rows(a.body, len(a.nodes)),
    "contact": lambda a: formulation.place_rows(a.body, a.headings, rates=False),
    "contact speed": lambda a: formulation.place_rows(a.body, a.headings, rates=True),
    "coordinates": lambda a: formulation.motion_rows(a.body, len(a.nodes), "coordinates"),
    "speeds": lambda a: formulation.motion_rows(a.body, len(a.nodes), "speeds"),
    "accelerations": lambda a: formulation.motion_rows(a.body, len(a.nodes), "accelerations"),
}


class Assembly:
    """What a task makes a problem of.

    Raises:
        ParameterError: If the body was made for ground of another slope, or lacks a place that the
            plan rests on.

    Attributes:
        body: The person.
        plan: Contacts.
        nodes: Times of the nodes [s].
        weights: What a node stands for in an integral over time [s].
        headings: Heading of each site's footprint at each node [rad].
        u_lower: Lower limits of contact forces (n_nodes, 3 n_sites) [body weights]; zero where a
            site does not carry.
        u_upper: Upper limits.
        u_smooth: Weights of their steps.
        jerk: Weights of squared jerk of coordinates.
    """

    def __init__(self, body: Body, plan: ContactPlan, nodes: Float[Array, " n_nodes"]):
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
        self.headings = formulation.headings(body, plan, nodes)
        n_u = 3 * len(body.sites)
        self.u_lower = np.zeros((len(nodes), n_u))
        self.u_upper = np.zeros((len(nodes), n_u))
        self.u_smooth = np.zeros((len(step), n_u))
        self.jerk = np.zeros(body.symbolic.nv)
        self._rows: dict[str, ConstraintFamily] = {}

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the coordinates."""
        return self.body.symbolic.names

    def rows(self, name: str) -> ConstraintFamily:
        """Return rows by name, made where nobody asked for them before.

        Args:
            name: ``"dynamics"``, ``"contact"``, ``"contact speed"``, ``"coordinates"``,
                ``"speeds"``, ``"accelerations"``, or the name of rows a term has added.

        Raises:
            ParameterError: If there are no such rows.
        """
        if name not in self._rows:
            if name not in _BUILDERS:
                raise ParameterError(
                    f"no rows {name!r}; there are {', '.join({*_BUILDERS, *self._rows})}"
                )
            self._rows[name] = _BUILDERS[name](self)
        return self._rows[name]

    def add(self, rows: ConstraintFamily) -> ConstraintFamily:
        """Add rows of one's own, or return those of the same name that were added before."""
        return self._rows.setdefault(rows.name, rows)

    def column(self, coordinate: str) -> int:
        """Return the index of a coordinate.

        Raises:
            ParameterError: If there is no such coordinate.
        """
        if coordinate not in self.names:
            raise ParameterError(f"no coordinate {coordinate!r}; there are {', '.join(self.names)}")
        return self.names.index(coordinate)

    def pull(
        self,
        rows: ConstraintFamily,
        weight: Float[Array, "n_nodes n_rows"],
        target: Float[Array, "n_nodes n_rows"] | float = 0.0,
    ) -> None:
        r"""Add :math:`\tfrac12 w (r - \bar r)^2` to what rows cost.

        Args:
            rows: The rows.
            weight: Weight :math:`w`, multiplied with the time each node stands for here.
            target: Target :math:`\bar r`.
        """
        w = np.broadcast_to(weight, rows.weight.shape) * self.weights[:, None]
        both = rows.weight + w
        safe = np.where(both > 0, both, 1.0)
        rows.target[:] = np.where(
            w > 0, (rows.weight * rows.target + w * np.asarray(target)) / safe, rows.target
        )
        rows.weight[:] = both

    def limit(
        self,
        rows: ConstraintFamily,
        lower: Float[Array, "..."] | float = -np.inf,
        upper: Float[Array, "..."] | float = np.inf,
        *,
        columns: "slice | list[int]" = slice(None),
        nodes: "slice | list[int]" = slice(None),
    ) -> None:
        """Narrow the limits of rows; equations stay as they are."""
        grid = np.ix_(np.arange(len(self.nodes))[nodes], np.arange(rows.lower.shape[1])[columns])
        low, high = rows.lower[grid], rows.upper[grid]
        fixed = low == high
        rows.lower[grid] = np.where(fixed, low, np.maximum(low, lower))
        rows.upper[grid] = np.where(fixed, high, np.minimum(high, upper))

    def problem(self, basis: Basis, closure: PeriodicClosure | None = None) -> Problem:
        """Return the problem; rows without limits and costs are left out."""
        used = tuple(
            r
            for r in self._rows.values()
            if np.isfinite(r.lower).any()
            or np.isfinite(r.upper).any()
            or r.weight.any()
            or r.gain.any()
        )
        return Problem(
            basis,
            self.nodes,
            self.names,
            used,
            self.body.force_names,
            self.u_lower,
            self.u_upper,
            self.u_smooth,
            closure,
            self.jerk if self.jerk.any() else np.zeros(0),
        )


def _check(body: Body, plan: ContactPlan) -> None:
    """Refuse a body that was made for another plan."""
    g = body.symbolic.gravity
    leaning = plan.to_world.T @ np.array([0.0, 0.0, -np.linalg.norm(g)])
    if not np.allclose(g, leaning, atol=1e-6):
        raise ParameterError(
            f"the ground rises by {plan.slope:g} rad and the body was made for another slope: use "
            "body_for(human, task.plan)"
        )
    names = {site.name for site in body.sites}
    missing = [s.site.name for s in plan.supports if s.site.name not in names]
    if missing:
        raise ParameterError(
            f"the plan rests on {missing[0]!r}, which the body has no place for: use "
            "body_for(human, task.plan)"
        )

"""One family of constraints at the nodes where it matters: values, derivatives, violation, cost."""

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily, node_symbols
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.transcription.derivatives import derivatives_of

if TYPE_CHECKING:
    import casadi

EVERY = slice(None)


class ConstraintBlock:
    """A family at the nodes where it has a limit or a cost; its arrays are those of these nodes.

    Attributes:
        rows: The family.
        at: Nodes where it matters, in order.
        everywhere: Whether that is all of them.
        bound: Which rows are equations or inequalities.
        equation_rows: From the first row that is an equation at some node to the last.
        linear: Whether the family is linear in z.
        single: Whether, beyond that, each row depends on one element of z only.
        columns: The elements of z that it depends on.
        r: Values at the point that was linearised last.
        whole_jacobian: Jacobian there, by z.
        J: The part of it in ``columns``.
    """

    def __init__(self, rows: ConstraintFamily, n_local: int):
        self.rows = rows
        self.derivatives = derivatives_of(rows.function)
        eq, ineq = rows.equations, rows.inequalities
        self.at = np.flatnonzero(rows.matters.any(axis=1))
        self.everywhere = len(self.at) == len(eq)
        self.parameters = rows.parameters[self.at]
        self.lower, self.upper = rows.lower[self.at], rows.upper[self.at]
        self.weight, self._target = rows.weight[self.at], rows.target[self.at]
        self._gain = rows.gain[self.at]
        self.equations, self.inequalities = eq[self.at], ineq[self.at]
        self.bound = self.equations | self.inequalities
        own = np.flatnonzero(self.equations.any(axis=0))
        self.equation_rows = slice(int(own[0]), int(own[-1]) + 1) if len(own) else slice(0)
        self._costs = bool(np.any(self.weight) or np.any(self._gain))
        jr, jc = self.derivatives.jacobian_pattern
        self.linear = len(self.derivatives.hessian_pattern[0]) == 0
        per_row = np.bincount(jr, minlength=len(rows.names)) if len(jr) else np.zeros(1)
        self.single = self.linear and per_row.max() <= 1
        columns = np.unique(jc) if len(jc) else np.zeros(1, int)
        self.columns = slice(int(columns[0]), int(columns[-1]) + 1)  # a slice is worth its zeros
        self.r = np.zeros(self.lower.shape)
        self.whole_jacobian = np.zeros((*self.lower.shape, n_local))
        self.J = self.whole_jacobian[:, :, self.columns]
        self._known = False  # of a linear family, whether J is
        self._only = np.zeros(self.lower.shape, int), np.zeros(self.lower.shape)

    def pick(self, z: Array) -> Array:
        """Return what belongs to the nodes that matter."""
        return z if self.everywhere else z[self.at]

    def linearise(self, q: Array, v: Array, a: Array, u: Array) -> None:
        """Evaluate values and Jacobian at states of the nodes that matter."""
        if self.linear and self._known:
            self.r = self.derivatives.values(q, v, a, u, self.parameters)
            return
        self.r, _ = self.derivatives.jacobian(q, v, a, u, self.parameters, out=self.whole_jacobian)
        self._known = True
        if self.single:
            column = np.abs(self.J).argmax(axis=2)
            self._only = column, np.take_along_axis(self.J, column[..., None], 2)[..., 0]

    def add_pulled(self, g: Array, w: Array, rows: slice = EVERY) -> None:
        """Add J' w to the gradients of all nodes by z; J and w of some rows only."""
        if self.single:
            column, value = self._only[0][:, rows], self._only[1][:, rows]
            np.add.at(g, (self.at[:, None], self.columns.start + column), w[:, rows] * value)
            return
        nodes = EVERY if self.everywhere else self.at
        g[nodes, self.columns] += np.matmul(w[:, None, rows], self.J[:, rows])[:, 0]

    def pushed(self, dz: Array, rows: slice = EVERY) -> Array:
        """Return J dz of changes of z at all nodes, zero for all but some rows."""
        near = self.pick(dz)[:, self.columns]
        out = np.zeros(self.lower.shape)
        if self.single:
            column, value = self._only[0][:, rows], self._only[1][:, rows]
            out[:, rows] = value * np.take_along_axis(near, column, axis=1)
        else:
            out[:, rows] = np.matmul(self.J[:, rows], near[:, :, None])[:, :, 0]
        return out

    def add_squares(self, H: Array, at: Array, rows: slice, w: Array) -> None:
        """Add J' diag(w) J of some of the nodes to H, at the places ``at`` of its first axis.

        Weights are zero or more: the root of them makes it a product with itself, half the work.
        """
        if self.single:
            columns, values = self._only
            column = self.columns.start + columns[rows]
            np.add.at(H, (at[:, None], column, column), w * values[rows] ** 2)
            return
        used = np.flatnonzero(w.any(axis=0))
        if not len(used):
            return
        J = self.J[rows][:, used]  # a copy
        J *= np.sqrt(w[:, used, None])
        block = np.matmul(J.transpose(0, 2, 1), J)
        H[EVERY if len(at) == len(H) else at, self.columns, self.columns] += block

    def cost(self, r: Array) -> float:
        """Return the cost of values."""
        if not self._costs:
            return 0.0
        away = r - self._target
        return float(np.sum(self._gain * r) + 0.5 * np.sum(self.weight * away * away))

    def cost_gradient(self, r: Array) -> Array:
        """Return the derivative of the cost by the values."""
        return self._gain + self.weight * (r - self._target)

    def violation(self, r: Array) -> Array:
        """Return how far values lie outside their limits; infinitely far if they are not finite."""
        off = np.maximum(np.maximum(self.lower - r, r - self.upper), 0.0)
        return np.where(np.isnan(r), np.inf, off)


def limits_of_unknowns(problem: Problem) -> ConstraintFamily | None:
    """Return the limits of node unknowns as a family."""
    if not problem.n_unknowns:
        return None
    nv, n = len(problem.names), len(problem.nodes)
    function = _unknowns(nv, problem.n_unknowns)
    rows = ConstraintFamily.free("limits of unknowns", function, problem.u_names, n)
    active = problem.u_active
    rows.lower[active] = problem.u_lower[active]
    rows.upper[active] = problem.u_upper[active]
    return rows


@cache
def _unknowns(nv: int, nu: int) -> "casadi.Function":
    """Return the function of a node that is its unknowns."""
    import casadi as ca

    given = list(node_symbols(nv, nu))
    return ca.Function("unknowns", given, given[3:4])

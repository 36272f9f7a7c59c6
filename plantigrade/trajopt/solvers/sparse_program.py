r"""A trajectory problem as one sparse nonlinear program, for solvers that come with CasADi.

.. math:: \min_x f(x) \quad \text{with} \quad l \le g(x) \le h, \; x_l \le x \le x_h

Everything is evaluated by the same vectorised derivatives as in the banded interior point
(:mod:`~plantigrade.trajopt.transcription.evaluation`); here are only the patterns of the sparse
matrices, and which rows a solver is given: equations that follow from others are left out, and
variables that an equation fixes by itself have equal bounds instead. Omitted rows still count in
:meth:`SparseProgram.worst`.

**Rows that follow from others.** A rigid sole that stands on four points has twelve equations of
position and six degrees of freedom. Solvers that factorise equations want independent ones, so at
every node those that follow from the others are left out. The rank is that of their Jacobian by
:math:`z_k`, at states moved a little at random, so that no symmetric posture hides or feigns a
dependence. Linear equations are kept before others.
"""

from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import qr

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.transcription.constraint_block import ConstraintBlock
from plantigrade.trajopt.transcription.evaluation import Evaluation, WorstRow

_PERTURBATION = 0.1  # how far from the guess ranks are determined [rad, m, rad/s, m/s, …]
_ORDER_PREFERENCE = 1e-6  # by how much an earlier row is preferred to a later one
_RANK_TOLERANCE = 1e-7  # parts of a row smaller than this are rounding


class SparseProgram:
    """A :class:`Problem` as variables, objective and constraints.

    Attributes:
        problem: The problem.
        n_variables: Number of variables.
        n_fixed: Variables that an equation fixes by itself, as those of a first pose are.
        n_equations: Equations kept, besides those.
        n_redundant: Equations left out because they follow from others.
        lower, upper: Limits of the constraints.
        bounds: Lower and upper bounds of the variables.
        jacobian_pattern: Rows and columns of the Jacobian of the constraints, column by column.
        hessian_pattern: Rows and columns of the upper triangle of the Hessian, column by column.

    Raises:
        ParameterError: If the guess does not fit the problem.
    """

    def __init__(
        self,
        problem: Problem,
        c0: Float[Array, "n_coefficients n_coordinates"],
        u0: Float[Array, "n_nodes n_unknowns"] | None = None,
    ):
        self.problem = problem
        self._e = Evaluation(problem)
        self._values_at = self._linearised_at = np.zeros(0)
        variables = self._e.t.variables
        self.pack, self.unpack, self.n_variables = variables.start, variables.split, variables.size
        blocks = self._e.blocks
        kept = independent_equations(self._e, self.pack(c0, u0))
        self.n_redundant = sum(
            int(b.equations.sum() - mine.sum()) for b, mine in zip(blocks, kept, strict=True)
        )
        fixed = fixed_variables(self._e, kept)
        self.n_fixed = len(fixed)
        self._limited = [b.inequalities | mine for b, mine in zip(blocks, kept, strict=True)]
        self.lower = self._chosen([b.lower for b in blocks])
        self.upper = self._chosen([b.upper for b in blocks])
        self.n_equations = int(np.sum(self.lower == self.upper))
        self.bounds = np.full(self.n_variables, -np.inf), np.full(self.n_variables, np.inf)
        free = variables.free
        self.bounds[0][variables.u_at[free]] = problem.u_lower.reshape(free.shape)[free]
        self.bounds[1][variables.u_at[free]] = problem.u_upper.reshape(free.shape)[free]
        for i, value in fixed.items():
            self.bounds[0][i] = self.bounds[1][i] = value
        self._moving = np.ones(self.n_variables, dtype=bool)
        self._moving[list(fixed)] = False
        rng = np.random.default_rng(0)  # entries that are zero for random matrices always are
        self._find_jacobian_pattern(rng)
        self._find_hessian_pattern(rng)

    def objective(self, x: Float[Array, " n_variables"]) -> float:
        """Return the cost."""
        return self._e.objective(x, self._rows(x))

    def constraints(self, x: Float[Array, " n_variables"]) -> Float[Array, " n_constraints"]:
        """Return the constraints."""
        return self._chosen(self._rows(x))

    def worst(self, x: Float[Array, " n_variables"]) -> WorstRow:
        """Return the row of the problem that is violated most, redundant ones included."""
        return self._e.worst(self._rows(x))

    def excess(self, g: Float[Array, " n_constraints"]) -> Float[Array, " n_constraints"]:
        """Return how far constraints lie above their upper limits, or below their lower ones."""
        return np.maximum(g - self.upper, 0.0) - np.maximum(self.lower - g, 0.0)

    def gradient(self, x: Float[Array, " n_variables"]) -> Float[Array, " n_variables"]:
        """Return the gradient of the cost."""
        self._linearise(x)
        return self._e.objective_gradient(x)

    def jacobian(self, x: Float[Array, " n_variables"]) -> Float[Array, " nnz"]:
        """Return the entries of the Jacobian of the constraints, in the order of its pattern."""
        self._linearise(x)
        found = [
            self._e.t.jacobian(b.at, b.whole_jacobian)[0].ravel()[taken]
            for b, taken in zip(self._e.blocks, self._taken, strict=True)
        ]
        entries = np.concatenate(found) if found else np.zeros(0)
        n = len(self.jacobian_pattern[0])
        return np.bincount(self._jacobian_places, weights=entries, minlength=n)

    def sparse_jacobian(self, x: Float[Array, " n_variables"]) -> Any:
        """Return the Jacobian of the constraints as a sparse matrix."""
        shape = len(self.lower), self.n_variables
        return sparse.csr_matrix((self.jacobian(x), self.jacobian_pattern), shape=shape)

    def hessian(
        self,
        x: Float[Array, " n_variables"],
        cost: float,
        multipliers: Float[Array, " n_constraints"],
    ) -> Float[Array, " nnz"]:
        """Return the entries of the Hessian of cost f + multipliers' g, in its pattern's order."""
        self._linearise(x)
        e, start, pushes = self._e, 0, []
        for b, limited in zip(e.blocks, self._limited, strict=True):
            stop = start + int(limited.sum())
            y = np.zeros(limited.shape)
            y[limited] = multipliers[start:stop]
            pushes.append(y + cost * b.cost_gradient(b.r))
            start = stop
        weights = [cost * b.weight for b in e.blocks]
        band = e.t.assemble(e.hessians(x, weights, pushes), smooth=cost)
        return band[self._hessian_places]

    def _rows(self, x: Array) -> list[Array]:
        """Return the rows of every block, evaluated once at each point."""
        if not np.array_equal(x, self._values_at):
            self._kept_rows, self._values_at = self._e.values(x), x.copy()
        return self._kept_rows

    def _linearise(self, x: Array) -> None:
        """Evaluate rows and Jacobians, once at each point."""
        if not np.array_equal(x, self._linearised_at):
            self._e.linearise(x)
            self._linearised_at = x.copy()

    def _chosen(self, arrays: list[Array]) -> Float[Array, " n_constraints"]:
        """Return the entries of arrays of all blocks that are constraints."""
        found = [each[mine] for each, mine in zip(arrays, self._limited, strict=True)]
        return np.concatenate(found) if found else np.zeros(0)

    def _find_jacobian_pattern(self, rng: np.random.Generator) -> None:
        rows, columns, start = [np.zeros(0, int)], [np.zeros(0, int)], 0
        self._taken: list[Int[Array, " _"]] = []
        for b, limited in zip(self._e.blocks, self._limited, strict=True):
            number = np.zeros(limited.shape, int)
            number[limited] = np.arange(start, start + int(limited.sum()))
            start += int(limited.sum())
            J = rng.uniform(1.0, 2.0, b.whole_jacobian.shape) * _pattern(b)
            entries, column = self._e.t.jacobian(b.at, J)
            moves = (column >= 0) & self._moving[column]
            used = (entries != 0) & limited[:, :, None] & moves[:, None, :]
            self._taken.append(np.flatnonzero(used))
            rows.append(np.broadcast_to(number[:, :, None], used.shape)[used])
            columns.append(np.broadcast_to(column[:, None, :], used.shape)[used])
        high = max(len(self.lower), 1)
        keys = np.concatenate(columns) * high + np.concatenate(rows)
        found, self._jacobian_places = np.unique(keys, return_inverse=True)
        self.jacobian_pattern = found % high, found // high

    def _find_hessian_pattern(self, rng: np.random.Generator) -> None:
        t = self._e.t
        there = np.zeros((t.n_nodes, t.n_local, t.n_local), dtype=bool)
        for b in self._e.blocks:
            if not b.linear:
                i, j = b.derivatives.hessian_pattern
                there[b.at[:, None], i, j] = True
            weighed = (_pattern(b) * (b.weight != 0)[:, :, None]).astype(float)
            there[b.at] |= np.matmul(weighed.transpose(0, 2, 1), weighed) > 0
        half = rng.uniform(1.0, 2.0, (t.n_local, t.n_local))
        H = there * (half + half.T)
        band = t.assemble([(slice(0, t.n_nodes), H)])
        below, j = np.nonzero(band)
        i = below + j
        order = np.lexsort((j, i))
        order = order[self._moving[i[order]] & self._moving[j[order]]]
        self._hessian_places = below[order], j[order]
        self.hessian_pattern = j[order], i[order]


def _pattern(b: ConstraintBlock) -> Array:
    """Return where the Jacobian by z of a block can be other than zero (n_rows, n_local)."""
    found = np.zeros(b.whole_jacobian.shape[1:], dtype=bool)
    found[b.derivatives.jacobian_pattern] = True
    return found


def independent_equations(e: Evaluation, x: Float[Array, " size"]) -> list[Bool[Array, "_ _"]]:
    """Return for every block which of its equations are independent of those before, near x."""
    p, z = e.problem, e.t.local(x)
    z = z + _PERTURBATION * np.random.default_rng(0).standard_normal(z.shape)
    held = np.ones(z.shape, dtype=bool)  # parts of z that move with x
    held[:, 3 * e.t.nv :] = p.u_active if p.n_unknowns else True
    kept = [np.zeros(b.equations.shape, dtype=bool) for b in e.blocks]
    order = [i for i, b in enumerate(e.blocks) if b.equations.any()]
    order.sort(key=lambda i: not e.blocks[i].linear)
    jacobians = {}
    for i in order:
        b = e.blocks[i]
        jacobians[i] = b.derivatives.jacobian(*e.states(z[b.at]), b.parameters)[1]
    for k in range(len(z)):
        space = np.zeros((z.shape[1], 0))  # orthonormal, spanned by the equations kept
        for i in order:
            b = e.blocks[i]
            place = np.searchsorted(b.at, k)
            if place == len(b.at) or b.at[place] != k or not b.equations[place].any():
                continue
            rows = np.flatnonzero(b.equations[place])
            J = jacobians[i][place][rows] * held[k]
            J = J / np.maximum(np.linalg.norm(J, axis=1), 1e-300)[:, None]
            J *= 1.0 - _ORDER_PREFERENCE * np.arange(len(J))[:, None]
            rest = J.T - space @ (space.T @ J.T)
            rest -= space @ (space.T @ rest)
            found: Any = qr(rest, mode="economic", pivoting=True)
            Q, R, pivots = found
            rank = int(np.sum(np.abs(np.diag(R)) > _RANK_TOLERANCE)) if R.size else 0
            kept[i][place, rows[pivots[:rank]]] = True
            space = np.hstack([space, Q[:, :rank]])
    return kept


def fixed_variables(e: Evaluation, kept: list[Bool[Array, "_ _"]]) -> dict[int, float]:
    """Return variables that linear equations fix one after the other; drop these from ``kept``."""
    waiting = []
    z, T, n = e.t.local(np.zeros(e.t.size)), e.t.matrix(), e.t.n_local
    for b, mine in zip(e.blocks, kept, strict=True):
        if not (b.linear and mine.any()):
            continue
        value, J = b.derivatives.jacobian(*e.states(z[b.at]), b.parameters)
        for place in np.flatnonzero(mine.any(axis=1)):
            k, rows = b.at[place], np.flatnonzero(mine[place])
            A = sparse.csr_matrix(J[place][rows]) @ T[k * n : (k + 1) * n]
            for j, i in enumerate(rows):
                part = slice(A.indptr[j], A.indptr[j + 1])
                columns, entries = A.indices[part], A.data[part]
                large = np.abs(entries) > _RANK_TOLERANCE * np.abs(entries).max(initial=0.0)
                terms = dict(zip(columns[large].tolist(), entries[large].tolist(), strict=True))
                waiting.append((mine, place, i, terms, b.lower[place, i] - value[place, i]))
    fixed: dict[int, float] = {}
    found = True
    while found:
        found, later = False, []
        for equation in waiting:
            mine, place, i, terms, right = equation
            open_ = [c for c in terms if c not in fixed]
            if len(open_) != 1:
                later.append(equation)
                continue
            known = sum(terms[c] * fixed[c] for c in terms if c in fixed)
            fixed[open_[0]] = float((right - known) / terms[open_[0]])
            mine[place, i] = False
            found = True
        waiting = later
    return fixed

r"""Optimisation variables as one vector :math:`x`: spline coefficients and free node unknowns.

The order keeps together what meets at a node, so that the Hessian is a narrow band; a periodic
motion is folded, so that its two ends lie side by side.
"""

from typing import Any

import numpy as np
from scipy import sparse

from plantigrade.arrays import Array, Float, Int
from plantigrade.errors import ParameterError
from plantigrade.trajopt.problem.nlp import Problem


class Variables:
    """The variables of one problem, and where each of them lies in the vector.

    Attributes:
        size: Number of variables.
        reach: How far apart two variables that meet at a node lie at most.
        c_at: Place of every coefficient (n_coefficients, n_coordinates).
        u_at: Place of every node unknown (n_nodes, n_unknowns); -1 where it is fixed.
        free: Which of them are not.
    """

    def __init__(self, problem: Problem, window: Int[Array, "n_nodes w"]):
        self.problem = problem
        self._order(window)
        self.free = self.u_at >= 0

    def join(
        self, c: Float[Array, "n_coefficients nv"], u: Float[Array, "n_nodes nu"]
    ) -> Float[Array, " size"]:
        """Return the vector of coefficients and node unknowns."""
        x = np.empty(self.size)
        x[self.c_at] = c
        x[self.u_at[self.free]] = u[self.free]
        return x

    def split(
        self, x: Float[Array, " size"]
    ) -> tuple[Float[Array, "n_coefficients nv"], Float[Array, "n_nodes nu"]]:
        """Return coefficients and node unknowns; the fixed ones have their value."""
        u = np.array(self.problem.u_lower, dtype=float).reshape(self.u_at.shape)
        u[self.free] = x[self.u_at[self.free]]
        return x[self.c_at], u

    def start(self, c: Array, u: Array | None = None) -> Float[Array, " size"]:
        """Return the vector of an initial guess; unknowns are zero if there are none given."""
        u = np.zeros(self.u_at.shape) if u is None else u
        for what, given, expected in (
            ("coefficients", c, self.c_at),
            ("node unknowns", u, self.u_at),
        ):
            if given.shape != expected.shape:
                raise ParameterError(
                    f"the guess has {what} {given.shape}; this problem has {expected.shape}"
                )
            if not np.isfinite(given).all():
                raise ParameterError(f"the guess has {what} that are not finite")
        return self.join(c, u)

    def _order(self, window: Array) -> None:
        """Place blocks of variables in an order that keeps the band narrow."""
        p, n, nv = self.problem, len(self.problem.nodes), len(self.problem.names)
        n_c, nu = p.basis.n_coefficients, p.n_unknowns
        active = p.u_active if nu else np.zeros((n, 0), dtype=bool)
        blocks: list[tuple[float, int, int]] = [(float(i), 0, i) for i in range(n_c)]
        blocks += [(float(window[k, 0]) + 1.5, 1, k) for k in range(n)]
        if p.closure is not None:  # fold: what lies near either end lies near the beginning
            blocks = [(min(at, n_c - at), kind, i) for at, kind, i in blocks]
        blocks.sort()
        self.c_at, self.u_at = np.zeros((n_c, nv), int), np.full((n, nu), -1)
        self.size = 0
        for _, kind, i in blocks:
            places, moves = (self.u_at[i], active[i]) if kind else (self.c_at[i], slice(None))
            many = len(places[moves])
            places[moves] = self.size + np.arange(many)
            self.size += many
        self.reach = 0
        for k in range(n):
            touched = np.append(self.c_at[window[k] % n_c], self.u_at[k, active[k]])
            self.reach = max(self.reach, int(touched.max() - touched.min()))


class Smoothness:
    r"""Quadratic cost of steps of node unknowns and of the jerk of coordinates.

    .. math:: s(x) = \tfrac12 \sum_k \sigma_k \lVert u_{k+1} - u_k \rVert^2
        + \tfrac12 \lVert D\, c \rVert^2 = \tfrac12 x^\top Q x + l^\top x + s_0,

    with :math:`D` of :meth:`~plantigrade.trajopt.problem.nlp.Problem.roughness`.

    Attributes:
        quadratic: :math:`Q`, sparse and symmetric.
    """

    def __init__(self, variables: Variables):
        p, n_c = variables.problem, variables.c_at.size
        D = sparse.block_diag([p.roughness(), _steps(p)], format="csr")
        at = np.concatenate([variables.c_at.ravel(), variables.u_at.ravel()])
        free = np.flatnonzero(at >= 0)
        put = sparse.csr_matrix(
            (np.ones(len(free)), (free, at[free])), shape=(len(at), variables.size)
        )
        fixed = np.concatenate([np.zeros(n_c), p.u_lower.ravel()])
        fixed[free] = 0.0
        moved, still = sparse.csr_matrix(D @ put), D @ fixed
        self.quadratic: Any = sparse.csr_matrix(moved.T @ moved)
        self._linear, self._constant = moved.T @ still, 0.5 * float(still @ still)

    def __call__(self, x: Float[Array, " size"]) -> tuple[float, Float[Array, " size"]]:
        """Return the cost and its gradient."""
        pull = self.quadratic @ x
        return float(x @ (0.5 * pull + self._linear)) + self._constant, pull + self._linear


def _steps(p: Problem) -> Any:
    """Return the matrix from node unknowns to their weighted steps."""
    n, nu = len(p.nodes), p.n_unknowns
    weights = p.u_smooth if p.u_smooth.size else np.zeros((0, nu))
    here = np.arange(n * nu).reshape(n, nu)
    after, sign = here[1:], np.ones((n - 1, nu))
    if p.closure is not None:
        after = np.vstack([after, here[:1, p.closure.u_source]])
        sign = np.vstack([sign, p.closure.u_sign])
    after, sign = after[: len(weights)].ravel(), sign[: len(weights)].ravel()
    root = np.sqrt(weights.ravel())
    rows = np.tile(np.arange(len(root)), 2)
    entries = np.concatenate([-root, root * sign])
    columns = np.concatenate([here[: len(weights)].ravel(), after])
    return sparse.csr_matrix((entries, (rows, columns)), shape=(len(root), n * nu))

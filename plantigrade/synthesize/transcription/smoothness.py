r"""What the steps of node unknowns and the jerk of coordinates cost: a quadratic form.

.. math:: s(x) = \tfrac12 \sum_k \sigma_k \lVert u_{k+1} - u_k \rVert^2
    + \tfrac12 \lVert D\, c \rVert^2 = \tfrac12 x^\top Q x + l^\top x + s_0,

with :math:`D` of :meth:`~plantigrade.synthesize.problem.nlp.Problem.roughness`.
"""

from typing import Any

import numpy as np
from scipy import sparse

from plantigrade.arrays import Array, Float
from plantigrade.synthesize.problem.nlp import Problem
from plantigrade.synthesize.transcription.variables import Variables


class Smoothness:
    """The quadratic form of one problem.

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

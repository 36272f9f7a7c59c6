r"""Sparse convex quadratic programs, solved by PIQP's interior point ([Schwan2023]_, in CasADi).

.. math:: \min_x\; \tfrac12 x^T P x + q^T x \quad\text{with}\quad G x \le h .
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import SolverError

OPTIONS = {"eps_abs": 1e-7, "eps_rel": 1e-8, "max_iter": 100}


@dataclass(frozen=True)
class QuadraticSolution:
    """Optimum of a quadratic program."""

    x: Float[Array, " n"]  #: Unknowns
    multiplier: Float[Array, " m"]  #: Of each inequality, not negative
    slack: Float[Array, " m"]  #: What is left of each inequality, not negative


def solve_quadratic(
    P: Any, q: Float[Array, " n"], G: Any, h: Float[Array, " m"], *, solver: str = "piqp"
) -> QuadraticSolution:
    """Return the optimum of a convex quadratic program with inequalities.

    Args:
        P: Symmetric, positive definite; SciPy sparse, (n, n).
        q: Linear part.
        G: Inequalities; SciPy sparse, (m, n).
        h: Their upper limits.
        solver: CasADi's name of the solver.

    Raises:
        SolverError: If there is none, or none was found.
    """
    import casadi as ca

    unknowns = np.sqrt(np.asarray(P.diagonal()))
    unknowns = 1.0 / np.where(unknowns > 0, unknowns, 1.0)
    hessian = _casadi(P.multiply(unknowns[:, None]).multiply(unknowns[None]))
    limits = _casadi(G.multiply(unknowns[None]))
    shape = {"h": hessian.sparsity(), "a": limits.sparsity()}
    options: dict[str, Any] = {"error_on_fail": False}
    if solver == "piqp":
        options["piqp"] = OPTIONS
    run = ca.conic("ground_forces", solver, shape, options)
    result = run(h=hessian, g=unknowns * q, a=limits, lba=-np.inf, uba=h)
    if not run.stats()["success"]:
        raise SolverError(
            f"the quadratic program of {len(q)} unknowns and {len(h)} inequalities was not solved "
            f"({run.stats().get('unified_return_status', 'no reason given')})"
        )
    x = unknowns * np.asarray(result["x"]).ravel()
    multiplier = np.maximum(np.asarray(result["lam_a"]).ravel(), 0.0)
    return QuadraticSolution(x, multiplier, np.maximum(h - G @ x, 0.0))


def _casadi(matrix: Any) -> Any:
    """Return a SciPy sparse matrix as CasADi's."""
    import casadi as ca

    m = matrix.tocsc()
    m.sort_indices()
    rows, columns = m.shape
    pattern = ca.Sparsity(rows, columns, m.indptr.tolist(), m.indices.tolist())
    return ca.DM(pattern, m.data)

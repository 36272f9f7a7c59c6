r"""Equations that follow from others, and variables that an equation fixes by itself.

A rigid sole that stands on four points has twelve equations of position and six degrees of freedom.
Solvers that factorise equations want independent ones, so at every node those that follow from the
others are left out. The rank is that of their Jacobian by :math:`z_k`, at states moved a little at
random, so that no symmetric posture hides or feigns a dependence. Linear equations are kept before
others.
"""

from typing import Any

import numpy as np
from scipy import sparse
from scipy.linalg import qr

from plantigrade.arrays import Array, Bool, Float
from plantigrade.trajopt.transcription.evaluation import Evaluation

_PERTURBATION = 0.1  # how far from the guess ranks are determined [rad, m, rad/s, m/s, …]
_ORDER_PREFERENCE = 1e-6  # by how much an earlier row is preferred to a later one
_RANK_TOLERANCE = 1e-7  # parts of a row smaller than this are rounding


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

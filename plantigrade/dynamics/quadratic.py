r"""Convex quadratic programs over time, banded with a few global unknowns.

.. math:: \min_x\; \tfrac12 x^T P x + q^T x \quad\text{with}\quad G x \le h,

by the predictor-corrector interior point of [Mehrotra1992]_. Unknowns are ordered by time, so that
:math:`P + G^T D G` is a band with a border of the few unknowns that come last; each step costs one
Cholesky factor of the band.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg import cho_factor, cho_solve, cho_solve_banded, cholesky_banded

from plantigrade.arrays import Array, Float
from plantigrade.errors import SolverError

TOLERANCE = 1e-5  # [1] tolerance of residuals and duality gap, in scaled units
MAX_STEPS = 80  # [1] maximum number of steps
MIN_WARM_SLACK = 1e-3  # [1] minimum slack and multiplier of a warm start
DIAGONAL_SHIFT = 1e-9  # [1] shift of the scaled diagonal, for positive definiteness


class BorderedBand:
    """Factor of a symmetric positive definite matrix: a band with a dense border.

    Args:
        rows: Row of each entry of the lower triangle; duplicate entries are added.
        border: Number of dense rows at the end.
    """

    def __init__(self, rows: np.ndarray, columns: np.ndarray, size: int, border: int):
        self.inner, self.border = size - border, border
        self.band = rows < self.inner
        self.width = int((rows - columns)[self.band].max(initial=0))
        self.place = (rows - columns)[self.band] * self.inner + columns[self.band]
        self.edge = (rows - self.inner)[~self.band] * size + columns[~self.band]

    def factor(self, values: Float[Array, " n_entries"]) -> None:
        """Factor the matrix with these entries.

        Raises:
            LinAlgError: If the matrix is not positive definite.
        """
        n, b = self.inner, self.border
        cells = (self.width + 1) * n
        band = np.bincount(self.place, values[self.band], cells).reshape(self.width + 1, n)
        edge = np.bincount(self.edge, values[~self.band], b * (n + b)).reshape(b, n + b)
        band[0] += DIAGONAL_SHIFT
        self.lower = cholesky_banded(band, lower=True, overwrite_ab=True, check_finite=False)
        self.across = edge[:, :n]
        self.reach = cho_solve_banded((self.lower, True), self.across.T, check_finite=False)
        corner = np.tril(edge[:, n:])
        corner = corner + np.tril(corner, -1).T - self.across @ self.reach
        self.corner = cho_factor(corner + DIAGONAL_SHIFT * np.eye(b), lower=True) if b else None

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Return the solution for a right-hand side (n,) or several (n, m)."""
        n = self.inner
        inner = cho_solve_banded((self.lower, True), right[:n], check_finite=False)
        if self.corner is None:
            return inner
        last = cho_solve(self.corner, right[n:] - self.across @ inner)
        return np.concatenate([inner - self.reach @ last, last])


@dataclass(frozen=True)
class QuadraticSolution:
    """Optimum of a quadratic program."""

    x: Float[Array, " n"]  #: Unknowns
    multiplier: Float[Array, " m"]  #: Multiplier of each inequality, positive
    slack: Float[Array, " m"]  #: Slack of each inequality, positive
    steps: int  #: Number of steps
    _factor: BorderedBand
    _scale: np.ndarray

    def response(self, right: Float[Array, "n k"]) -> Float[Array, "n k"]:
        r"""Return :math:`(P + G^T \tfrac{z}{s} G)^{-1}` times vectors.

        This is the derivative of the optimum by :math:`-q` with constant active inequalities.
        """
        return self._scale[:, None] * self._factor.solve(self._scale[:, None] * right)


def solve_quadratic(
    P: Any,
    q: Float[Array, " n"],
    G: Any,
    h: Float[Array, " m"],
    *,
    border: int = 0,
    start: QuadraticSolution | None = None,
) -> QuadraticSolution:
    """Return the optimum of a convex quadratic program with inequalities.

    Args:
        P: Symmetric, positive definite; SciPy sparse, (n, n).
        q: Linear term.
        G: Inequalities; SciPy sparse, (m, n).
        h: Upper limits of the inequalities.
        border: Number of unknowns at the end coupled to all others.
        start: Optimum of a similar program.
    """
    scale = 1.0 / np.sqrt(np.maximum(np.asarray(P.diagonal()), 1e-12))
    S = sp.diags_array(scale)
    P, q, G = (S @ P @ S).tocsr(), scale * q, (G @ S).tocsr()
    Gt = G.T.tocsr()
    lower = sp.tril(P).tocoo()
    products, rows, columns = _products(G)
    matrix = BorderedBand(
        np.concatenate([lower.row, rows]), np.concatenate([lower.col, columns]), len(q), border
    )
    m = len(h)
    try:
        if start is None:
            matrix.factor(np.concatenate([lower.data, products @ np.ones(m)]))
            x = matrix.solve(Gt @ h - q)
            s, z = np.maximum(h - G @ x, 1e-2), np.full(m, 1e-2)
        else:
            x = start.x / scale
            s, z = (np.maximum(v, MIN_WARM_SLACK) for v in (start.slack, start.multiplier))
        for step in range(MAX_STEPS):
            dual, primal = P @ x + q + Gt @ z, G @ x + s - h
            gap = float(s @ z) / max(m, 1)
            far = max(abs(dual).max() / (1 + abs(q).max()), abs(primal).max(initial=0.0))
            if max(far, gap) < TOLERANCE:
                return QuadraticSolution(scale * x, z, s, step, matrix, scale)
            matrix.factor(np.concatenate([lower.data, products @ (z / s)]))

            dx, ds, dz = _step(matrix, G, Gt, s, z, dual, primal, s * z)
            if m:
                a, b = _furthest(s, ds), _furthest(z, dz)
                centre = (float((s + a * ds) @ (z + b * dz)) / m / gap) ** 3 * gap
                target = s * z + ds * dz - centre
                dx, ds, dz = _step(matrix, G, Gt, s, z, dual, primal, target)
            a = 0.995 * min(_furthest(s, ds), _furthest(z, dz)) if m else 1.0
            x, s, z = x + a * dx, s + a * ds, z + a * dz
    except np.linalg.LinAlgError as error:
        raise SolverError(f"the quadratic program of {len(q)} unknowns is singular") from error
    raise SolverError(
        f"the quadratic program of {len(q)} unknowns and {m} inequalities was not solved in "
        f"{MAX_STEPS} steps"
    )


def _step(matrix: BorderedBand, G, Gt, s, z, dual, primal, target):
    """Return Newton's step of unknowns, slacks and multipliers to ``s z = s z - target``."""
    with np.errstate(over="ignore", invalid="ignore"):
        dx = matrix.solve(-dual - Gt @ (z / s * primal - target / s))
        ds = -primal - G @ dx
        return dx, ds, -(target + z * ds) / s


def _products(G) -> tuple[sp.csr_array, np.ndarray, np.ndarray]:
    """Return the linear map from row weights to lower entries of ``G^T D G``, and indices."""
    counts = np.diff(G.indptr)
    row = np.repeat(np.arange(G.shape[0]), counts)
    pairs: list[tuple[np.ndarray, ...]] = []
    max_count = int(counts.max(initial=0))
    for step in range(max_count):  # each entry with the one `step` further on in its row
        one = np.arange(len(row) - step)
        one = one[row[one] == row[one + step]]
        a, b = G.indices[one], G.indices[one + step]
        value = G.data[one] * G.data[one + step]
        pairs.append((np.maximum(a, b), np.minimum(a, b), value, row[one]))
    if not pairs:
        return sp.csr_array((0, G.shape[0])), np.zeros(0, int), np.zeros(0, int)
    high, low, value, of = (np.concatenate(part) for part in zip(*pairs, strict=True))
    key, at = np.unique(high.astype(np.int64) * G.shape[1] + low, return_inverse=True)
    matrix = sp.coo_array((value, (at, of)), shape=(len(key), G.shape[0])).tocsr()
    return matrix, key // G.shape[1], key % G.shape[1]


def _furthest(values: np.ndarray, change: np.ndarray) -> float:
    """Return the maximum fraction of a change that keeps the values positive, at most one."""
    falls = change < 0
    return float(np.min(-values[falls] / change[falls], initial=1.0))

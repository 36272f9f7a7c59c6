r"""A problem evaluated at a point: rows, their derivatives, and the matrix of Newton's equations.

Everything a solver asks of a problem goes through here; how it steps is in
:mod:`~plantigrade.synthesize.solvers.interior_point`. The matrix is

.. math:: K = W + J^\top D J + \delta I,

with the Hessian :math:`W` of the Lagrangian and weights :math:`D` of rows, a band.
"""

from collections.abc import Iterator

import numpy as np
from scipy.linalg import LinAlgError, cholesky_banded

from plantigrade.arrays import Array
from plantigrade.synthesize.problem.nlp import Problem
from plantigrade.synthesize.solvers.families import Family, limits_of_unknowns
from plantigrade.synthesize.transcription.linear_map import PART, Transcription

GROWTH = 8.0
"""By how much more is added to the diagonal where that was not enough."""

SMALL = 0.5
"""What was added last and is so small that nothing is tried first."""


class Linearised:
    """One problem: derivatives, orders and arrays are made once and used again.

    Attributes:
        problem: The problem.
        t: Its linear maps.
        nv: Number of coordinates.
        families: Rows of every kind that matter anywhere.
    """

    def __init__(self, problem: Problem):
        self.problem = problem
        self.t = Transcription(problem)
        self.nv = self.t.nv
        u_rows = limits_of_unknowns(problem)
        rows = (*problem.rows, *([u_rows] if u_rows is not None else []))
        families = [Family(r, self.t.n_local) for r in rows]
        self.families = [f for f in families if len(f.at)]

    # Evaluation -------------------------------------------------------------------------------

    def _split(self, z: Array) -> tuple[Array, Array, Array, Array]:
        n = self.nv
        return z[:, :n], z[:, n : 2 * n], z[:, 2 * n : 3 * n], z[:, 3 * n :]

    def _values(self, x: Array) -> list[Array]:
        z = self.t.local(x)
        return [f.d.values(*self._split(f.pick(z)), f.parameters) for f in self.families]

    def _jacobians(self, x: Array) -> None:
        z = self.t.local(x)
        for f in self.families:
            here = self._split(f.pick(z))
            if f.linear and f.J.size:
                f.r = f.d.values(*here, f.parameters)
                continue
            f.r, J = f.d.jacobian(*here, f.parameters, out=f.whole)
            f.J = J[:, :, f.columns]
            if f.single:
                column = np.abs(f.J).argmax(axis=2)
                f.only = column, np.take_along_axis(f.J, column[..., None], 2)[..., 0]

    def _down(self, weights: list[Array]) -> Array:
        """Return sum of J' w over families, by x."""
        g = np.zeros((self.t.n_nodes, self.t.n_local))
        for f, w in zip(self.families, weights, strict=True):
            part = np.matmul(w[:, None, :], f.J)[:, 0]
            if f.everywhere:
                g[:, f.columns] += part
            else:
                g[f.at, f.columns] += part
        return self.t.gradient(g)

    def _up(self, dx: Array) -> list[Array]:
        """Return J dx of every family."""
        dz = self.t.local_step(dx)
        return [np.matmul(f.J, f.pick(dz)[:, f.columns, None])[:, :, 0] for f in self.families]

    def _objective(self, x: Array, values: list[Array]) -> float:
        smooth, _ = self.t.smoothness(x)
        return smooth + sum(f.cost(r) for f, r in zip(self.families, values, strict=True))

    # Newton's equations -----------------------------------------------------------------------

    def _hessians(
        self, x: Array, weights: list[Array], *, curved: bool = True
    ) -> Iterator[tuple[slice, Array]]:
        """Yield the Hessian of the Lagrangian by z, and J' D J of every family added, in parts.

        Args:
            x: The point.
            weights: D.
            curved: Whether the curvature of rows counts; otherwise J' D J alone.
        """
        z, n = self.t.local(x), self.t.n_local
        lam = [np.where(f.bound, f.y, 0.0) + f.push(f.r) for f in self.families]
        whole = np.zeros((PART, n, n))
        for nodes in self.t.parts:
            H = whole[: nodes.stop - nodes.start]
            H[:] = 0.0
            for f, w, pushed in zip(self.families, weights, lam, strict=True):
                rows = slice(*np.searchsorted(f.at, (nodes.start, nodes.stop)))
                if rows.start == rows.stop:
                    continue
                at = f.at[rows]
                if curved and not f.linear:
                    where = self._split(z[at])
                    if len(at) == len(H):
                        f.d.hessian(pushed[rows], *where, f.parameters[rows], onto=H)
                    else:
                        H[at - nodes.start] += f.d.hessian(pushed[rows], *where, f.parameters[rows])
                self._add_squares(H, at - nodes.start, f, rows, w[rows])
            yield nodes, H

    def _add_squares(self, H: Array, at: Array, f: Family, rows: slice, w: Array) -> None:
        """Add J' D J of rows of one family to H at nodes."""
        if f.single:
            columns, values = f.only
            column = f.columns.start + columns[rows]
            np.add.at(H, (at[:, None], column, column), w * values[rows] ** 2)
            return
        used = np.flatnonzero(w.any(axis=0))
        J = f.J[rows] if len(used) == w.shape[1] else f.J[rows][:, used]
        block = np.matmul((J * w[:, used, None]).transpose(0, 2, 1), J)
        if len(at) == len(H):
            H[:, f.columns, f.columns] += block
        else:
            H[at, f.columns, f.columns] += block

    def _sigma(self) -> list[Array]:
        out = []
        for f in self.families:
            a, b = f.room(f.s)
            out.append(np.where(f.has_low, f.zl / a, 0.0) + np.where(f.has_high, f.zu / b, 0.0))
        return out

    def _damped(self, band: Array, damping: float) -> Array | None:
        """Return the Cholesky factor with a number added to the diagonal."""
        trial = band.copy(order="F")
        trial[0] += damping
        try:
            return cholesky_banded(trial, overwrite_ab=True, lower=True, check_finite=False)
        except LinAlgError:
            return None

    def _factor(self, band: Array, before: float) -> tuple[Array | None, float]:
        """Return the Cholesky factor, and how much had to be added to the diagonal for one."""
        added = 0.0 if before < SMALL else before / 4.0
        for _ in range(40):
            trial = band.copy(order="F")
            trial[0] += added + 1e-12
            try:
                factor = cholesky_banded(trial, overwrite_ab=True, lower=True, check_finite=False)
                return factor, added
            except LinAlgError:
                added = added * GROWTH if added else max(before / 3.0, 1e-3)
        return None, added

    def _violated(self, values: list[Array]) -> float:
        """Return the sum of squared violations."""
        return sum(
            float(np.sum(f.violation(r) ** 2)) for f, r in zip(self.families, values, strict=True)
        )

    def _worst(self, values: list[Array]) -> tuple[float, str]:
        worst, name = 0.0, ""
        for f, r in zip(self.families, values, strict=True):
            off = f.violation(r)
            k, i = np.unravel_index(int(np.argmax(off)), off.shape)
            if off[k, i] > worst:
                worst = float(off[k, i])
                name = f"{f.rows.names[i]} at {self.problem.nodes[f.at[k]]:.2f} s"
        return worst, name

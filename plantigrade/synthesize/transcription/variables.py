r"""What a solver moves, as one vector :math:`x`: spline coefficients and free node unknowns.

The order keeps together what meets at a node, so that the Hessian is a narrow band; a periodic
motion is folded, so that its two ends lie side by side.
"""

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.errors import ParameterError
from plantigrade.synthesize.problem.nlp import Problem


class Variables:
    """The variables of one problem, and where each of them lies in the vector.

    Attributes:
        problem: The problem.
        size: Number of variables.
        reach: How far apart two variables that meet at a node lie at most.
        c_at: Place of every coefficient (n_coefficients, n_coordinates).
        u_at: Place of every node unknown (n_nodes, n_unknowns); -1 where it is fixed.
    """

    def __init__(self, problem: Problem, window: Int[Array, "n_nodes w"]):
        self.problem = problem
        self._order(window)
        self._free = self.u_at >= 0

    def join(
        self, c: Float[Array, "n_coefficients nv"], u: Float[Array, "n_nodes nu"]
    ) -> Float[Array, " size"]:
        """Return the vector of coefficients and node unknowns."""
        x = np.empty(self.size)
        x[self.c_at] = c
        x[self.u_at[self._free]] = u[self._free]
        return x

    def split(
        self, x: Float[Array, " size"]
    ) -> tuple[Float[Array, "n_coefficients nv"], Float[Array, "n_nodes nu"]]:
        """Return coefficients and node unknowns; the fixed ones have their value."""
        u = np.array(self.problem.u_lower, dtype=float).reshape(self.u_at.shape)
        u[self._free] = x[self.u_at[self._free]]
        return x[self.c_at], u

    def start(self, c: Array, u: Array | None = None) -> Float[Array, " size"]:
        """Return the vector of an initial guess; unknowns are zero if there are none given.

        Raises:
            ParameterError: If the guess has another shape than the problem, or is not finite.
        """
        u = np.zeros(self.u_at.shape) if u is None else u
        for what, given, wanted in (
            ("coefficients", c, self.c_at.shape),
            ("node unknowns", u, self.u_at.shape),
        ):
            if given.shape != wanted:
                raise ParameterError(
                    f"the guess has {what} {given.shape}; this problem has {wanted}"
                )
            if not np.isfinite(given).all():
                raise ParameterError(f"the guess has {what} that are not finite")
        return self.join(c, u)

    def _order(self, window: Array) -> None:
        """Place blocks of variables in an order that keeps the band narrow."""
        p, n, nv = self.problem, len(self.problem.nodes), len(self.problem.names)
        n_c, nu = p.basis.n_coefficients, p.n_unknowns
        active = [np.flatnonzero(row) for row in p.u_active] if nu else [np.zeros(0, int)] * n
        blocks: list[tuple[float, int, int]] = [(float(i), 0, i) for i in range(n_c)]
        blocks += [(float(window[k, 0]) + 1.5, 1, k) for k in range(n)]
        if p.closure is not None:  # fold: what lies near either end lies near the beginning
            blocks = [(min(at, n_c - at), kind, i) for at, kind, i in blocks]
        blocks.sort()
        c_start, u_start = np.zeros(n_c, int), np.zeros(n, int)
        at = 0
        for _, kind, i in blocks:
            if kind == 0:
                c_start[i] = at
                at += nv
            else:
                u_start[i] = at
                at += len(active[i])
        self.size = at
        self.c_at = c_start[:, None] + np.arange(nv)
        self.u_at = np.full((n, nu), -1)
        for k, act in enumerate(active):
            self.u_at[k, act] = u_start[k] + np.arange(len(act))
        self.reach = 0
        for k in range(n):
            starts = c_start[window[k] % n_c]
            lowest, highest = starts.min(), starts.max() + nv
            if len(active[k]):
                lowest = min(lowest, u_start[k])
                highest = max(highest, u_start[k] + len(active[k]))
            self.reach = max(self.reach, int(highest - lowest - 1))

r"""A problem between what a solver moves and what its rows see.

A solver moves one vector :math:`x`: the coefficients of the spline and the node unknowns that are
free. Rows see :math:`z_k = (q, \dot q, \ddot q, u)` at each node. Both ways are linear,

.. math:: z_k = T_k x + d_k, \qquad \nabla_x = \sum_k T_k^\top \nabla_{z_k}, \qquad
    H_x = \sum_k T_k^\top H_k T_k,

and :math:`T_k` touches the few coefficients whose support holds the node. :math:`x` is ordered so
that what meets at a node lies together, and :math:`H_x` is a band; a motion that goes round is
folded, so that its two ends lie side by side.
"""

from collections.abc import Sequence

import numpy as np
from numpy.lib.stride_tricks import as_strided

from plantigrade.arrays import Array, Float, Int
from plantigrade.synthesize.problem import Problem


class Transcription:
    """The linear maps of one problem.

    Attributes:
        problem: The problem.
        size: Number of unknowns.
        half_band: How far from the diagonal entries of :math:`H_x` lie at most.
    """

    def __init__(self, problem: Problem):
        self.problem = problem
        self.n_nodes = len(problem.nodes)
        self.nv = len(problem.names)
        self.nu = problem.n_unknowns
        self.window, self.basis = _windows(problem)
        self._drift = np.stack([problem.drift(problem.nodes, d) for d in range(3)], axis=1)
        self._order()
        self._smoothness()

    @property
    def n_local(self) -> int:
        """Length of z at a node."""
        return 3 * self.nv + self.nu

    # Between x and z --------------------------------------------------------------------------

    def join(
        self, c: Float[Array, "n_coefficients nv"], u: Float[Array, "n_nodes nu"]
    ) -> Float[Array, " size"]:
        """Return the vector of coefficients and node unknowns."""
        x = np.empty(self.size)
        x[self._c_at] = c
        active = self._u_at >= 0
        x[self._u_at[active]] = u[active]
        return x

    def split(
        self, x: Float[Array, " size"]
    ) -> tuple[Float[Array, "n_coefficients nv"], Float[Array, "n_nodes nu"]]:
        """Return coefficients and node unknowns; those that are fixed have their value."""
        u = np.array(self.problem.u_lower, dtype=float)
        active = self._u_at >= 0
        u[active] = x[self._u_at[active]]
        return x[self._c_at], u

    def local(self, x: Float[Array, " size"]) -> Float[Array, "n_nodes n_local"]:
        """Return z at every node."""
        c, u = self.split(x)
        states = np.matmul(self.basis, self.problem.continued(c, self.window)) + self._drift
        return np.hstack([states.reshape(self.n_nodes, -1), u])

    def local_step(self, dx: Float[Array, " size"]) -> Float[Array, "n_nodes n_local"]:
        """Return the change of z for a change of x."""
        dc = dx[self._c_at][self._base]
        if self._turned.any():
            k = self.problem.closure
            assert k is not None
            dc[self._turned] = (dc[self._turned])[:, k.source] * k.sign
        du = np.zeros((self.n_nodes, self.nu))
        active = self._u_at >= 0
        du[active] = dx[self._u_at[active]]
        states = np.matmul(self.basis, dc)
        return np.hstack([states.reshape(self.n_nodes, -1), du])

    def gradient(self, g: Float[Array, "n_nodes n_local"]) -> Float[Array, " size"]:
        """Return the gradient by x of what has gradient ``g`` by z."""
        states = g[:, : 3 * self.nv].reshape(self.n_nodes, 3, self.nv)
        pulled = np.matmul(self.basis.transpose(0, 2, 1), states)
        if self._turned.any():
            pulled[self._turned] = pulled[self._turned][:, self._back] * self._back_sign
        out = np.zeros(self.size)
        np.add.at(out, self._c_at[self._base], pulled)
        active = self._u_at >= 0
        out[self._u_at[active]] = g[:, 3 * self.nv :][active]
        return out

    # Matrices ---------------------------------------------------------------------------------

    def band(self) -> Float[Array, "half_band_1 size"]:
        """Return a band of zeros, lower form: entry (i, j) is at ``[i - j, j]``."""
        return np.zeros((self.half_band + 1, self.size), order="F")

    def assemble(
        self, H: Float[Array, "n_nodes n_local n_local"], band: Float[Array, "half_band_1 size"]
    ) -> None:
        """Add the Hessian by x of what has Hessian ``H`` by z, both triangles given, to a band."""
        n, nv, w = self.n_nodes, self.nv, self.window.shape[1]
        s, L = 3 * nv, w * nv
        Bt = np.ascontiguousarray(self.basis.transpose(0, 2, 1))
        half = np.matmul(Bt, H[:, :s, :s].reshape(n, 3, nv * s)).reshape(n, L, 3, nv)
        half = np.ascontiguousarray(half.transpose(0, 2, 1, 3)).reshape(n, 3, L * nv)
        # (window, row, column): block i of the columns
        cc = np.matmul(Bt, half).reshape(n, w, L, nv)
        cu = None
        if self.nu:
            cu = np.matmul(Bt, H[:, :s, s:].reshape(n, 3, nv * self.nu)).reshape(n, L, self.nu)
        view = _dense_view(band)
        for k in range(n):
            starts = self._c_start[self._base[k]]
            act = self._u_active[k]
            for i in range(w):
                for j in range(w):
                    if starts[i] < starts[j]:
                        continue
                    block = cc[k, j, i * nv : (i + 1) * nv]
                    if self._turned[k, i]:
                        block = block[self._back] * self._back_sign[:, None]
                    if self._turned[k, j]:
                        block = block[:, self._back] * self._back_sign
                    a, b = starts[i], starts[j]
                    view[a : a + nv, b : b + nv] += np.tril(block) if i == j else block
            if len(act):
                at = self._u_start[k]
                m = len(act)
                uu = H[k, s:, s:][np.ix_(act, act)]
                view[at : at + m, at : at + m] += np.tril(uu)
                assert cu is not None
                for i in range(w):
                    block = cu[k, i * nv : (i + 1) * nv][:, act]
                    if self._turned[k, i]:
                        block = block[self._back] * self._back_sign[:, None]
                    a = starts[i]
                    if a > at:
                        view[a : a + nv, at : at + m] += block
                    else:
                        view[at : at + m, a : a + nv] += block.T

    def add_smoothness(self, band: Float[Array, "half_band_1 size"]) -> None:
        """Add the Hessian of the steps of node unknowns to a band."""
        i, j, values = self._steps
        np.add.at(band, (i - j, j), values)

    def smoothness(self, x: Float[Array, " size"]) -> tuple[float, Float[Array, " size"]]:
        """Return what the steps of node unknowns cost, and the gradient."""
        if not self.problem.u_smooth.size:
            return 0.0, np.zeros(self.size)
        p = self.problem
        _, u = self.split(x)
        after = u[1:]
        if p.closure is not None:
            after = np.vstack([u[1:], u[:1][:, p.closure.u_source] * p.closure.u_sign])
        step = after - u[: len(after)]
        pull = p.u_smooth * step
        g = np.zeros_like(u)
        g[: len(pull)] -= pull
        g[1:] += pull[: self.n_nodes - 1]
        if p.closure is not None:
            np.add.at(g[0], p.closure.u_source, pull[-1] * p.closure.u_sign)
        out = np.zeros(self.size)
        active = self._u_at >= 0
        out[self._u_at[active]] = g[active]
        return 0.5 * float(np.sum(pull * step)), out

    # Order ------------------------------------------------------------------------------------

    def _order(self) -> None:
        """Put blocks of unknowns in an order that keeps the band narrow."""
        p, n = self.problem, self.n_nodes
        n_c = p.basis.n_coefficients
        self._turned, self._base = np.divmod(self.window, n_c)
        self._turned = self._turned.astype(bool)
        if p.closure is not None:
            self._back = np.argsort(p.closure.source)
            self._back_sign = p.closure.sign[self._back]
        else:
            self._back, self._back_sign = np.arange(self.nv), np.ones(self.nv)
        self._u_active = (
            [np.flatnonzero(row) for row in p.u_active] if self.nu else [np.zeros(0, int)] * n
        )
        blocks: list[tuple[float, int, int]] = [(float(i), 0, i) for i in range(n_c)]
        blocks += [(float(self.window[k, 0]) + 1.5, 1, k) for k in range(n)]
        if p.closure is not None:  # fold: what lies near both ends lies near the beginning
            blocks = [(min(at, n_c - at), kind, i) for at, kind, i in blocks]
        blocks.sort()
        self._c_start = np.zeros(n_c, int)
        self._u_start = np.zeros(n, int)
        at = 0
        for _, kind, i in blocks:
            if kind == 0:
                self._c_start[i] = at
                at += self.nv
            else:
                self._u_start[i] = at
                at += len(self._u_active[i])
        self.size = at
        self._c_at = self._c_start[:, None] + np.arange(self.nv)
        self._u_at = np.full((n, self.nu), -1)
        for k, act in enumerate(self._u_active):
            self._u_at[k, act] = self._u_start[k] + np.arange(len(act))
        reach = 0
        for k in range(n):
            starts = self._c_start[self._base[k]]
            lowest, highest = starts.min(), starts.max() + self.nv
            if len(self._u_active[k]):
                lowest = min(lowest, self._u_start[k])
                highest = max(highest, self._u_start[k] + len(self._u_active[k]))
            reach = max(reach, highest - lowest - 1)
        self.half_band = int(reach)

    def _smoothness(self) -> None:
        """Find the entries of the Hessian that the steps of node unknowns have."""
        p = self.problem
        rows, columns, values = [], [], []
        weights = p.u_smooth if p.u_smooth.size else np.zeros((0, self.nu))
        for k in range(len(weights)):
            here, after = self._u_at[k], self._u_at[(k + 1) % self.n_nodes]
            sign = np.ones(self.nu)
            if k + 1 == self.n_nodes:
                assert p.closure is not None
                after, sign = after[p.closure.u_source], p.closure.u_sign
            for a, b, s, weight in zip(here, after, sign, weights[k], strict=True):
                for i in (a, b):
                    if i >= 0:
                        rows.append(i), columns.append(i), values.append(weight)
                if a >= 0 and b >= 0 and a != b:
                    rows.append(max(a, b)), columns.append(min(a, b)), values.append(-s * weight)
        self._steps = (np.array(rows, int), np.array(columns, int), np.array(values))
        if len(rows):
            self.half_band = max(self.half_band, int(np.max(self._steps[0] - self._steps[1])))


def _windows(problem: Problem) -> tuple[Int[Array, "n_nodes w"], Float[Array, "n_nodes 3 w"]]:
    """Return which coefficients a node touches, and how (n_nodes, 3, w)."""
    bands = [problem.basis.band(problem.nodes, d) for d in range(3)]
    values = np.stack([b.values for b in bands], axis=1)
    first = bands[0].first.copy()
    used = np.abs(values).max(axis=1) > 1e-12 * np.abs(values).max(axis=(1, 2))[:, None]
    skipped = np.argmax(used, axis=1)
    width = int((values.shape[2] - np.argmax(used[:, ::-1], axis=1) - skipped).max())
    skipped = np.minimum(skipped, values.shape[2] - width)
    columns = skipped[:, None] + np.arange(width)
    return first[:, None] + columns, np.take_along_axis(values, columns[:, None, :], axis=2)


def _dense_view(band: Float[Array, "half_band_1 size"]) -> Float[Array, "size size"]:
    """Return a band in lower form as a matrix; only entries within its lower half are its own."""
    high, n = band.shape
    step = band.itemsize
    return as_strided(band, shape=(n, n), strides=(step, step * (high - 1)))


def column_ranges(columns: Sequence[int], n_local: int) -> slice | Int[Array, " n"]:
    """Return columns as a slice where they are one stretch."""
    columns = np.unique(np.asarray(columns, int))
    if len(columns) and columns[-1] - columns[0] + 1 == len(columns):
        return slice(int(columns[0]), int(columns[-1]) + 1)
    return columns

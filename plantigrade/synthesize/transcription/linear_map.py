r"""A problem between what a solver moves and what its rows see.

A solver moves one vector :math:`x`: the coefficients of the spline and the node unknowns that are
free. Rows see :math:`z_k = (q, \dot q, \ddot q, u)` at each node. Both ways are linear,

.. math:: z_k = T_k x + d_k, \qquad \nabla_x = \sum_k T_k^\top \nabla_{z_k}, \qquad
    H_x = \sum_k T_k^\top H_k T_k,

and :math:`T_k` touches the few coefficients whose support holds the node. :math:`x` is ordered so
that what meets at a node lies together, and :math:`H_x` is a band; a motion that goes round is
folded, so that its two ends lie side by side.
"""

from collections.abc import Iterable

import numpy as np
from scipy import sparse

from plantigrade.arrays import Array, Float, Int
from plantigrade.synthesize.problem.nlp import Problem

PART = 32
"""Nodes that are assembled at a time."""


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
        self._band_places()

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
        u = np.array(self.problem.u_lower, dtype=float).reshape(self.n_nodes, self.nu)
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

    def assemble(
        self,
        parts: Iterable[tuple[slice, Float[Array, "m n_local n_local"]]],
        *,
        smooth: bool = True,
    ) -> Float[Array, "half_band_1 size"]:
        """Return the Hessian by x of what has Hessian ``H`` by z, steps and jerk added, as a band.

        Args:
            parts: Nodes of one of :attr:`parts`, and ``H`` there: symmetric, both triangles given.
                It is used at once, so that all may be in the same array.
            smooth: Whether steps and jerk are added.

        Returns:
            Lower form: entry (i, j) is at ``[i - j, j]``.
        """
        flat = np.zeros(self._n_band)
        nv, w, nu = self.nv, self.window.shape[1], self.nu
        s, L = 3 * nv, w * nv
        for nodes, H in parts:
            m = len(H)
            Bt = np.ascontiguousarray(self.basis[nodes].transpose(0, 2, 1))
            half = np.matmul(Bt, H[:, :s].reshape(m, 3, nv * (s + nu))).reshape(m, L, s + nu)
            states = np.ascontiguousarray(
                half[:, :, :s].reshape(m, L, 3, nv).transpose(0, 2, 1, 3)
            ).reshape(m, 3, L * nv)
            values = np.concatenate(
                [
                    np.matmul(Bt, states).reshape(m, -1),
                    half[:, :, s:].reshape(m, -1),
                    H[:, s:, s:].reshape(m, -1),
                ],
                axis=1,
            )
            start, stop, places, sign = self._places[nodes.start]
            if sign is not None:
                values *= sign
            found = np.bincount(places, weights=values.ravel(), minlength=stop - start + 1)
            flat[start:stop] += found[:-1]
        if smooth:
            flat[self._smooth_at] += self._smooth_values
        return flat.reshape(self.size, self.half_band + 1).T

    @property
    def parts(self) -> list[slice]:
        """Nodes in parts that fit a processor's cache."""
        return [slice(k, min(k + PART, self.n_nodes)) for k in range(0, self.n_nodes, PART)]

    def _band_places(self) -> None:
        """Find where in a band every entry of the blocks of all nodes goes."""
        n, nv, w, nu = self.n_nodes, self.nv, self.window.shape[1], self.nu
        at = self._c_at[self._base]  # (n, w, nv)
        sign = np.ones(at.shape)
        if self.problem.closure is not None:
            k = self.problem.closure
            at = np.where(self._turned[:, :, None], at[:, :, k.source], at)
            sign = np.where(self._turned[:, :, None], k.sign, sign)
        rows = at.reshape(n, 1, w * nv, 1)
        columns = at.reshape(n, w, 1, nv)
        states = self._offsets(rows, columns)
        mixed = np.zeros((n, w * nv, nu), int)
        unknown = np.zeros((n, nu, nu), int)
        if nu:
            u = self._u_at
            i, j = at.reshape(n, -1, 1), u.reshape(n, 1, nu)
            mixed = self._offsets(np.maximum(i, j), np.where(j < 0, -1, np.minimum(i, j)))
            unknown = self._offsets(
                np.where(u[:, :, None] < 0, -1, u[:, :, None]), u[:, None, :] + 0 * u[:, :, None]
            )
        every = [x.reshape(n, -1) for x in (states, mixed, unknown)]
        places = np.concatenate(every, axis=1)
        signs = None
        if (sign < 0).any():
            both = sign.reshape(n, 1, -1, 1) * sign.reshape(n, w, 1, nv)
            one = np.broadcast_to(sign.reshape(n, -1, 1), mixed.shape)
            each = (both, one, np.ones(unknown.shape))
            signs = np.concatenate([x.reshape(n, -1) for x in each], axis=1)
        self._places = {}
        for nodes in self.parts:  # the entries of a part, counted from its first
            here = places[nodes]
            inside = here < self._n_band
            start, stop = int(here[inside].min()), int(here[inside].max()) + 1
            local = np.where(inside, here - start, stop - start).ravel()
            of = None if signs is None else signs[nodes]
            self._places[nodes.start] = start, stop, local, of

    def _offsets(self, i: Int[Array, "..."], j: Int[Array, "..."]) -> Int[Array, "..."]:
        """Return the place of (i, j) in a band laid out column by column, the last for none."""
        high = self.half_band + 1
        self._n_band = high * self.size
        fine = (i >= j) & (j >= 0) & (i - j < high)
        return np.where(fine, (i - j) + j * high, self._n_band)

    def smoothness(self, x: Float[Array, " size"]) -> tuple[float, Float[Array, " size"]]:
        """Return what steps of node unknowns and jerk cost, and the gradient."""
        pull = self._quadratic @ x
        return float(x @ (0.5 * pull + self._linear)) + self._constant, pull + self._linear

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
        """Find the quadratic form that steps of node unknowns and jerk cost."""
        p, n, n_c = self.problem, self.n_nodes, self.problem.basis.n_coefficients
        rough = p.roughness()
        weights = p.u_smooth if p.u_smooth.size else np.zeros((0, self.nu))
        here = np.arange(n * self.nu).reshape(n, self.nu)
        after, sign = here[1:], np.ones((n - 1, self.nu))
        if p.closure is not None:
            after = np.vstack([after, here[:1, p.closure.u_source]])
            sign = np.vstack([sign, p.closure.u_sign])
        after, sign = after[: len(weights)].ravel(), sign[: len(weights)].ravel()
        root = np.sqrt(weights.ravel())
        rows = np.arange(len(root))
        steps = sparse.csr_matrix(
            (
                np.concatenate([-root, root * sign]),
                (np.tile(rows, 2), np.concatenate([here[: len(weights)].ravel(), after])),
            ),
            shape=(len(root), n * self.nu),
        )
        D = sparse.block_diag([rough, steps], format="csr")
        at = np.concatenate([self._c_at.ravel(), self._u_at.ravel()])
        free = np.flatnonzero(at >= 0)
        put = sparse.csr_matrix((np.ones(len(free)), (free, at[free])), shape=(len(at), self.size))
        fixed = np.concatenate([np.zeros(n_c * self.nv), p.u_lower.ravel()])
        fixed[free] = 0.0
        moved, still = sparse.csr_matrix(D @ put), D @ fixed
        self._quadratic = sparse.csr_matrix(moved.T @ moved)
        self._linear, self._constant = moved.T @ still, 0.5 * float(still @ still)
        lower = sparse.coo_matrix(sparse.tril(self._quadratic))
        if lower.nnz:
            self.half_band = max(self.half_band, int(np.max(lower.row - lower.col)))
        self._smooth_at = self._offsets(lower.row, lower.col)
        self._smooth_values = lower.data


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

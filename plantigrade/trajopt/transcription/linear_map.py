r"""From the variables of a problem to what its constraints see at the nodes, and back.

A solver moves one vector :math:`x` (:mod:`~plantigrade.trajopt.transcription.variables`).
Constraints see :math:`z_k = (q, \dot q, \ddot q, u)` at each node. Both directions are linear,

.. math:: z_k = T_k x + d_k, \qquad \nabla_x = \sum_k T_k^\top \nabla_{z_k}, \qquad
    H_x = \sum_k T_k^\top H_k T_k,

and :math:`T_k` touches the few coefficients whose support contains the node, so that :math:`H_x` is
a band.
"""

from collections.abc import Iterable
from functools import cached_property
from typing import Any

import numpy as np
from scipy import sparse

from plantigrade.arrays import Array, Float, Int
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.transcription.variables import Smoothness, Variables

NODES_PER_PART = 32  #: Number of nodes assembled at a time [1]


class Transcription:
    """The linear maps of one problem.

    Attributes:
        problem: The problem.
        n_nodes, nv, nu: Numbers of nodes, coordinates, and unknowns at each node, fixed ones
            included.
        variables: Variables of the solver, in order.
        size: Number of variables.
        smoothness: Cost of steps and jerk, and its gradient, of variables.
        window: Coefficients that each node touches (n_nodes, w), counted on round the end.
        basis: How (n_nodes, 3, w): for coordinates, rates and accelerations.
    """

    def __init__(self, problem: Problem):
        self.problem = problem
        self.n_nodes, self.nv = len(problem.nodes), len(problem.names)
        self.nu = problem.n_unknowns
        self.window, self.basis = _windows(problem)
        self.variables = Variables(problem, self.window)
        self.size = self.variables.size
        self.join, self.split = self.variables.join, self.variables.split
        self.smoothness = Smoothness(self.variables)
        self._drift = np.stack([problem.drift(problem.nodes, d) for d in range(3)], axis=1)
        self._find_columns()

    @property
    def n_local(self) -> int:
        """Length of z at a node."""
        return 3 * self.nv + self.nu

    def local(self, x: Float[Array, " size"]) -> Float[Array, "n_nodes n_local"]:
        """Return z at every node."""
        c, u = self.split(x)
        states = np.matmul(self.basis, self.problem.continued(c, self.window)) + self._drift
        return np.hstack([states.reshape(self.n_nodes, -1), u])

    def local_step(self, dx: Float[Array, " size"]) -> Float[Array, "n_nodes n_local"]:
        """Return the change of z for a change of x."""
        states = np.matmul(self.basis, dx[self._columns] * self._signs)
        du = np.where(self.variables.free, dx[self.variables.u_at], 0.0)
        return np.hstack([states.reshape(self.n_nodes, -1), du])

    def gradient(self, g: Float[Array, "n_nodes n_local"]) -> Float[Array, " size"]:
        """Return the gradient by x of what has gradient ``g`` by z."""
        states = g[:, : 3 * self.nv].reshape(self.n_nodes, 3, self.nv)
        pulled = np.matmul(self.basis.transpose(0, 2, 1), states) * self._signs
        out = np.zeros(self.size)
        np.add.at(out, self._columns, pulled)
        free = self.variables.free
        out[self.variables.u_at[free]] = g[:, 3 * self.nv :][free]
        return out

    def matrix(self) -> Any:
        """Return all :math:`T_k`, one below the other, as a sparse matrix."""
        n, nv, w = self.n_nodes, self.nv, self.window.shape[1]
        shape = (n, 3, w, nv)
        k, d, v = np.arange(n)[:, None, None, None], np.arange(3)[:, None, None], np.arange(nv)
        rows = np.broadcast_to(k * self.n_local + d * nv + v, shape)
        columns = np.broadcast_to(self._columns[:, None], shape)
        values = self.basis[..., None] * self._signs[:, None]
        k, i = np.nonzero(self.variables.free)
        entries = np.concatenate([values.ravel(), np.ones(len(k))])
        rows = np.concatenate([rows.ravel(), k * self.n_local + 3 * nv + i])
        columns = np.concatenate([columns.ravel(), self.variables.u_at[k, i]])
        return sparse.csr_matrix((entries, (rows, columns)), shape=(n * self.n_local, self.size))

    def jacobian(
        self, nodes: Int[Array, " m"], J: Float[Array, "m n_rows n_local"]
    ) -> tuple[Float[Array, "m n_rows n_touched"], Int[Array, "m n_touched"]]:
        """Return the Jacobian by x of what has Jacobian ``J`` by z at some nodes.

        Returns:
            Entries, and the variable that each column of a node belongs to; -1 for none.
        """
        m, n_rows, nv, w = len(nodes), J.shape[1], self.nv, self.window.shape[1]
        states = J[:, :, : 3 * nv].reshape(m, n_rows, 3, nv)
        values = np.matmul(self.basis[nodes].transpose(0, 2, 1)[:, None], states)
        values = (values * self._signs[nodes][:, None]).reshape(m, n_rows, w * nv)
        columns = np.hstack([self._columns[nodes].reshape(m, -1), self.variables.u_at[nodes]])
        return np.concatenate([values, J[:, :, 3 * nv :]], axis=2), columns

    def assemble(
        self,
        parts: Iterable[tuple[slice, Float[Array, "m n_local n_local"]]],
        *,
        smooth: float = 1.0,
    ) -> Float[Array, "half_band_1 size"]:
        """Return the Hessian by x of what has Hessian ``H`` by z, and of steps and jerk, as a band.

        Entry (i, j) of its lower triangle is at ``[i - j, j]``.

        Args:
            parts: Nodes of one of :attr:`parts`, and ``H`` there: symmetric, both triangles given.
                It is used at once, so that all may be in the same array.
            smooth: Factor of the Hessian of steps and jerk.
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
            every = np.matmul(Bt, states), half[:, :, s:], H[:, s:, s:]
            values = np.concatenate([x.reshape(m, -1) for x in every], axis=1)
            start, stop, places, sign = self._places[nodes.start]
            if sign is not None:
                values *= sign
            found = np.bincount(places, weights=values.ravel(), minlength=stop - start + 1)
            flat[start:stop] += found[:-1]
        lower = self._smooth
        flat[self._offsets(lower.row, lower.col)] += smooth * lower.data
        return flat.reshape(self.size, self.half_band + 1).T

    @property
    def parts(self) -> list[slice]:
        """Nodes in parts that fit a processor's cache."""
        return [
            slice(k, min(k + NODES_PER_PART, self.n_nodes))
            for k in range(0, self.n_nodes, NODES_PER_PART)
        ]

    def _find_columns(self) -> None:
        """Find the variable, and its sign, of every coefficient that a node touches."""
        lap, index = np.divmod(self.window, self.problem.basis.n_coefficients)
        at = self.variables.c_at[index]  # (n_nodes, w, nv)
        sign = np.ones(at.shape)
        if self.problem.closure is not None:
            k, turned = self.problem.closure, lap[:, :, None] > 0
            at = np.where(turned, at[:, :, k.source], at)
            sign = np.where(turned, k.sign, sign)
        self._columns, self._signs = at, sign

    @cached_property
    def half_band(self) -> int:
        """How far from the diagonal entries of :math:`H_x` lie at most."""
        lower = self._smooth
        return max(self.variables.reach, int((lower.row - lower.col).max(initial=0)))

    @cached_property
    def _smooth(self) -> Any:
        """The lower triangle of the Hessian of steps and jerk."""
        return sparse.coo_matrix(sparse.tril(self.smoothness.quadratic))

    @property
    def _n_band(self) -> int:
        return (self.half_band + 1) * self.size

    @cached_property
    def _places(self) -> dict[int, tuple[int, int, Array, Array | None]]:
        """Where in a band every entry of the blocks of nodes goes, by the first node of a part."""
        n, nv, w, nu = self.n_nodes, self.nv, self.window.shape[1], self.nu
        at, sign = self._columns, self._signs
        states = self._offsets(at.reshape(n, 1, w * nv, 1), at.reshape(n, w, 1, nv))
        mixed = np.zeros((n, w * nv, nu), int)
        unknown = np.zeros((n, nu, nu), int)
        if nu:
            u = self.variables.u_at
            i, j = at.reshape(n, -1, 1), u.reshape(n, 1, nu)
            mixed = self._offsets(np.maximum(i, j), np.minimum(i, j))
            unknown = self._offsets(u[:, :, None], u[:, None, :])
        every = [x.reshape(n, -1) for x in (states, mixed, unknown)]
        places = np.concatenate(every, axis=1)
        signs = None
        if (sign < 0).any():
            both = sign.reshape(n, 1, -1, 1) * sign.reshape(n, w, 1, nv)
            one = np.broadcast_to(sign.reshape(n, -1, 1), mixed.shape)
            each = (both, one, np.ones(unknown.shape))
            signs = np.concatenate([x.reshape(n, -1) for x in each], axis=1)
        found: dict[int, tuple[int, int, Array, Array | None]] = {}
        for nodes in self.parts:  # the entries of a part, counted from its first
            here = places[nodes]
            inside = here < self._n_band
            start, stop = int(here[inside].min()), int(here[inside].max()) + 1
            local = np.where(inside, here - start, stop - start).ravel()
            sign = None if signs is None else signs[nodes]
            found[nodes.start] = start, stop, local, sign
        return found

    def _offsets(self, i: Int[Array, "..."], j: Int[Array, "..."]) -> Int[Array, "..."]:
        """Return the place of (i, j) in a band laid out column by column, the last for none."""
        high = self.half_band + 1
        fine = (i >= j) & (j >= 0) & (i - j < high)
        return np.where(fine, (i - j) + j * high, self._n_band)


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

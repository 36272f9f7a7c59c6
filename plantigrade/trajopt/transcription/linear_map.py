r"""From the variables of a problem to what its constraints see at the nodes, and back.

A solver moves one vector :math:`x` (:mod:`~plantigrade.trajopt.transcription.variables`).
Constraints see :math:`z_k = (q, \dot q, \ddot q, u)` at each node. Both directions are linear,

.. math:: z_k = T_k x + d_k, \qquad \nabla_x = \sum_k T_k^\top \nabla_{z_k}, \qquad
    H_x = \sum_k T_k^\top H_k T_k,

and :math:`T_k` touches the few coefficients whose support contains the node, so that :math:`H_x` is
a band.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from typing import Any

import numpy as np
from scipy import sparse

from plantigrade.arrays import Array, Float, Int
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.transcription.variables import Smoothness, Variables


class Band:
    """The lower triangle of a symmetric band, in memory that is used again.

    Columns in memory are longer than the band is wide: what a block on the diagonal has above it
    falls into the end of the column before, where nothing is read.

    Args:
        size: Number of rows and columns.
        half_band: How far from the diagonal entries lie at most.
        widest: Number of columns of the widest block.

    Attributes:
        lower: Entry (i, j) at ``[i - j, j]``, a view (half_band + 1, size).
    """

    def __init__(self, size: int, half_band: int, widest: int):
        self._start, self._column = widest, half_band + max(widest, 1)
        self._memory = np.zeros(widest + size * self._column)
        columns = self._memory[widest:].reshape(size, self._column)
        self.lower: Float[Array, "half_band_1 size"] = columns[:, : half_band + 1].T

    def clear(self) -> None:
        """Set all entries to zero."""
        self._memory[:] = 0.0

    def block(self, row: int, column: int, shape: tuple[int, int]) -> Array:
        """Return the view of a block, of which only what lies in the lower triangle counts."""
        at = self._start + row - column + column * self._column
        size = self._memory.itemsize
        strides = size, size * (self._column - 1)
        return np.ndarray(shape, self._memory.dtype, self._memory.data, size * at, strides)


@dataclass(frozen=True, eq=False)
class _Group:
    """Variables that a node touches and that lie side by side in the vector."""

    kind: int  # which coefficient of its window they belong to; the size of that for unknowns
    start: int  # the first variable
    count: int
    order: Array | None  # of its coordinates or unknowns, where not all of them as they are
    sign: Array | None  # of each in that order, where one is negative


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

        Entry (i, j) of its lower triangle is at ``[i - j, j]``, in memory that the next call uses
        again.

        Args:
            parts: Some nodes and ``H`` there: symmetric, both triangles given. It is used at once,
                so that all may be in the same array.
            smooth: Factor of the Hessian of steps and jerk.
        """
        self._band.clear()
        for nodes, H in parts:
            for k, h in zip(range(nodes.start, nodes.stop), H, strict=True):
                self._add(k, h)
        lower = self._smooth
        self._band.lower[lower.row - lower.col, lower.col] += smooth * lower.data
        return self._band.lower

    def _add(self, k: int, h: Float[Array, "n_local n_local"]) -> None:
        """Add the Hessian by z at a node to the band."""
        nv, w = self.nv, self.window.shape[1]
        s, T = 3 * nv, self._transposed[k]
        half = (T @ h[:s].reshape(3, -1)).reshape(w * nv, -1)
        states = half[:, :s].reshape(w * nv, 3, nv).transpose(1, 0, 2).reshape(3, -1)
        every = (T @ states).reshape(w, w, nv, nv)
        for into, a, b in self._blocks[k]:
            if max(a.kind, b.kind) < w:
                block = every[a.kind, b.kind].T
            elif b.kind < w:
                block = half[b.kind * nv : (b.kind + 1) * nv, s:].T
            elif a.kind < w:
                block = half[a.kind * nv : (a.kind + 1) * nv, s:]
            else:
                block = h[s:, s:]
            if a.order is not None:
                block = block[a.order]
            if b.order is not None:
                block = block[:, b.order]
            if a.sign is not None:
                block = block * a.sign[:, None]
            if b.sign is not None:
                block = block * b.sign
            into += block

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

    @cached_property
    def _transposed(self) -> Float[Array, "n_nodes w 3"]:
        return np.ascontiguousarray(self.basis.transpose(0, 2, 1))

    @cached_property
    def _band(self) -> Band:
        return Band(self.size, self.half_band, max(self.nv, self.nu))

    @cached_property
    def _blocks(self) -> list[list[tuple[Array, _Group, _Group]]]:
        """For every node the blocks of the band that its Hessian is added to."""
        found = []
        for k in range(self.n_nodes):
            pairs = product(self._groups(k), repeat=2)
            found.append([
                (self._band.block(a.start, b.start, (a.count, b.count)), a, b)
                for a, b in pairs
                if a.start >= b.start
            ])  # fmt: skip
        return found

    def _groups(self, k: int) -> list[_Group]:
        """Return the variables that a node touches, those side by side in the vector together."""
        found = []
        for kind, (at, sign) in enumerate(zip(self._columns[k], self._signs[k], strict=True)):
            order = np.argsort(at)
            turned = sign[order] if (sign < 0).any() else None
            in_order = bool((np.diff(order) == 1).all())
            found.append(_Group(kind, int(at.min()), len(at), None if in_order else order, turned))
        free = np.flatnonzero(self.variables.free[k])
        if len(free):
            order = None if len(free) == self.nu else free
            start = int(self.variables.u_at[k, free[0]])
            found.append(_Group(self.window.shape[1], start, len(free), order, None))
        return found


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

r"""A problem evaluated at a point, for any solver: values, derivatives, cost and worst row.

With the Jacobian :math:`J_k` of the rows of a node by its :math:`z_k` and multipliers
:math:`\lambda`, the Hessian for a solver is

.. math:: \sum_k T_k^\top \Big( \nabla_z^2 (\lambda_k^\top r_k) + J_k^\top D_k J_k \Big) T_k,

with :math:`T_k` of :mod:`~plantigrade.trajopt.transcription.linear_map` and weights :math:`D` of
rows: nothing but the rows themselves is ever differentiated.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.transcription.constraint_block import EVERY, ConstraintBlock
from plantigrade.trajopt.transcription.linear_map import Transcription

NODES_AT_ONCE = 64
"""Number of nodes whose second derivatives are evaluated at once [1]: as many as vectors of the
machine take, and all of a periodic walk."""


@dataclass(frozen=True)
class WorstRow:
    """The row that is violated most."""

    amount: float = 0.0  # by how much, in its own unit; 0 where every row is satisfied
    name: str = ""  # its name
    time: float = 0.0  # at which node [s]
    shown: str = ""  # the amount in the unit shown to people

    @property
    def place(self) -> str:
        """Its name and time."""
        return f"{self.name} at {self.time:.3f} s" if self.name else ""

    @property
    def sentence(self) -> str:
        """Its name, time and amount."""
        return f"{self.place} by {self.shown}" if self.name else ""


class Evaluation:
    """One problem at one point after the other; arrays are made once and used again.

    Attributes:
        t: Its linear maps.
        blocks: Its families, where they matter; those that matter nowhere are left out.
    """

    def __init__(self, problem: Problem, families: Sequence[ConstraintFamily] | None = None):
        self.problem = problem
        self.t = Transcription(problem)
        families = problem.rows if families is None else families
        blocks = [ConstraintBlock(rows, self.t.n_local) for rows in families]
        self.blocks = [block for block in blocks if len(block.at)]
        n = self.t.n_local
        self._memory = np.empty((min(NODES_AT_ONCE, self.t.n_nodes), n, n))  # of Hessians

    def values(self, x: Array) -> list[Array]:
        """Return the rows of every block."""
        z = self.t.local(x)
        return [b.derivatives.values(*self.states(b.pick(z)), b.parameters) for b in self.blocks]

    def linearise(self, x: Array) -> None:
        """Evaluate the rows of every block and their Jacobian, and keep them in the blocks."""
        z = self.t.local(x)
        for b in self.blocks:
            b.linearise(*self.states(b.pick(z)))

    def states(self, z: Array) -> tuple[Array, Array, Array, Array]:
        """Return q, qd, qdd and u of z."""
        n = self.t.nv
        return z[:, :n], z[:, n : 2 * n], z[:, 2 * n : 3 * n], z[:, 3 * n :]

    def pull_back(self, weights: Sequence[Array], *, equations: bool = False) -> Array:
        """Return the sum of J' w over blocks, by x; with ``equations`` J and w of these alone."""
        g = np.zeros((self.t.n_nodes, self.t.n_local))
        for b, w in zip(self.blocks, weights, strict=True):
            b.add_pulled(g, w, b.equation_rows if equations else EVERY)
        return self.t.gradient(g)

    def push_forward(self, dx: Array, *, equations: bool = False) -> list[Array]:
        """Return J dx of every block; with ``equations`` of these alone, and zero elsewhere."""
        dz = self.t.local_step(dx)
        return [b.pushed(dz, b.equation_rows if equations else EVERY) for b in self.blocks]

    def objective(self, x: Array, values: Sequence[Array]) -> float:
        """Return the cost of a point and its rows."""
        smooth, _ = self.t.smoothness(x)
        return smooth + sum(b.cost(r) for b, r in zip(self.blocks, values, strict=True))

    def objective_gradient(self, x: Array) -> Array:
        """Return the gradient of the cost at the point that was linearised last."""
        slopes = [b.cost_gradient(b.r) for b in self.blocks]
        return self.pull_back(slopes) + self.t.smoothness(x)[1]

    def hessians(
        self, x: Array, weights: Sequence[Array], multipliers: Sequence[Array] | None
    ) -> Iterator[tuple[slice, Array]]:
        """Yield the Hessian by z at the point linearised last, for :meth:`Transcription.assemble`.

        Weights are D and multipliers those of rows, by block; without them it is J' D J alone.
        """
        z = self.t.local(x)
        for first in range(0, self.t.n_nodes, NODES_AT_ONCE):
            stop = min(first + NODES_AT_ONCE, self.t.n_nodes)
            H = self._memory[: stop - first]
            H[:] = 0.0
            for i, (b, w) in enumerate(zip(self.blocks, weights, strict=True)):
                rows = slice(*np.searchsorted(b.at, (first, stop)))
                if rows.start == rows.stop:
                    continue
                at = b.at[rows]
                if multipliers is not None and not b.linear:
                    arguments = multipliers[i][rows], *self.states(z[at]), b.parameters[rows]
                    if len(at) == len(H):
                        b.derivatives.hessian(*arguments, onto=H)
                    else:
                        H[at - first] += b.derivatives.hessian(*arguments)
                b.add_squares(H, at - first, rows, w[rows])
            yield slice(first, stop), H

    def squared_violation(self, values: Sequence[Array]) -> float:
        """Return the sum of squared violations."""
        return sum(
            float(np.sum(b.violation(r) ** 2)) for b, r in zip(self.blocks, values, strict=True)
        )

    def worst(self, values: Sequence[Array]) -> WorstRow:
        """Return the row that is violated most."""
        found = WorstRow()
        for b, r in zip(self.blocks, values, strict=True):
            off = b.violation(r)
            k, i = np.unravel_index(int(np.argmax(off)), off.shape)
            if off[k, i] > found.amount:
                amount, name = float(off[k, i]), b.rows.names[int(i)]
                unit = b.rows.unit
                shown = f"{amount * b.rows.scale:.3g} {unit}" if unit else f"{amount:.3g}"
                found = WorstRow(amount, name, float(self.problem.nodes[b.at[k]]), shown)
        return found

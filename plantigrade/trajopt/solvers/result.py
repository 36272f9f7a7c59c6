"""Settings, iterations and results of the interior point."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion.filters import interpolate

Status = Literal["solved", "acceptable", "stopped", "paused", "stalled", "too many iterations"]


@dataclass(frozen=True)
class Options:
    r"""Settings of the solver; the defaults serve every task."""

    tolerance: float = 1e-3  #: Largest scaled error of the optimality conditions
    feasibility: float = 1e-6  #: Largest violation of a row, in its own unit (where 1 is large)
    #: Optimality error at which a feasible point is good enough once it stalls
    acceptable: float = 1e-1
    iterations: int = 150  #: Most iterations
    initial_barrier: float = 1e-3  #: First barrier parameter, at most: less near a solution
    constraint_regularisation: float = 1e-8  #: :math:`\delta_c`
    seconds: float = np.inf  #: Most time [s]


@dataclass(frozen=True)
class Iterate:
    """One iteration; fields that a solver does not report have defaults."""

    number: int  # counted from 0
    objective: float  # cost
    violation: float  # largest violation of a row, in its own unit
    worst: str = ""  # which row that is, and when
    optimality: float = np.nan  # scaled error of the optimality conditions
    barrier: float = np.nan  # its parameter μ
    regularisation: float = 0.0  # δ_w of the last step
    step: float = 1.0  # fraction of the last step that was taken
    seconds: float = np.nan  # time since the start [s]


@dataclass(frozen=True)
class Multipliers:
    """Lagrange multipliers of all constraints: a warm start for a similar problem."""

    #: Name of a family → multipliers of its rows, of their lower and of their upper limits (3,
    #: n_nodes, n_rows)
    rows: Mapping[str, Float[Array, "3 n_nodes n_rows"]]

    def moved(
        self, before: Float[Array, " n_nodes"], after: Float[Array, " m_nodes"]
    ) -> "Multipliers":
        """Return multipliers on other nodes, unchanged per unit of time.

        Args:
            before: Nodes these belong to [s].
            after: Times in that motion of the nodes of the new problem [s].
        """
        if len(before) == len(after) and np.allclose(before, after, atol=1e-9):
            return self
        spacing = (
            np.gradient(after)[:, None] / np.interp(after, before, np.gradient(before))[:, None]
        )
        return Multipliers(
            {
                name: np.stack([interpolate(after, before, x) * spacing for x in each])
                for name, each in self.rows.items()
            }
        )


@dataclass(frozen=True)
class SolverResult:
    """Where the solver ended."""

    c: Float[Array, "n_coefficients n_coordinates"]
    u: Float[Array, "n_nodes n_unknowns"]
    status: Status  # how it ended; ``"solved"`` and ``"acceptable"`` satisfy every row
    history: tuple[Iterate, ...]  # every iteration
    multipliers: Multipliers  # for a warm start

    @property
    def success(self) -> bool:
        """Whether every row is satisfied."""
        return self.status in ("solved", "acceptable")

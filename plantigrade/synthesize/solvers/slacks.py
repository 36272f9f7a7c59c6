r"""Slacks of inequalities and all multipliers of one block of constraints.

A row :math:`l \le c(x) \le h` becomes the equation :math:`c(x) - s = 0` with a slack strictly
inside its limits; :math:`y` is the multiplier of that equation (or of :math:`c(x) = l` where the
row is an equation), :math:`z_l` and :math:`z_h` are those of the slack's limits.
"""

import numpy as np

from plantigrade.arrays import Array
from plantigrade.synthesize.transcription.constraint_block import ConstraintBlock

CLEARANCE = 1e-15
"""Least distance of a slack from a limit, beside the limit's own size."""

REACH = 1e10
"""Factor within which multipliers stay of barrier parameter over distance."""


class Slacks:
    """Slacks and multipliers of one block; all arrays are (n_nodes, n_rows).

    Attributes:
        block: The constraints.
        has_low: Which rows are inequalities with a lower limit.
        has_high: Which have an upper limit.
        s: Slacks.
        y: Multipliers of the equations.
        zl: Multipliers of lower limits.
        zu: Multipliers of upper limits.
    """

    def __init__(self, block: ConstraintBlock):
        self.block = block
        self.has_low = block.inequalities & np.isfinite(block.lower)
        self.has_high = block.inequalities & np.isfinite(block.upper)
        self._low = np.where(self.has_low, block.lower, -1.0)
        self._high = np.where(self.has_high, block.upper, 1.0)
        self._aim = np.where(block.equations, block.lower, 0.0)
        shape = block.lower.shape
        self.s, self.y, self.zl, self.zu = (np.zeros(shape) for _ in range(4))

    def start(self, mu: float, margin: float, given: Array | None) -> None:
        """Set slacks near the rows, and multipliers to those given or to those of the barrier.

        Args:
            mu: Barrier parameter.
            margin: Distance from the limits at which slacks start.
            given: Multipliers of all nodes (3, n_nodes, n_rows); None for none.
        """
        b = self.block
        self.s = self.push_interior(b.r, margin)
        self.y, low, high = np.zeros((3, *b.lower.shape))
        if given is not None and given.shape[1:] == b.rows.lower.shape:
            self.y, low, high = (x[b.at] for x in given)
            self.y = np.where(b.bound, self.y, 0.0)
        above, below = self.room(self.s)
        self.zl = np.where(self.has_low, np.maximum(low, np.minimum(mu / above, 1.0)), 0.0)
        self.zu = np.where(self.has_high, np.maximum(high, np.minimum(mu / below, 1.0)), 0.0)

    def push_interior(self, r: Array, margin: float) -> Array:
        """Return slacks near rows, strictly inside their limits."""
        both = self.has_low & self.has_high
        width = np.where(both, self._high - self._low, np.inf)
        room_low = np.minimum(margin * np.maximum(1.0, np.abs(self._low)), margin * width)
        room_high = np.minimum(margin * np.maximum(1.0, np.abs(self._high)), margin * width)
        s = np.where(self.has_low, np.maximum(r, self._low + room_low), r)
        s = np.where(self.has_high, np.minimum(s, self._high - room_high), s)
        return np.where(self.block.inequalities, s, 0.0)

    def gap(self, r: Array, s: Array) -> Array:
        """Return the residuals of c_E = 0 and c_I = s."""
        b = self.block
        return np.where(b.equations, r - self._aim, np.where(b.inequalities, r - s, 0.0))

    def room(self, s: Array) -> tuple[Array, Array]:
        """Return the distances of slacks from their limits; 1 where there is no limit."""
        return (
            np.where(self.has_low, s - self._low, 1.0),
            np.where(self.has_high, self._high - s, 1.0),
        )

    def log_barrier(self, s: Array) -> float:
        """Return the sum of logarithms of all distances; -inf outside the limits."""
        above, below = self.room(s)
        if above.min() <= 0 or below.min() <= 0:
            return -np.inf
        return float(np.sum(np.log(above)) + np.sum(np.log(below)))

    def stiffness(self) -> Array:
        r"""Return :math:`\Sigma = z_l / (s - l) + z_h / (h - s)`."""
        above, below = self.room(self.s)
        return np.where(self.has_low, self.zl / above, 0.0) + np.where(
            self.has_high, self.zu / below, 0.0
        )

    def barrier_force(self, mu: float) -> Array:
        r"""Return the gradient of the barrier by the slacks, :math:`-\mu/(s-l) + \mu/(h-s)`."""
        above, below = self.room(self.s)
        return np.where(self.has_low, -mu / above, 0.0) + np.where(self.has_high, mu / below, 0.0)

    def multiplier_steps(self, ds: Array, mu: float) -> tuple[Array, Array]:
        """Return Newton's steps of the limits' multipliers for a step of the slacks."""
        above, below = self.room(self.s)
        return (
            np.where(self.has_low, mu / above - self.zl - self.zl / above * ds, 0.0),
            np.where(self.has_high, mu / below - self.zu + self.zu / below * ds, 0.0),
        )

    def largest_step(self, ds: Array, tau: float) -> float:
        """Return the fraction of a step of slacks that keeps to the rule of the boundary."""
        above, below = self.room(self.s)
        return min(
            fraction_to_boundary(above, ds, self.has_low, tau),
            fraction_to_boundary(below, -ds, self.has_high, tau),
        )

    def largest_dual_step(self, dzl: Array, dzu: Array, tau: float) -> float:
        """Return the same for steps of the limits' multipliers."""
        return min(
            fraction_to_boundary(np.where(self.has_low, self.zl, 1.0), dzl, self.has_low, tau),
            fraction_to_boundary(np.where(self.has_high, self.zu, 1.0), dzu, self.has_high, tau),
        )

    def move(self, s: Array, dy: Array, dzl: Array, dzu: Array, mu: float) -> None:
        """Take new slacks and steps of multipliers, both kept away from their limits."""
        s = np.where(
            self.has_low, np.maximum(s, self._low + CLEARANCE * (1 + np.abs(self._low))), s
        )
        self.s = np.where(
            self.has_high, np.minimum(s, self._high - CLEARANCE * (1 + np.abs(self._high))), s
        )
        self.y, zl, zu = self.y + dy, self.zl + dzl, self.zu + dzu
        above, below = self.room(self.s)
        self.zl = np.where(self.has_low, _within_reach(zl, mu, above), 0.0)
        self.zu = np.where(self.has_high, _within_reach(zu, mu, below), 0.0)

    def stationarity(self) -> float:
        """Return the largest gradient of the Lagrangian by a slack."""
        off = np.where(self.block.inequalities, -self.y - self.zl + self.zu, 0.0)
        return float(np.abs(off).max())

    def complementarity(self, mu: float) -> float:
        """Return by how much multiplier times distance differs most from mu."""
        above, below = self.room(self.s)
        return max(
            float(np.abs(np.where(self.has_low, self.zl * above - mu, 0.0)).max()),
            float(np.abs(np.where(self.has_high, self.zu * below - mu, 0.0)).max()),
        )

    def at_all_nodes(self) -> Array:
        """Return y, zl and zu (3, n_nodes, n_rows), zero where the block does not matter."""
        out = np.zeros((3, *self.block.rows.lower.shape))
        out[:, self.block.at] = self.y, self.zl, self.zu
        return out


def fraction_to_boundary(room: Array, step: Array, mask: Array, tau: float) -> float:
    """Return the largest fraction of a step that uses up no more than ``tau`` of the room."""
    shrinking = mask & (step < 0)
    if not shrinking.any():
        return 1.0
    return min(1.0, float(np.min(-tau * room[shrinking] / step[shrinking])))


def _within_reach(z: Array, mu: float, room: Array) -> Array:
    return np.clip(z, mu / (REACH * room), REACH * mu / room)

r"""Slacks of inequalities and all multipliers of one block of constraints.

A row :math:`l \le c(x) \le h` becomes the equation :math:`c(x) - s = 0` with a slack strictly
inside its limits; :math:`y` is the multiplier of that equation (or of :math:`c(x) = l` where the
row is an equation), :math:`z_l` and :math:`z_h` are those of the slack's limits.
"""

import numpy as np

from plantigrade.arrays import Array
from plantigrade.trajopt.transcription.constraint_block import ConstraintBlock

MIN_SLACK = 1e-15  #: Minimum distance of a slack from a limit, relative to the limit [1]
MAX_MULTIPLIER_RATIO = 1e10  #: Maximum ratio of a multiplier to barrier parameter over distance [1]
CENTRALITY_FACTOR = 10.0
"""Range of well-centred products of multiplier and distance [1], [Gondzio1996]_."""
_INWARDS = np.array([1.0, -1.0])[:, None, None]  # from lower and from upper limits


class Slacks:
    """Slacks and multipliers of one block.

    Attributes:
        block: The constraints.
        limited: Which rows are inequalities with a lower, with an upper limit (2, n_nodes, n_rows).
        s: Slacks (n_nodes, n_rows).
        y: Multipliers of the equations (n_nodes, n_rows).
        z: Multipliers of lower and of upper limits (2, n_nodes, n_rows).
    """

    def __init__(self, block: ConstraintBlock):
        self.block = block
        limits = np.stack([block.lower, block.upper])
        self.limited = block.inequalities & np.isfinite(limits)
        self._limits = np.where(self.limited, limits, -_INWARDS)
        self._aim = np.where(block.equations, block.lower, 0.0)
        shape = block.lower.shape
        self.s, self.y, self.z = np.zeros(shape), np.zeros(shape), np.zeros((2, *shape))

    def start(self, mu: float, margin: float, given: Array | None) -> None:
        """Set slacks near the rows, a margin inside their limits, and multipliers.

        These are the ones given, of all nodes (3, n_nodes, n_rows), or those of the barrier.
        """
        b = self.block
        self.s = self.push_interior(b.r, margin)
        known = np.zeros((3, *b.lower.shape))
        if given is not None and given.shape[1:] == b.rows.lower.shape:
            known = given[:, b.at]
        self.y = np.where(b.bound, known[0], 0.0)
        barrier = np.minimum(mu / self.room(self.s), 1.0)
        self.z = np.where(self.limited, np.maximum(known[1:], barrier), 0.0)

    def push_interior(self, r: Array, margin: float) -> Array:
        """Return slacks near rows, strictly inside their limits."""
        low, high = self._limits
        width = np.where(self.limited.all(axis=0), high - low, np.inf)
        room = np.minimum(margin * np.maximum(1.0, np.abs(self._limits)), margin * width)
        return np.where(self.block.inequalities, self._kept_inside(r, room), 0.0)

    def _kept_inside(self, s: Array, room: Array) -> Array:
        """Return slacks moved to where there is so much room."""
        low, high = self._limits + _INWARDS * room
        s = np.where(self.limited[0], np.maximum(s, low), s)
        return np.where(self.limited[1], np.minimum(s, high), s)

    def gap(self, r: Array, s: Array) -> Array:
        """Return the residuals of c_E = 0 and c_I = s."""
        b = self.block
        return np.where(b.equations, r - self._aim, np.where(b.inequalities, r - s, 0.0))

    def room(self, s: Array) -> Array:
        """Return the distances of slacks from their limits; 1 where there is no limit."""
        return np.where(self.limited, _INWARDS * (s - self._limits), 1.0)

    def log_barrier(self, s: Array) -> float:
        """Return the sum of logarithms of all distances; -inf outside the limits."""
        room = self.room(s)
        return float(np.sum(np.log(room))) if room.min() > 0 else -np.inf

    def stiffness(self) -> Array:
        r"""Return :math:`\Sigma = z_l / (s - l) + z_h / (h - s)`."""
        return np.where(self.limited, self.z / self.room(self.s), 0.0).sum(axis=0)

    def barrier_force(self, mu: float | Array) -> Array:
        r"""Return the gradient of the barrier by the slacks, :math:`-\mu/(s-l) + \mu/(h-s)`."""
        return np.where(self.limited, -_INWARDS * mu / self.room(self.s), 0.0).sum(axis=0)

    def multiplier_steps(self, ds: Array, mu: float) -> Array:
        """Return Newton's steps of the limits' multipliers for a step of the slacks."""
        return self.changed_steps(ds, mu) - self.z

    def changed_steps(self, ds: Array, change: float | Array) -> Array:
        """Return how these steps change with the step of the slacks and what products shall be."""
        return np.where(self.limited, (change - _INWARDS * self.z * ds) / self.room(self.s), 0.0)

    def off_centre(self, ds: Array, dz: Array, alpha: float, alpha_dual: float, mu: float) -> Array:
        """Return by how much products of multiplier and distance, so far along, are too far off."""
        product = (self.room(self.s) + alpha * _INWARDS * ds) * (self.z + alpha_dual * dz)
        off = np.clip(product, mu / CENTRALITY_FACTOR, CENTRALITY_FACTOR * mu) - product
        return np.where(self.limited, np.maximum(off, -CENTRALITY_FACTOR * mu), 0.0)

    def largest_step(self, ds: Array, tau: float) -> float:
        """Return the fraction of a step of slacks that keeps to the rule of the boundary."""
        return fraction_to_boundary(self.room(self.s), _INWARDS * ds, self.limited, tau)

    def largest_dual_step(self, dz: Array, tau: float) -> float:
        """Return the same for a step of the limits' multipliers."""
        return fraction_to_boundary(self.z, dz, self.limited, tau)

    def move(self, s: Array, dy: Array, dz: Array, mu: float) -> None:
        """Take new slacks and steps of multipliers, both kept away from their limits."""
        self.s = self._kept_inside(s, MIN_SLACK * (1 + np.abs(self._limits)))
        self.y, near = self.y + dy, mu / self.room(self.s)
        self.z = np.where(
            self.limited,
            np.clip(self.z + dz, near / MAX_MULTIPLIER_RATIO, MAX_MULTIPLIER_RATIO * near),
            0.0,
        )

    def stationarity(self) -> float:
        """Return the largest gradient of the Lagrangian by a slack."""
        off = np.where(self.block.inequalities, -self.y - self.z[0] + self.z[1], 0.0)
        return float(np.abs(off).max())

    def complementarity(self, mu: float) -> float:
        """Return by how much multiplier times distance differs most from mu."""
        off = np.where(self.limited, self.z * self.room(self.s) - mu, 0.0)
        return float(np.abs(off).max())

    def at_all_nodes(self) -> Array:
        """Return y, zl and zu (3, n_nodes, n_rows), zero where the block does not matter."""
        out = np.zeros((3, *self.block.rows.lower.shape))
        out[:, self.block.at] = self.y, *self.z
        return out


def fraction_to_boundary(room: Array, step: Array, mask: Array, tau: float) -> float:
    """Return the largest fraction of a step that uses up no more than ``tau`` of the room."""
    shrinking = mask & (step < 0)
    if not shrinking.any():
        return 1.0
    return min(1.0, float(np.min(-tau * room[shrinking] / step[shrinking])))

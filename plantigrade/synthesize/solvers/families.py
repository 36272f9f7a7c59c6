"""Rows of one kind at the nodes where they matter: derivatives, limits, slacks, multipliers."""

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from plantigrade.arrays import Array
from plantigrade.synthesize.problem.nlp import ConstraintFamily, Problem
from plantigrade.synthesize.transcription.derivatives import derivatives_of

if TYPE_CHECKING:
    import casadi

CLEAR = 1e-15
"""Room that a slack keeps to a limit at least, beside the limit's own size."""


class Family:
    """Rows of one kind, with derivatives, masks and slacks, at the nodes where they matter."""

    def __init__(self, rows: ConstraintFamily, n_local: int):
        self.rows = rows
        self.d = derivatives_of(rows.function)
        eq, ineq = rows.equations, rows.inequalities
        matter = eq | ineq | (rows.weight != 0) | (rows.gain != 0)
        self.at = np.flatnonzero(matter.any(axis=1))
        self.everywhere = len(self.at) == len(matter)
        self.parameters = rows.parameters[self.at]
        self.lower, self.upper = rows.lower[self.at], rows.upper[self.at]
        self.weight, self.target = rows.weight[self.at], rows.target[self.at]
        self.gain = rows.gain[self.at]
        self.eq, self.ineq = eq[self.at], ineq[self.at]
        self.bound = self.eq | self.ineq
        jr, jc = self.d.jacobian_pattern
        self.linear = len(self.d.hessian_pattern[0]) == 0
        per_row = np.bincount(jr, minlength=len(rows.names)) if len(jr) else np.zeros(1)
        self.single = self.linear and per_row.max() <= 1
        columns = np.unique(jc) if len(jc) else np.zeros(1, int)
        self.columns = slice(int(columns[0]), int(columns[-1]) + 1)  # a slice is worth its zeros
        self.has_low = self.ineq & np.isfinite(self.lower)
        self.has_high = self.ineq & np.isfinite(self.upper)
        self.low = np.where(self.has_low, self.lower, -1.0)
        self.high = np.where(self.has_high, self.upper, 1.0)
        self.aim = np.where(self.eq, self.lower, 0.0)
        self.costs = bool(np.any(self.weight) or np.any(self.gain))
        shape = self.lower.shape
        self.J = np.zeros((0, 0, 0))  # until it is evaluated
        self.whole = np.zeros((len(self.at), len(rows.names), n_local))
        self.only = np.zeros(shape, int), np.zeros(shape)  # of a single row: column in J, value
        self.r, self.s, self.y = np.zeros(shape), np.zeros(shape), np.zeros(shape)
        self.zl, self.zu = np.zeros(shape), np.zeros(shape)

    def pick(self, z: Array) -> Array:
        """Return what is at the nodes that matter."""
        return z if self.everywhere else z[self.at]

    def cost(self, r: Array) -> float:
        """Return what rows cost."""
        if not self.costs:
            return 0.0
        away = r - self.target
        return float(np.sum(self.gain * r) + 0.5 * np.sum(self.weight * away * away))

    def push(self, r: Array) -> Array:
        """Return the derivative of the cost by the rows."""
        return self.gain + self.weight * (r - self.target)

    def gap(self, r: Array, s: Array) -> Array:
        """Return what is missing to c_E = 0 and c_I = s."""
        return np.where(self.eq, r - self.aim, np.where(self.ineq, r - s, 0.0))

    def room(self, s: Array) -> tuple[Array, Array]:
        """Return the distance of slacks to their limits; 1 where there is none."""
        return (
            np.where(self.has_low, s - self.low, 1.0),
            np.where(self.has_high, self.high - s, 1.0),
        )

    def clear(self, s: Array) -> Array:
        """Return slacks that rounding has not put onto their limits."""
        s = np.where(self.has_low, np.maximum(s, self.low + CLEAR * (1 + np.abs(self.low))), s)
        return np.where(
            self.has_high, np.minimum(s, self.high - CLEAR * (1 + np.abs(self.high))), s
        )

    def violation(self, r: Array) -> Array:
        """Return how far rows lie outside their limits; infinitely far if they are no numbers."""
        off = np.maximum(np.maximum(self.lower - r, r - self.upper), 0.0)
        return np.where(np.isnan(r), np.inf, off)


def inside(f: Family, r: Array, margin: float) -> Array:
    """Return slacks near rows, inside their limits."""
    both = f.has_low & f.has_high
    width = np.where(both, f.high - f.low, np.inf)
    room_low = np.minimum(margin * np.maximum(1.0, np.abs(f.low)), margin * width)
    room_high = np.minimum(margin * np.maximum(1.0, np.abs(f.high)), margin * width)
    s = np.where(f.has_low, np.maximum(r, f.low + room_low), r)
    s = np.where(f.has_high, np.minimum(s, f.high - room_high), s)
    return np.where(f.ineq, s, 0.0)


def most(room: Array, step: Array, mask: Array, tau: float) -> float:
    """Return how much of a step leaves part 1 - tau of the room."""
    shrink = mask & (step < 0)
    if not shrink.any():
        return 1.0
    return min(1.0, float(np.min(-tau * room[shrink] / step[shrink])))


def limits_of_unknowns(problem: Problem) -> ConstraintFamily | None:
    """Return the limits of node unknowns as rows."""
    if not problem.n_unknowns:
        return None
    nv, n = len(problem.names), len(problem.nodes)
    function = _unknowns(nv, problem.n_unknowns)
    rows = ConstraintFamily.free("limits of unknowns", function, problem.u_names, n)
    active = problem.u_active
    rows.lower[active] = problem.u_lower[active]
    rows.upper[active] = problem.u_upper[active]
    return rows


@cache
def _unknowns(nv: int, nu: int) -> "casadi.Function":
    """Return the function of a node that is its unknowns."""
    import casadi as ca

    q, v, a = (ca.SX.sym(x, nv) for x in ("q", "qd", "qdd"))
    u, p = ca.SX.sym("u", nu), ca.SX.sym("p", 0)
    return ca.Function("unknowns", [q, v, a, u, p], [u])

r"""Torques that stop at their limits.

A torque at its limit moves joint accelerations off those that are best for the shares: by
:math:`A_T^T \nu`, with :math:`A_T` the row of this torque in the metric of the cost. That it gives
just its limit is one more cost of the shares (:meth:`ShareProgram.and_rows`). Which torques are at
a limit is found as in :mod:`plantigrade.wbc.shares`, by exchanges from those of the call before:
one beyond its limit is held at it, one whose :math:`\nu` pulls beyond the limit is let go. Where
this goes in circles, and where shares are few, DAQP solves it ([Arnstrom2022]_).
"""

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.wbc.reduced import Reduced
from plantigrade.wbc.shares import (
    ACTIVE_LOWER_BOUND,
    MAX_DAQP_SIZE,
    ZERO_SHARE,
    ShareProgram,
    ShareSolver,
)

LIMIT_TOLERANCE = 1e-6
"""Tolerance of a limit, as a part of the limits' range."""
MAX_EXCHANGES = 8  # [1] limit of changes of the set of torques at their limits
PULL_TOLERANCE = 1e-9  # [1] multiplier below which a limit no longer holds
MAX_ROUNDS = 8
"""Greatest number of further calls of DAQP, with torques that have passed their limits since."""
_SENSE = np.array([0, 1, ACTIVE_LOWER_BOUND])
"""Its words for what is not at a limit, at the upper one, and (the last) at the lower one."""


class TorqueLimits:
    """Solves programs whose torques have limits, each from where the last one ended.

    Args:
        low: Least torque of each hinge [N m].
        high: Greatest.

    Attributes:
        at: 1 for torques at the upper limit, -1 at the lower one, 0 for others.
    """

    def __init__(self, low: Float[Array, " n"], high: Float[Array, " n"]):
        self.set(low, high)
        self.at: Int[Array, " n"] = np.zeros(len(low), dtype=int)
        self._shares = ShareSolver()

    def set(self, low: Float[Array, " n"], high: Float[Array, " n"]) -> None:
        """Let other limits hold [N m]."""
        self.low, self.high = low, high
        slack = LIMIT_TOLERANCE * (high - low)
        self._least, self._most = low - slack, high + slack

    def solve(
        self, reduced: Reduced, program: ShareProgram
    ) -> tuple[Float[Array, " m"], Float[Array, " nv"], Float[Array, " n"], str]:
        """Return shares, accelerations, torques, and ``"ok"`` or why they are none."""
        at, few = self.at, len(program.q) <= MAX_DAQP_SIZE
        for _ in range(MAX_EXCHANGES):
            which = at.nonzero()[0]
            if few and len(which):
                break
            if len(which):
                share, along, pull, done = self._held(reduced, program, which, at)
            else:
                (share, _, done), along, pull = self._shares.solve(program), 0.0, None
            if not done:
                break
            qacc, tau = reduced.accelerations(share, along)
            new = (tau > self._most).astype(int) - (tau < self._least)
            new[which] = at[which]
            if pull is not None:
                new[which[pull * at[which] > PULL_TOLERANCE]] = 0
            if (new == at).all():
                self.at = at
                return share, qacc, tau, "ok"
            at = new
        share, along, status = self._by_daqp(reduced, program, at)
        return share, *reduced.accelerations(share, along), status

    def _held(self, reduced: Reduced, program: ShareProgram, which: Array, at: Array):
        """Return the answer with some torques at their limits, and how these pull."""
        held, rows, still = reduced.torques(which)
        room = np.where(at > 0, self.high, self.low)[which] - still
        share, price, done = self._shares.solve(program.and_rows(rows, held.T @ held, room))
        pull = -price[-len(which) :]
        return share, held @ pull, pull, done

    def _by_daqp(self, reduced: Reduced, program: ShareProgram, guess: Array):
        r"""Return what DAQP finds: shares, accelerations along the joints, and its word.

        Torques that are at their limits in the guess have rows.

        It minimises :math:`u^T u + \lambda^T Q \lambda + 2 q^T \lambda`. Only limits that were
        passed get rows, until none is; :math:`u` has no part across their rows.
        """
        import daqp

        free, limited, at = self._shares.free, guess != 0, guess.copy()
        m, Q = len(program.q), program.hessian()
        share, along = np.zeros(m), np.zeros(len(limited))
        status = "not solved: torques pass their limits in turn"
        for _ in range(MAX_ROUNDS):
            which = limited.nonzero()[0]
            held, rows, still = reduced.torques(which)
            span, corner = np.linalg.qr(held)
            k = span.shape[1]
            H, A = np.eye(k + m), np.hstack([corner.T, rows])
            H[k:, k:] = Q
            wide = np.full(k, 1e30)
            upper = np.concatenate([wide, np.full(m, 1e30), self.high[which] - still])
            lower = np.concatenate([-wide, np.zeros(m), self.low[which] - still])
            sense = np.zeros(len(upper), dtype=np.int32)
            if len(free) == m:
                sense[k : k + m][~free] = ACTIVE_LOWER_BOUND
            sense[k + m :] = _SENSE[at[which]]
            x, _, flag, info = daqp.solve(H, np.r_[np.zeros(k), program.q], A, upper, lower, sense)
            if flag < 1 or not np.isfinite(x).all():
                status = f"not solved (DAQP says {flag})"
                break
            share, along = np.where(x[k:] > ZERO_SHARE, x[k:], 0.0), span @ x[:k]
            self._shares.free = free = share > 0.0
            at[:] = 0
            at[which] = np.sign(np.asarray(info["lam"])[k + m :])
            _, tau = reduced.accelerations(share, along)
            more = ((tau > self._most) | (tau < self._least)) & ~limited
            if not more.any():
                status = "ok"
                break
            limited = limited | more
        self.at = at
        return share, along, status

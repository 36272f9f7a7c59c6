r"""Shares of pyramid edges that are not negative, at the least cost.

.. math:: \min_{\lambda \ge 0} \; \tfrac12 (K \lambda - u)^T S (K \lambda - u)
    + \tfrac12 \lambda^T D \lambda + q^T \lambda

with a diagonal :math:`D`: shares do nothing but by what they carry, :math:`K \lambda`, which is
short: one wrench for each body that touches, or that of the root alone. Given its price
:math:`p = S (K \lambda - u)`, the shares are

.. math:: \lambda(p) = \max(0, -D^{-1} (q + K^T p)) ,

and :math:`p` is where the convex function
:math:`\tfrac12 p^T S^{-1} p + u^T p + \tfrac12 \lambda(p)^T D \lambda(p)` has its minimum. It is
quadratic as long as no share becomes zero or ceases to be, so Newton's method ends after a few
steps, after one where the shares that are zero are those of the call before; a step that would go
too far stops at the minimum on its way, which lets it go in no circles (semismooth Newton,
[QiSun1993]_).

With few shares DAQP [Arnstrom2022]_ is faster, starting from those
that were not zero before.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.linalg import get_lapack_funcs

from plantigrade.arrays import Array, Bool, Float

(gesv,) = get_lapack_funcs(("gesv",), dtype=np.float64)

MAX_NEWTON_STEPS = 40  # Newton steps, at most
MAX_DAQP_SIZE = 64  # Number of shares up to which DAQP is faster
ACTIVE_LOWER_BOUND = 3  # DAQP's code of a bound that is active at the lower end
ZERO_SHARE = 1e-7
"""Share below which it is zero: internal forces hardly cost anything, and are known no better."""


@lru_cache(maxsize=128)
def _one(n: int) -> Float[Array, "n n"]:
    one = np.eye(n)
    one.flags.writeable = False
    return one


@dataclass(frozen=True, eq=False)
class ShareProgram:
    r"""The cost of shares."""

    K: Float[Array, "c m"]  #: Map from shares to what they carry
    S: Float[Array, "c c"]  #: Hessian of the cost of that, times ``E``
    E: Float[Array, "c c"]  #: Its divisor: of something very stiff the inverse is known better
    u: Float[Array, " c"]  #: Load of least cost
    diagonal: Float[Array, " m"]  #: Hessian of their own cost
    q: Float[Array, " m"]  #: Slope of that where all are zero

    @classmethod
    def of(
        cls,
        K: Float[Array, "c m"],
        S: Float[Array, "c c"],
        diagonal: Float[Array, " m"],
        q: Float[Array, " m"],
    ) -> "ShareProgram":
        """Return the program whose shares would best carry nothing."""
        return cls(K, S, _one(len(S)), np.zeros(len(S)), diagonal, q)

    def and_rows(
        self, rows: Float[Array, "k m"], give: Float[Array, "k k"], desired: Float[Array, " k"]
    ) -> "ShareProgram":
        """Return the program that also has a cost of some rows of shares."""
        c, k = len(self.K), len(rows)
        S, E = _one(c + k).copy(), np.zeros((c + k, c + k))
        S[:c, :c], E[:c, :c], E[c:, c:] = self.S, self.E, give
        K, u = np.concatenate([self.K, rows]), np.concatenate([self.u, desired])
        return ShareProgram(K, S, E, u, self.diagonal, self.q)

    @property
    def plain(self) -> bool:
        """Whether only the load costs, and nothing very stiffly."""
        return self.E is _one(len(self.S))

    def hessian(self) -> Float[Array, "m m"]:
        """Return the Hessian of the cost of shares, of a plain program."""
        H = self.K.T @ (self.S @ self.K)
        H.reshape(-1)[:: len(H) + 1] += self.diagonal
        return H

    def price(self, free: Bool[Array, " m"]) -> Float[Array, " c"]:
        """Return the price of what is carried at the minimum, all shares but some being zero."""
        over = self.K * (free / self.diagonal)
        A = (over @ self.K.T) @ self.S
        A += self.E
        _, _, carried, info = gesv(A, over @ -self.q - self.u, overwrite_a=True, overwrite_b=True)
        if info:
            raise np.linalg.LinAlgError
        return self.S @ carried

    def shares(self, price: Float[Array, " c"]) -> Float[Array, " m"]:
        """Return the best shares at a price; negative where they are to be zero."""
        return (price @ self.K + self.q) / -self.diagonal


class ShareSolver:
    """Minimises over shares that are not negative, each time from where it was the last time.

    Attributes:
        free: Shares that were not zero; empty where that is not known.
    """

    def __init__(self):
        self.free: Array = np.zeros(0, dtype=bool)

    def solve(self, program: ShareProgram) -> tuple[Float[Array, " m"], Float[Array, " c"], bool]:
        """Return the best shares, the price of what they carry, and whether they were found."""
        m = len(program.q)
        free = self.free if len(self.free) == m else np.ones(m, dtype=bool)
        if not m:
            return np.zeros(0), program.price(free) if len(program.K) else np.zeros(0), True
        self.free = np.zeros(0, dtype=bool)
        share, at, target = np.zeros(m), None, np.zeros(len(program.K))
        if m <= MAX_DAQP_SIZE and program.plain:
            return self._by_daqp(program, free)
        for _ in range(MAX_NEWTON_STEPS):
            try:
                target = program.price(free)
            except np.linalg.LinAlgError:
                break
            share = program.shares(target)
            now = share > 0.0
            if (np.abs(share[now != free]) <= ZERO_SHARE).all():
                self.free = free
                share[~(free & now)] = 0.0
                return share, target, True
            carried = program.K @ (share * free)
            if at is None:
                at = target, carried
            else:
                (price, before), step = at, target - at[0]
                part = _part(program, price, step, before, carried - before)
                at = price + part * step, before + part * (carried - before)
                if part < 1.0:
                    now = program.shares(at[0]) > 0.0
            free = now
        return np.maximum(share, 0.0), target, False

    def _by_daqp(
        self, program: ShareProgram, free: Bool[Array, " m"]
    ) -> tuple[Float[Array, " m"], Float[Array, " c"], bool]:
        """Return what DAQP finds for a plain program."""
        import daqp

        m = len(free)
        sense = np.where(free, 0, ACTIVE_LOWER_BOUND).astype(np.int32)
        share, _, flag, _ = daqp.solve(
            program.hessian(), program.q, np.zeros((0, m)), np.full(m, 1e30), np.zeros(m), sense
        )
        found = flag == 1 and bool(np.isfinite(share).all())
        share = np.where(share > ZERO_SHARE, share, 0.0) if found else np.zeros(m)
        if found:
            self.free = share > 0.0
        return share, program.S @ (program.K @ share), found


def _part(
    program: ShareProgram,
    price: Float[Array, " c"],
    step: Float[Array, " c"],
    carried: Float[Array, " c"],
    more: Float[Array, " c"],
) -> float:
    """Return which part of a step leads to the least cost; 1 where that is farther away.

    The slope along the step is made of straight pieces that end where shares begin or cease to be.
    """
    a, b = program.q + price @ program.K, step @ program.K
    start, rise, each = float(step @ carried), float(step @ more), b / program.diagonal

    def slope(t: Array) -> Array:
        return start + t * rise + np.minimum(a + t[:, None] * b, 0.0) @ each

    whole = slope(np.ones(1))[0]
    if not np.isfinite(whole) or whole <= 0.0:
        return 1.0
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = -a / b
    t = np.sort(np.concatenate([[0.0], ends[(ends > 0.0) & (ends < 1.0)], [1.0]]))
    steep = slope(t)
    steep[-1] = whole
    i = max(int(np.searchsorted(steep > 0.0, True)), 1)
    low, high = steep[i - 1], steep[i]
    return float(t[i - 1] - low * (t[i] - t[i - 1]) / max(high - low, 1e-300))

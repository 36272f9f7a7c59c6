r"""One program for the whole body: accelerations and contact forces that serve all tasks at once.

.. math:: \min_{\dot v, \lambda, \tau} \sum_i w_i \| A_i \dot v - b_i \|^2
    + w_\lambda \| \lambda - \bar\lambda \|^2 + \sum_j w_j (\tau_j - \bar\tau_j)^2

so that the equations of motion hold, :math:`\lambda \ge 0` along the edges of the friction pyramid
of every point that touches, and every torque stays within the strength of its joint. Weights, not
ranks: where tasks disagree each gives way a little, which is what balance needs (Eq. 7 of
[Park2020]_ is such a sum); strict orders are in :mod:`plantigrade.wbc.hierarchy`.

The unknowns are those of :mod:`plantigrade.wbc.forces`: joint accelerations and shares
:math:`\lambda` of pyramid edges. (With the accelerations eliminated by the inverse of the mass
matrix instead, light toes make the program so badly conditioned that solvers fail.) Without torque
limits joint accelerations are free, so they are eliminated from the optimality conditions by one
Cholesky decomposition. What is left is a least-squares problem in :math:`\lambda \ge 0`, solved by
principal pivoting from the active set of the call before ([Portugal1994]_): two or three
decompositions of a matrix as large as there are edges. Where a torque of that answer is beyond its
limit, the whole program goes to DAQP ([Arnstrom2022]_).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

import numpy as np
from scipy.linalg import get_lapack_funcs

from plantigrade.arrays import Array, Float, Int
from plantigrade.constants import FRICTION, GRAVITY
from plantigrade.kinematics.state import State
from plantigrade.models import Human

potrf, potrs, trtrs = get_lapack_funcs(("potrf", "potrs", "trtrs"), dtype=np.float64)

EDGES = 4
"""Edges of a friction pyramid."""
UNIT = 0.1
"""Body weights per unit of a share: of the size of joint accelerations."""
PIVOTS = 20
"""Exchanges of the active set, at most, before DAQP is asked."""
ZERO = 1e-9
"""A share, or its derivative of the cost, that is zero."""
OVER = 1e-6
"""Torque beyond its limit that is none, as a part of the limits' range."""
ROUNDS = 8
"""So often, at most, DAQP is asked again with torques that have passed their limits meanwhile."""
WARM = 3
"""DAQP's word for a bound that is active at the lower end."""
_SIX = np.eye(6)
_CORNER = 2 * np.pi * (np.arange(EDGES) + 0.5) / EDGES


@dataclass(frozen=True, eq=False)
class Rows:
    r"""What a task asks of the generalised acceleration: :math:`A \dot v = b`, as far as it can.

    Attributes:
        matrix: :math:`A`.
        right: :math:`b`.
        weight: Cost of a squared unit of what is missed, of each row or of all.
    """

    matrix: Float[Array, "n_rows nv"]
    right: Float[Array, " n_rows"]
    weight: float | Float[Array, " n_rows"] = 1.0


def _no_places() -> Array:
    return np.zeros((0, 3))


@dataclass(frozen=True, eq=False)
class Touching:
    """Where the body touches.

    Attributes:
        body: Index of the body of each point.
        place: Where it is, world [m].
        normal: Direction in which the ground pushes there, world.
        friction: Coefficient of friction.
    """

    body: Int[Array, " k"] = field(default_factory=lambda: np.zeros(0, dtype=int))
    place: Float[Array, "k 3"] = field(default_factory=_no_places)
    normal: Float[Array, "k 3"] = field(default_factory=_no_places)
    friction: float = FRICTION

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.body)

    def edges(self) -> Float[Array, "k 3 n_edges"]:
        """Return the edges of the friction pyramids: one part along the normal."""
        n = self.normal
        # Of any normal, two directions across it (Duff et al., 2017).
        sign = np.where(n[:, 2] < 0, -1.0, 1.0)
        p = -1.0 / (sign + n[:, 2])
        q = n[:, 0] * n[:, 1] * p
        side = np.stack([1.0 + sign * n[:, 0] ** 2 * p, sign * q, -sign * n[:, 0]], axis=1)
        other = np.stack([q, sign + n[:, 1] ** 2 * p, -n[:, 1]], axis=1)
        around = side[:, :, None] * np.cos(_CORNER) + other[:, :, None] * np.sin(_CORNER)
        return n[:, :, None] + self.friction * around


@runtime_checkable
class _Shares(Protocol):
    """The Hessian of the cost of shares, joint accelerations following."""

    def best(self, free: Array, q: Array) -> Array:
        """Return the minimum where only some shares are not zero."""
        ...

    def slope(self, share: Array) -> Array:
        """Return the Hessian times shares."""
        ...

    def matrix(self) -> Array:
        """Return the Hessian."""
        ...


class _Dense:
    """Any Hessian."""

    def __init__(self, Q: Array):
        self.Q = Q

    def best(self, free: Array, q: Array) -> Array:
        share = np.zeros(len(q))
        if len(free):
            factor, info = potrf(self.Q[np.ix_(free, free)], lower=True)
            if info:
                raise np.linalg.LinAlgError
            share[free] = potrs(factor, -q[free], lower=True)[0]
        return share

    def slope(self, share: Array) -> Array:
        return self.Q @ share

    def matrix(self) -> Array:
        return self.Q


class _Joined:
    r"""A Hessian :math:`K^T S K + D`: shares move nothing but the root.

    With :math:`u = K \lambda`, the minimum is
    :math:`\lambda = -D^{-1} (q + K^T S u)`, :math:`(1 + K D^{-1} K^T S) u = -K D^{-1} q`.
    """

    def __init__(self, K: Array, S: Array, diagonal: Array):
        self.K, self.S, self.diagonal = K, S, diagonal
        self.over = K / diagonal

    def best(self, free: Array, q: Array) -> Array:
        share = np.zeros(len(q))
        K, over, S = self.K[:, free], self.over[:, free], self.S
        u = np.linalg.solve(_SIX + over @ K.T @ S, -(over @ q[free]))
        share[free] = -(q[free] + K.T @ (S @ u)) / self.diagonal[free]
        return share

    def slope(self, share: Array) -> Array:
        return self.K.T @ (self.S @ (self.K @ share)) + self.diagonal * share

    def matrix(self) -> Array:
        return self.K.T @ self.S @ self.K + np.diag(self.diagonal)


@dataclass(frozen=True, eq=False)
class Answer:
    """The answer of a whole-body program.

    Attributes:
        qacc: Generalised acceleration.
        torque: What the motors of the hinges give [N m].
        force: Force of the ground at each point, world [N].
        share: The same along the edges of its pyramid, in the units of the program.
        status: ``"ok"``, or why the answer is none.
        limited: Number of torques at their limit.
    """

    qacc: Float[Array, " nv"]
    torque: Float[Array, " n_hinges"]
    force: Float[Array, "k 3"]
    share: Float[Array, "k n_edges"]
    status: str = "ok"
    limited: int = 0

    @property
    def ok(self) -> bool:
        """Whether there is an answer."""
        return self.status == "ok"


class WholeBody:
    r"""The whole-body program of a person, to be solved at every tick.

    Args:
        human: The person.
        armature: What the plant adds to the inertia of each hinge [kg m²].
        limits: Least and greatest torque of each hinge [N m]; the person's if absent.

    Example:
        >>> import numpy as np
        >>> human = Human.create()
        >>> program = WholeBody(human)
        >>> state = State(human, human.standing())
        >>> flight = program.solve(state, Touching(), wanted=np.zeros(human.model.nv))
        >>> bool(np.allclose(flight.qacc[:3], [0.0, 0.0, -9.80665], atol=0.02))
        True
    """

    def __init__(
        self,
        human: Human,
        *,
        armature: float | Float[Array, " n_hinges"] = 0.0,
        limits: Float[Array, "2 n_hinges"] | None = None,
    ):
        self.human, n = human, len(human.coordinates)
        self.armature = np.broadcast_to(np.asarray(armature, dtype=float), (n,))
        own = np.array(human.model.jnt_actfrcrange[1:]).T
        self.low, self.high = own if limits is None else np.asarray(limits, dtype=float)
        self.unit = UNIT * human.mass * GRAVITY
        self._zero = np.zeros(0, dtype=bool)  # shares that were zero
        self._stopped = np.zeros(n, dtype=bool)  # torques that were at a limit

    def solve(
        self,
        state: State,
        touching: Touching,
        tasks: Sequence[Rows] = (),
        *,
        wanted: Float[Array, " nv"],
        weight: float | Float[Array, " nv"] = 1.0,
        force: Float[Array, "k 3"] | None = None,
        force_weight: float | Float[Array, " k"] = 1e-3,
        torque: Float[Array, " n_hinges"] | None = None,
        torque_weight: float | Float[Array, " n_hinges"] = 0.0,
        passive: float | Float[Array, " n_hinges"] = 0.0,
        jacobian: Float[Array, "k 3 nv"] | None = None,
    ) -> Answer:
        r"""Return the accelerations, torques and forces that serve all tasks best.

        Args:
            state: The state of the body.
            touching: Where it touches.
            tasks: What is asked of the generalised acceleration.
            wanted: The generalised acceleration that is wanted, coordinate by coordinate.
            weight: Cost of a squared unit missed of it, positive for joints; also keeps the program
                well posed.
            force: Force wanted at each point [N]; none if absent.
            force_weight: Cost of a share [0.1 body weights], squared, off what is wanted; positive.
            torque: Torque wanted of the motors [N m]; zero if absent.
            torque_weight: Cost of a squared newton metre off it.
            passive: What the joints give by themselves [N m].
            jacobian: Jacobian of the points, where the caller has it.
        """
        M, h = state.mass_matrix, state.bias
        n, k = len(h) - 6, len(touching)
        Mjj = M[6:, 6:].copy()
        Mjj[np.arange(n), np.arange(n)] += self.armature
        edges = self.unit * touching.edges()
        J = state.touched(touching.body, touching.place)[0] if jacobian is None else jacobian
        G = np.matmul(J.transpose(0, 2, 1), edges).transpose(1, 0, 2).reshape(n + 6, -1)
        m = G.shape[1]
        # The root's acceleration is root @ joints + lift @ shares + drop.
        solved = np.linalg.solve(M[:6, :6], np.hstack([-M[:6, 6:], G[:6], -h[:6, None]]))
        root, lift, drop = solved[:, :n], solved[:, n : n + m], solved[:, -1]
        H, g = self._cost(tasks, wanted, weight)
        start = H[:, :6] @ drop - g
        across = H[:6, 6:] + H[:6, :6] @ root
        A = H[6:, 6:] + root.T @ across + H[6:, :6] @ root
        a, c = root.T @ start[:6] + start[6:], lift.T @ start[:6]
        own = np.repeat(np.broadcast_to(np.asarray(force_weight, dtype=float), (k,)), EDGES)
        if force is not None:
            c -= own * self._shares(touching, edges, force).ravel()
        by_joints = Mjj + M[6:, :6] @ root
        rest = M[6:, :6] @ drop + h[6:] - passive
        B: Array | None = None  # joints by shares, where they are not joined by the root alone
        if np.any(torque_weight):
            w = np.broadcast_to(np.asarray(torque_weight, dtype=float), (n,))
            off, by_shares = rest if torque is None else rest - torque, M[6:, :6] @ lift - G[6:]
            A += by_joints.T @ (w[:, None] * by_joints)
            B = across.T @ lift + by_joints.T @ (w[:, None] * by_shares)
            C = by_shares.T @ (w[:, None] * by_shares)
            a, c = a + by_joints.T @ (w * off), c + by_shares.T @ (w * off)
        factor, info = potrf(A, lower=True)
        if info:
            return self._none(n, k, "tasks leave accelerations open: weights must be positive")
        y = trtrs(factor, a, lower=True)[0]
        quadratic: _Shares
        if B is None:
            across = trtrs(factor, across.T, lower=True)[0]
            quadratic = _Joined(lift, H[:6, :6] - across.T @ across, own)
            X = across @ lift
        else:
            X = trtrs(factor, B, lower=True)[0]
            C += lift.T @ H[:6, :6] @ lift - X.T @ X
            C[np.arange(m), np.arange(m)] += own
            quadratic = _Dense(C)
        c -= X.T @ y
        share, done = self._pivoted(quadratic, c)
        status, limited = "ok", 0
        joints = -trtrs(factor, y + X @ share, lower=True, trans=1)[0]
        tau = by_joints @ joints + M[6:, :6] @ (lift @ share) - G[6:] @ share + rest
        slack = OVER * (self.high - self.low)
        beyond = (tau > self.high + slack) | (tau < self.low - slack)
        if not done or beyond.any():
            held = trtrs(factor, by_joints.T, lower=True)[0].T
            by_shares = M[6:, :6] @ lift - G[6:]
            rows, still = by_shares - held @ X, rest - held @ y
            Q = quadratic.matrix()
            share, along, limited, status = self._bounded(Q, c, held, rows, still, beyond)
            joints = trtrs(factor, along - y - X @ share, lower=True, trans=1)[0]
            tau = by_joints @ joints + by_shares @ share + rest
        share = share.reshape(k, EDGES)
        qacc = np.concatenate([root @ joints + lift @ share.ravel() + drop, joints])
        tau = np.clip(tau, self.low, self.high)
        return Answer(qacc, tau, np.einsum("kce,ke->kc", edges, share), share, status, limited)

    def _cost(self, tasks: Sequence[Rows], wanted: Array, weight: Array | float):
        """Return the cost of a generalised acceleration: its Hessian, and the right side."""
        nv = len(wanted)
        own = np.broadcast_to(np.asarray(weight, dtype=float), (nv,))
        rows = [t for t in tasks if len(t.right)]
        if not rows:
            return np.diag(own), own * wanted
        A = np.concatenate([t.matrix for t in rows])
        w = np.concatenate([np.broadcast_to(t.weight, t.right.shape) for t in rows])
        wA = w[:, None] * A
        H = A.T @ wA
        H[np.arange(nv), np.arange(nv)] += own
        return H, wA.T @ np.concatenate([t.right for t in rows]) + own * wanted

    def _shares(self, touching: Touching, edges: Array, force: Array) -> Array:
        """Return the shares that give forces, evenly among the edges."""
        friction, normal = touching.friction, touching.normal
        push = np.einsum("kc,kc->k", force, normal)[:, None]
        along = np.matmul(force[:, None, :], edges / self.unit)[:, 0] - push
        even = push / EDGES + along / (0.5 * EDGES * max(friction, 1e-6) ** 2)
        return np.maximum(even, 0.0) / self.unit

    def _pivoted(self, quadratic: "_Shares", q: Array) -> tuple[Array, bool]:
        """Minimise over shares that are not negative; return them and whether that was reached."""
        m = len(q)
        zero = self._zero if len(self._zero) == m else np.zeros(m, dtype=bool)
        best, patience, scale = m + 1, 3, ZERO * max(1.0, float(np.abs(q).max(initial=0.0)))
        share = np.zeros(m)
        for _ in range(PIVOTS):
            free = (~zero).nonzero()[0]
            try:
                share = quadratic.best(free, q)
            except np.linalg.LinAlgError:
                break
            wrong = np.where(zero, quadratic.slope(share) + q < -scale, share < -ZERO)
            bad = int(wrong.sum())
            if not bad:
                self._zero = zero
                return np.maximum(share, 0.0), True
            if bad < best:
                best, patience = bad, 3
            elif patience:
                patience -= 1
            else:  # one at a time cannot go in circles
                wrong[: np.flatnonzero(wrong)[-1]] = False
            zero = zero ^ wrong
        self._zero = np.zeros(0, dtype=bool)
        return np.maximum(share, 0.0), False

    def _bounded(self, Q, q, held, rows, rest, beyond) -> tuple[Array, Array, int, str]:
        r"""Minimise :math:`u^T u + \lambda^T Q \lambda + 2 q^T \lambda` within torque limits.

        Torques are ``held @ u + rows @ shares + rest``, with :math:`u` the joint accelerations off
        those best for the shares, in the metric of the cost. Only limits that were passed are
        asked for, until none is; :math:`u` has no part across their rows.
        """
        import daqp

        m, asked, held_at = len(q), beyond | self._stopped, np.zeros(0)
        share, along = np.zeros(m), np.zeros(held.shape[1])
        status, stopped = "not solved: torques pass their limits in turn", np.zeros_like(beyond)
        for _ in range(ROUNDS):
            which = np.flatnonzero(asked)
            span, corner = np.linalg.qr(held[which].T)
            k = span.shape[1]
            H, A = np.eye(k + m), np.hstack([corner.T, rows[which]])
            H[k:, k:] = Q
            wide = np.full(k, 1e30)
            upper = np.concatenate([wide, np.full(m, 1e30), (self.high - rest)[which]])
            lower = np.concatenate([-wide, np.zeros(m), (self.low - rest)[which]])
            sense = np.zeros(len(upper), dtype=np.int32)
            sense[k : k + m][self._zero if len(self._zero) == m else slice(0)] = WARM
            x, _, flag, info = daqp.solve(H, np.r_[np.zeros(k), q], A, upper, lower, sense)
            if flag < 1 or not np.isfinite(x).all():
                status = f"not solved (DAQP says {flag})"
                break
            share, along = np.maximum(x[k:], 0.0), span @ x[:k]
            held_at = np.asarray(info["lam"])[k + m :]
            tau = held @ along + rows @ share + rest
            slack = OVER * (self.high - self.low)
            more = ((tau > self.high + slack) | (tau < self.low - slack)) & ~asked
            stopped[:] = False
            stopped[which[held_at != 0]] = True
            if not more.any():
                status = "ok"
                break
            asked |= more
        self._stopped = stopped
        return share, along, int(stopped.sum()), status

    def _none(self, n: int, k: int, why: str) -> Answer:
        zero = np.zeros((k, 3))
        return Answer(np.zeros(n + 6), np.zeros(n), zero, np.zeros((k, EDGES)), why)

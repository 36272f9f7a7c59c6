r"""Velocities that are wanted, and the torques that give them: motors and contacts in one program.

[Tsai2010]_ asks every joint for a velocity that depends on its error alone and leaves it to one
linear complementarity problem to find torques, each within its limits, together with the forces of
the contacts. Such a problem,

.. math:: l \le x \perp H x + g \le u,

with a symmetric positive definite :math:`H`, is the optimality condition of

.. math:: \min_{l \le x \le u} \tfrac12 x^T H x + g^T x, \quad x = (\tau, \lambda) .

Accelerations :math:`\dot v = M^{-1} (S^T \tau + J^T G \lambda - h)` are eliminated, so that nothing
is left but bounds: torques within strength, shares of the edges of friction pyramids not negative.
A motor that reaches its velocity has no slack; one at its limit gives what it can.

What is asked may also be put to :class:`~plantigrade.wbc.whole_body.WholeBody`, which eliminates
the torques as well and has the shares alone as unknowns: the same answer, from a smaller program
that starts where the last one ended. It is the one that walks.
"""

from collections.abc import Sequence

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import ParameterError
from plantigrade.kinematics.rigid_points import RigidPoints
from plantigrade.kinematics.state import State
from plantigrade.models import Human
from plantigrade.wbc.rows import Asked, cost
from plantigrade.wbc.whole_body import Answer, Touching, WholeBody

REACHED = 0.055
"""In this time a wanted velocity is to be reached [s]; in one step of the physics it would throw
the body."""
SLOPE, FASTEST, PEAK, WIDTH, LEAST = 5.5, 12.0, 0.6, 0.8, 0.3
"""The bell: rate by error near zero [1/s]; greatest rate [rad/s], the error where it is [rad], its
width [rad]; and what is left of the rate at great errors. Its figure is not in the printed text;
these are ours, near those of the published bell of arm movements [Flash1985]_."""
TORQUE_COST, HELD, TOUCHED = 0.25, 0.005, 0.12
"""Cost of a torque by its limit, squared, and of a share [0.1 body weights] where a point is held
and where it only touches: of all torques and forces that give the same motion, small ones."""
HANGS, HANGING, MOST = 0.001, 20.0, 500.0
"""A point that is higher above the ground than this cannot press before it is down [m]; what a
share of it costs more, at twice that height, and at most. Without it the body leaned on heels that
hung 2 mm over the ground, and fell on them with three times its weight."""
SLACK = 1e-3
"""Part by which constraints give way in the paper's own problem, as in engines."""
SWEEPS, SETTLED = 5000, 1e-10
"""Sweeps of projected Gauss–Seidel, at most, and the change that is none."""
SOLVERS = ("daqp", "gauss-seidel")
"""Of a boxed program."""


def bell(error: Float[Array, "*n"]) -> Float[Array, "*n"]:
    r"""Return the rate at which a joint goes to where it should be [rad/s].

    Near its place in proportion, farther off along a bell, as limbs that are led to a goal move
    (Fig. 7 of [Tsai2010]_, after [Flash1985]_).

    Args:
        error: Angle from where it is to where it should be [rad].
    """
    size = np.abs(error)
    if size.max(initial=0.0) <= PEAK:
        return SLOPE * error
    high = FASTEST * np.exp(-(((size - PEAK) / WIDTH) ** 2))
    high = np.where(size > PEAK, np.maximum(high, LEAST * FASTEST), high)
    return np.sign(error) * np.minimum(SLOPE * size, high)


class BoxProgram:
    """Torques and contact forces for wanted velocities: a program with bounds alone.

    Args:
        human: The person.
        armature: What the plant adds to the inertia of each hinge [kg m²].
        limits: Least and greatest torque of each hinge [N m]; the person's if absent.
    """

    def __init__(
        self,
        human: Human,
        armature: float | Float[Array, " n_hinges"] = 0.0,
        limits: Float[Array, "2 n_hinges"] | None = None,
    ):
        self.human = human
        self.whole = WholeBody(human, armature=armature, limits=limits)
        self.low, self.high = self.whole.low, self.whole.high
        self.cost = TORQUE_COST / np.maximum(-self.low, self.high) ** 2

    def solve(
        self,
        state: State,
        touching: Touching,
        rows: Sequence[Asked],
        *,
        wanted: Float[Array, " nv"],
        weight: Float[Array, " nv"],
        passive: float | Float[Array, " n_hinges"] = 0.0,
        held: Bool[Array, " k"] | None = None,
        gap: Float[Array, " k"] | None = None,
        points: RigidPoints | None = None,
    ) -> Answer:
        """Return torques, forces and accelerations.

        Args:
            state: The state of the body.
            touching: Where it touches.
            rows: What is asked of the generalised acceleration.
            wanted: What each of its coordinates is to be.
            weight: Cost of a squared unit missed of that, positive for joints.
            passive: What the joints give by themselves [N m].
            held: Which points are planned to stand; all if absent.
            gap: How high each point is above the ground; not at all if absent [m].
            points: The points that touch, where the caller has them.
        """
        return self.whole.solve(
            state,
            touching,
            rows,
            wanted=wanted,
            weight=weight,
            force_weight=_shares_cost(len(touching), held, gap),
            torque_weight=self.cost,
            passive=passive,
            points=points,
        )

    def matrices(
        self,
        state: State,
        touching: Touching,
        rows: Sequence[Asked],
        *,
        wanted: Float[Array, " nv"],
        weight: Float[Array, " nv"],
        passive: float | Float[Array, " n_hinges"] = 0.0,
        held: Bool[Array, " k"] | None = None,
        gap: Float[Array, " k"] | None = None,
    ) -> "Boxed":
        """Return the same as a boxed program; arguments as :meth:`solve`."""
        E, X, rest, edges = self._effects(state, touching, passive)
        k = len(touching)
        H, g = cost(rows, wanted, weight)
        g = X.T @ (H @ rest - g)
        H = X.T @ H @ X
        own = np.concatenate([self.cost, np.repeat(_shares_cost(k, held, gap), 4)])
        H[np.arange(len(g)), np.arange(len(g))] += own
        # Units by which every unknown costs the same: light toes and whole legs are in one program.
        scale = 1.0 / np.sqrt(H.diagonal())
        low = np.concatenate([self.low, np.zeros(4 * k)]) / scale
        high = np.concatenate([self.high, np.full(4 * k, np.inf)]) / scale
        H *= np.outer(scale, scale)
        return Boxed(H, g * scale, low, high, X * scale, rest, scale, edges)

    def motors(
        self,
        state: State,
        touching: Touching,
        rates: Float[Array, " n_hinges"],
        *,
        passive: float | Float[Array, " n_hinges"] = 0.0,
    ) -> "Boxed":
        r"""Return the paper's own problem: motors reach rates, nothing passes through the ground.

        .. math:: H = E^T M^{-1} E, \quad E = (S^T, J^T G),

        the matrix of an engine's constraints: a motor has its rate unless its torque is at a limit,
        an edge of friction pushes unless it separates. Nothing in it holds the balance; the walk of
        this package asks for more (:meth:`matrices`).

        Args:
            state: The state of the body.
            touching: Where it touches.
            rates: Wanted of the hinges [rad/s].
            passive: What the joints give by themselves [N m].
        """
        E, X, rest, edges = self._effects(state, touching, passive)
        n, m = len(self.low), E.shape[1] - len(self.low)
        H, missing = E.T @ X, E.T @ (rest + state.qvel / REACHED)
        missing[:n] -= rates / REACHED
        H[np.arange(n + m), np.arange(n + m)] *= 1.0 + SLACK
        scale = 1.0 / np.sqrt(H.diagonal())
        low = np.concatenate([self.low, np.zeros(m)]) / scale
        high = np.concatenate([self.high, np.full(m, np.inf)]) / scale
        H *= np.outer(scale, scale)
        return Boxed(H, missing * scale, low, high, X * scale, rest, scale, edges)

    def _effects(self, state: State, touching: Touching, passive):
        """Return forces by torque and share, accelerations by them and by none, and the edges."""
        M, h = state.mass_matrix.copy(), state.bias.copy()
        n = len(h) - 6
        M[np.arange(6, n + 6), np.arange(6, n + 6)] += self.whole.armature
        edges = self.whole.unit * touching.edges()
        J = state.touched(touching.body, touching.place)[0]
        G = np.matmul(J.transpose(0, 2, 1), edges).transpose(1, 0, 2).reshape(n + 6, -1)
        h[6:] -= passive
        E = np.zeros((n + 6, n + G.shape[1] + 1))
        E[np.arange(6, n + 6), np.arange(n)] = 1.0
        E[:, n:-1], E[:, -1] = G, -h
        X = cho_solve(cho_factor(M, lower=True, check_finite=False), E, check_finite=False)
        return E[:, :-1], X[:, :-1], X[:, -1], edges


def _shares_cost(
    k: int, held: Bool[Array, " k"] | None, gap: Float[Array, " k"] | None = None
) -> Float[Array, " k"]:
    """Return the cost of a share of each point."""
    own = np.full(k, HELD) if held is None else np.where(held, HELD, TOUCHED)
    if gap is None:
        return own
    return own + np.minimum(HANGING * np.maximum(gap / HANGS - 1.0, 0.0) ** 2, MOST)


class Boxed:
    """A boxed program: its Hessian, gradient and bounds, and what its unknowns do.

    Args:
        H: Hessian.
        g: Gradient at zero.
        low: Lower bounds.
        high: Upper bounds.
        X: Generalised acceleration by unknown.
        rest: That of none.
        scale: Torque or share by unknown [N m, 0.1 body weights].
        edges: Force by share of each point [N].
    """

    def __init__(self, H, g, low, high, X, rest, scale, edges):
        self.H, self.g, self.low, self.high = H, g, low, high
        self.X, self.rest, self.scale, self.edges = X, rest, scale, edges

    def daqp(self) -> tuple[Float[Array, " n"], str]:
        """Solve by the dual active-set method of [Arnstrom2022]_; return unknowns and status."""
        import daqp

        upper = np.where(np.isfinite(self.high), self.high, 1e30)
        n = len(self.g)
        sense = np.zeros(n, dtype=np.int32)
        x, _, flag, _ = daqp.solve(self.H, self.g, np.zeros((0, n)), upper, self.low, sense)
        if flag < 1 or not np.isfinite(x).all():
            return np.zeros(n), f"not solved (DAQP says {flag})"
        return np.clip(x, self.low, self.high), "ok"

    def gauss_seidel(self, start: Float[Array, " n"] | None = None) -> tuple[Array, int]:
        """Solve by projected Gauss–Seidel, as physics engines do; return unknowns and sweeps.

        One unknown after the other is put where its own row is zero, or at its bound.

        Args:
            start: Where to begin; zero if absent.
        """
        H, g, low, high = self.H, self.g, self.low, self.high
        x = np.zeros(len(g)) if start is None else np.array(start, dtype=float)
        diagonal = H.diagonal().copy()
        for sweep in range(SWEEPS):
            most = 0.0
            for i in range(len(g)):
                new = x[i] - (H[i] @ x + g[i]) / diagonal[i]
                new = min(max(new, low[i]), high[i])
                most, x[i] = max(most, abs(new - x[i])), new
            if most < SETTLED * max(1.0, float(np.abs(x).max())):
                return x, sweep + 1
        return x, SWEEPS

    def answer(self, solver: str = "daqp") -> Answer:
        """Return torques, forces and accelerations of the solution.

        Args:
            solver: ``"daqp"`` (:meth:`daqp`) or ``"gauss-seidel"`` (:meth:`gauss_seidel`).

        Raises:
            ParameterError: If there is no such solver.
        """
        if solver not in SOLVERS:
            raise ParameterError(f"no solver {solver!r}; there are {', '.join(SOLVERS)}")
        if solver == "daqp":
            x, status = self.daqp()
        else:
            x, sweeps = self.gauss_seidel()
            status = "ok" if sweeps < SWEEPS else f"not settled after {SWEEPS} sweeps"
        n, k = len(self.g) - 4 * len(self.edges), len(self.edges)
        share = (self.scale[n:] * x[n:]).reshape(k, 4)
        force = np.einsum("kce,ke->kc", self.edges, share)
        tau = self.scale[:n] * x[:n]
        stopped = (x[:n] <= self.low[:n]) | (x[:n] >= self.high[:n])
        qacc = self.X @ x + self.rest
        return Answer(qacc, tau, force, share, status, int(stopped.sum()))

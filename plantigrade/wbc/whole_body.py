r"""One program for the whole body: accelerations and contact forces that serve all tasks at once.

.. math:: \min_{\dot v, \lambda, \tau} \sum_i w_i \| A_i \dot v - b_i \|^2
    + w_\lambda \| \lambda - \bar\lambda \|^2 + \sum_j w_j (\tau_j - \bar\tau_j)^2

so that the equations of motion hold, :math:`\lambda \ge 0` along the edges of the friction pyramid
of every point that touches, and every torque stays within the strength of its joint. Weights, not
ranks: where tasks disagree each gives way a little, as balance needs it (like the sum in Eq. 7 of
[Park2020]_); strict orders are in :mod:`plantigrade.wbc.hierarchy`.

The unknowns are those of :mod:`plantigrade.wbc.forces`: joint accelerations and shares
:math:`\lambda` of pyramid edges. (With the accelerations eliminated by the inverse of the mass
matrix instead, light toes make the program so badly conditioned that solvers fail.) Joint
accelerations are eliminated from the optimality conditions by one Cholesky decomposition
(:mod:`plantigrade.wbc.reduced`). There remain a least-squares problem in :math:`\lambda \ge 0`
(:mod:`plantigrade.wbc.shares`), and torques that stop at their limits
(:mod:`plantigrade.wbc.torque_limits`).

However many points touch, they act on the body by one wrench on each of its bones.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.rigid_points import RigidPoints
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.wbc.reduced import InstantDynamics, Reduced, TorqueCost
from plantigrade.wbc.rows import Objective, PointRows, Rows, cost
from plantigrade.wbc.shares import ShareProgram
from plantigrade.wbc.torque_limits import TorqueLimits
from plantigrade.wbc.touching import FORCE_UNIT, N_EDGES, Touching, wrenches

__all__ = ["FORCE_UNIT", "N_EDGES", "Answer", "PointRows", "Rows", "Touching", "WholeBody"]


@dataclass(frozen=True, eq=False)
class Answer:
    """The answer of a whole-body program.

    Attributes:
        qacc: Generalised acceleration.
        torque: Torque of the motor of each hinge [N m].
        force: Force of the ground at each point, world [N].
        share: The same along the edges of its pyramid, in the units of the program.
        status: ``"ok"``, or why there is no answer.
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
        armature: Inertia added to each hinge by the plant [kg m²].
        limits: Least and greatest torque of each hinge [N m]; the person's if absent.

    Example:
        >>> import numpy as np
        >>> human = Human.create()
        >>> program = WholeBody(human)
        >>> state = BodyState(human, human.standing())
        >>> flight = program.solve(state, Touching(), desired=np.zeros(human.model.nv))
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
        self.armature = _each(armature, n)
        own = np.array(human.model.jnt_actfrcrange[1:]).T
        self.low, self.high = own if limits is None else np.asarray(limits, dtype=float)
        self.unit = FORCE_UNIT * human.mass * human.gravity
        self._limits = TorqueLimits(self.low, self.high)

    def limit(self, limits: Float[Array, "2 n_hinges"]) -> None:
        """Let other torque limits hold: least and greatest of each hinge [N m]."""
        self.low, self.high = limits
        self._limits.set(self.low, self.high)

    def solve(
        self,
        state: BodyState,
        touching: Touching,
        tasks: Sequence[Objective] = (),
        *,
        desired: Float[Array, " nv"],
        weight: float | Float[Array, " nv"] = 1.0,
        force: Float[Array, "k 3"] | None = None,
        force_weight: float | Float[Array, " k"] = 1e-3,
        torque: Float[Array, " n_hinges"] | None = None,
        torque_weight: float | Float[Array, " n_hinges"] = 0.0,
        passive: float | Float[Array, " n_hinges"] = 0.0,
        points: RigidPoints | None = None,
    ) -> Answer:
        r"""Return the accelerations, torques and forces that serve all tasks best.

        Args:
            state: The state of the body.
            touching: Its points of contact.
            tasks: Rows of the generalised acceleration.
            desired: Desired generalised acceleration, coordinate by coordinate.
            weight: Cost of a squared unit missed of it, positive for joints; also keeps the program
                well posed.
            force: Desired force at each point [N]; none if absent.
            force_weight: Cost of a share [0.1 body weights], squared, off the desired; positive.
            torque: Desired torque of the motors [N m]; zero if absent.
            torque_weight: Cost of a squared newton metre off it.
            passive: Passive torques of the joints [N m].
            points: The points that touch, where the caller has them.
        """
        n, k = len(self.low), len(touching)
        if points is None:
            points = state.rigid_points(touching.body, touching.place)
        edges = self.unit * touching.edges()
        jacobian = points.body_jacobian.reshape(-1, n + 6)
        inertia = state.mass_matrix, state.bias
        dynamics = InstantDynamics(*inertia, self.armature, _each(passive, n), jacobian)
        torques = None
        if np.any(torque_weight):
            torques = TorqueCost(_each(torque, n), _each(torque_weight, n))
        try:
            reduced = Reduced(
                dynamics, *cost(tasks, desired, weight), wrenches(points, edges), torques
            )
        except np.linalg.LinAlgError:
            n, nothing = len(self.low), (np.zeros((k, 3)), np.zeros((k, N_EDGES)))
            why = "tasks leave accelerations open: weights must be positive"
            return Answer(np.zeros(n + 6), np.zeros(n), *nothing, why)
        own = np.repeat(_each(force_weight, k), N_EDGES)
        q = reduced.q @ reduced.K
        if force is not None:
            q -= own * self._shares(touching, edges, force).ravel()
        program = ShareProgram.of(reduced.K, reduced.S, own, q)
        share, qacc, tau, status = self._limits.solve(reduced, program)
        share = share.reshape(k, N_EDGES)
        tau = np.minimum(np.maximum(tau, self.low), self.high)
        given = np.matmul(edges, share[:, :, None])[:, :, 0]
        limited = int(np.count_nonzero(self._limits.at))
        return Answer(qacc, tau, given, share, status, limited)

    def _shares(self, touching: Touching, edges: Array, force: Array) -> Float[Array, "k n_edges"]:
        """Return the shares that give forces, evenly among the edges."""
        push = np.matmul(force[:, None], touching.normal[:, :, None])[:, 0]
        along = np.matmul(force[:, None], edges / self.unit)[:, 0] - push
        even = push / N_EDGES + along / (0.5 * N_EDGES * max(touching.friction, 1e-6) ** 2)
        return np.maximum(even, 0.0) / self.unit


def _each(value: float | Array | None, n: int) -> Float[Array, " n"]:
    """Return a number for each of n; nothing is zero."""
    if isinstance(value, np.ndarray) and value.ndim:
        return value
    return np.full(n, 0.0 if value is None else float(value))

r"""The evaluated state of a body: positions, velocities, Jacobians and inertia.

Having a :class:`State` *is* having run forward kinematics at its configuration and velocity.
Nothing of it can be changed: :meth:`State.moved_to` and :meth:`State.integrated` return the next
state, and :func:`sweep` those of a motion. (States that come from one another share MuJoCo's
memory; one that is used after a later one is evaluated again.) Positions, Jacobians and bias
accelerations are available in any order; each is computed once, and kept read only.

For any function of the configuration :math:`x = f(q)`, with MuJoCo's velocity :math:`v`,

.. math:: \dot x = J v, \qquad \ddot x = J \dot v + \dot J v

(Eqs. 2 and 9 of [Boukheddimi]_). The last term is the *bias acceleration*, which remains where
:math:`\dot v = 0`; the engine gives :math:`\dot J`.
"""

from collections.abc import Iterator, Sequence
from typing import Any

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.errors import ParameterError
from plantigrade.kinematics.engine import MujocoMemory, moved_by, once, read_only
from plantigrade.kinematics.rigid_points import CROSS, RigidPoints
from plantigrade.models import Human
from plantigrade.motion.motion import Motion

__all__ = ["PointSet", "BodyState", "body_paths", "integrate", "sweep"]

# Up to this number of points the engine computes everything, a microsecond each for position,
# Jacobian and its rate; for more, products of matrices are faster.
MAX_ENGINE_POINTS = 4
IDENTITY_QUATERNION = np.array([1.0, 0.0, 0.0, 0.0])


class PointSet:
    """Points fixed to bodies of one person.

    Args:
        bodies: Body name of each point.
        local: Position of each point in its body's frame [m].
        model: The person's model with other segment lengths; their own if absent.
    """

    def __init__(
        self,
        human: Human,
        bodies: Sequence[str],
        local: Float[Array, "n_points 3"],
        model: mujoco.MjModel | None = None,
    ):
        self.human = human
        self.model = human.model if model is None else model
        self.body = np.array([human.body(b) for b in bodies], dtype=int)
        self.local = np.array(local, dtype=float).reshape(-1, 3)
        if len(self.body) != len(self.local):
            raise ParameterError(f"{len(self.body)} bodies for {len(self.local)} points")
        self.moved = moved_by(self.model)[self.body][:, None, :]
        self.few = len(self) <= MAX_ENGINE_POINTS
        self._places = list(zip(self.body.tolist(), self.local, strict=True))  # for the engine

    @classmethod
    def of(
        cls, human: Human, places: Sequence[Any], model: mujoco.MjModel | None = None
    ) -> "PointSet":
        """Return the points of whatever has a ``body`` and a ``position`` in its frame [m]."""
        local = np.array([p.position for p in places], dtype=float).reshape(-1, 3)
        return cls(human, [p.body for p in places], local, model)

    def __len__(self) -> int:
        return len(self.body)

    def values(self, state: "BodyState") -> Float[Array, "n_points 3"]:
        """Return where the points are [m]."""
        return state.position(self)

    def jacobian(self, state: "BodyState") -> Float[Array, "n_points 3 nv"]:
        """Return the Jacobian of :meth:`values`."""
        return state.jacobian(self)

    def path(self, qpos: Float[Array, "n_frames nq"]) -> Float[Array, "n_frames n_points 3"]:
        """Return where the points are in every frame of a motion [m]."""
        model, data = self.model, mujoco.MjData(self.model)
        bodies, owner = np.unique(self.body, return_inverse=True)
        origin, turn = np.empty((len(qpos), len(bodies), 3)), np.empty((len(qpos), len(bodies), 9))
        for k, configuration in enumerate(qpos):
            data.qpos[:] = configuration
            mujoco.mj_kinematics(model, data)
            origin[k], turn[k] = data.xpos[bodies], data.xmat[bodies]
        turned = turn.reshape(*turn.shape[:2], 3, 3)[:, owner] @ self.local[:, :, None]
        return origin[:, owner] + turned[..., 0]


class BodyState:
    """A body at a configuration ``qpos`` and velocity ``qvel``; it never changes.

    Args:
        qvel: Zero if absent.
        model: The person's model with other segment lengths; their own if absent.
    """

    def __init__(
        self,
        human: Human,
        qpos: Float[Array, " nq"],
        qvel: Float[Array, " nv"] | None = None,
        *,
        model: mujoco.MjModel | None = None,
    ):
        self._evaluate(human, MujocoMemory(human.model if model is None else model), qpos, qvel)

    def _evaluate(self, human, engine: MujocoMemory, qpos, qvel) -> None:
        nv = engine.model.nv
        qvel = np.zeros(nv) if qvel is None else np.array(qvel, dtype=float)
        self._become(human, engine, np.array(qpos, dtype=float), qvel)

    def _become(self, human, engine: MujocoMemory, qpos, qvel) -> None:
        self.human, self.model, self._engine = human, engine.model, engine
        self.qpos, self.qvel = qpos, qvel
        self.qpos.flags.writeable = self.qvel.flags.writeable = False
        self._known: dict = {}
        engine.at(self, velocities=False)

    @property
    def _position_data(self) -> mujoco.MjData:
        return self._engine.at(self, velocities=False)

    @property
    def _data(self) -> mujoco.MjData:
        return self._engine.at(self, velocities=True)

    @property
    def mass(self) -> float:
        """Body mass [kg]."""
        return self._engine.mass

    def moved_to(
        self, qpos: Float[Array, " nq"], qvel: Float[Array, " nv"] | None = None
    ) -> "BodyState":
        """Return the state at another configuration and velocity (zero if absent)."""
        new = BodyState.__new__(BodyState)
        new._evaluate(self.human, self._engine, qpos, qvel)
        return new

    def integrated(self, qacc: Float[Array, " nv"], dt: float) -> "BodyState":
        """Return the state after ``dt`` [s] of constant acceleration."""
        qpos = self.qpos.copy()
        mujoco.mj_integratePos(self.model, qpos, self.qvel + 0.5 * dt * qacc, dt)
        new = BodyState.__new__(BodyState)
        new._become(self.human, self._engine, qpos, self.qvel + dt * qacc)
        return new

    def difference(self, qpos: Float[Array, " nq"]) -> Float[Array, " nv"]:
        """Return the tangent step that leads from ``qpos`` to this configuration."""
        step = np.empty(self.model.nv)
        mujoco.mj_differentiatePos(self.model, step, 1.0, qpos, self.qpos)
        return step

    def rotation(self, body: str | int) -> Float[Array, "3 3"]:
        """Return the rotation of a body, by name or index: its axes are the columns."""
        return self._position_data.xmat[self._index(body)].reshape(3, 3).copy()

    def origin(self, body: str | int) -> Float[Array, " 3"]:
        """Return where a body's frame is, by name or index [m]."""
        return self._position_data.xpos[self._index(body)].copy()

    @property
    def rotations(self) -> Float[Array, "n_bodies 3 3"]:
        """Rotation of every body, the world first."""
        return self._position_data.xmat.reshape(-1, 3, 3).copy()

    @property
    def origins(self) -> Float[Array, "n_bodies 3"]:
        """Where every body's frame is, the world first [m]."""
        return self._position_data.xpos.copy()

    def _index(self, body: str | int) -> int:
        return body if isinstance(body, int) else self.human.body(body)

    @once
    def position(self, points: PointSet) -> Float[Array, "n_points 3"]:
        """Return where points are [m]."""
        data = self._position_data
        rotation = data.xmat.reshape(-1, 3, 3)[points.body]
        return data.xpos[points.body] + (rotation @ points.local[:, :, None])[:, :, 0]

    @once
    def jacobian(self, points: PointSet) -> Float[Array, "n_points 3 nv"]:
        """Return the Jacobian of points' positions with respect to MuJoCo's velocity."""
        data, position = self._position_data, self.position(points)
        turned = ((data.subtree_com[1] - position) @ CROSS).reshape(-1, 3) @ data.cdof[:, :3].T
        J = turned.reshape(len(points), 3, -1)
        J += data.cdof[:, 3:].T
        J *= points.moved
        return J

    @once
    def velocity(self, points: PointSet) -> Float[Array, "n_points 3"]:
        """Return the velocity of points [m/s]."""
        return self.jacobian(points) @ self.qvel

    @once
    def bias_acceleration(self, points: PointSet) -> Float[Array, "n_points 3"]:
        """Return the acceleration of points where the generalised acceleration is zero [m/s²]."""
        data, rate = self._data, np.empty((len(points), 3, self.model.nv))
        for own, at, (body, _) in zip(rate, self.position(points), points._places, strict=True):
            mujoco.mj_jacDot(self.model, data, own, None, at, body)
        return (rate.reshape(-1, self.model.nv) @ self.qvel).reshape(-1, 3)

    def rigid_points(self, body: Int[Array, " k"], place: Float[Array, "k 3"]) -> RigidPoints:
        """Return the material at places of bodies, and how these bodies move.

        Args:
            body: Index of the body of each place.
            place: Where it is now, world [m].
        """
        data, model = self._data, self.model
        there = np.zeros(model.nbody, dtype=int)
        there[body] = 1
        bodies = there.nonzero()[0]
        n = len(bodies)
        there[bodies] = np.arange(n)
        J, origin = np.empty((2, n, 6, model.nv)), data.xpos[bodies]
        for i, index in enumerate(bodies.tolist()):
            at = origin[i]
            mujoco.mj_jac(model, data, J[0, i, 3:], J[0, i, :3], at, index)
            mujoco.mj_jacDot(model, data, J[1, i, 3:], J[1, i, :3], at, index)
        velocity, bias = (J.reshape(-1, model.nv) @ self.qvel).reshape(2, n, 6)
        owner = there[body]
        return RigidPoints(owner, place - origin[owner], J[0], velocity, bias)

    def touched(
        self, body: Int[Array, " k"], place: Float[Array, "k 3"]
    ) -> tuple[Float[Array, "k 3 nv"], Float[Array, "k 3"], Float[Array, "k 3"]]:
        """Return Jacobian, velocity and bias acceleration of the material at places of bodies.

        Args:
            body: Index of the body of each place.
            place: Where it is now, world [m].
        """
        points = self.rigid_points(body, place)
        return points.jacobian, points.velocity, points.bias

    def _few(self, points: PointSet) -> dict[str, Any]:
        """Return all there is to know of a few points, by name."""
        data, model, n = self._data, self.model, len(points._places)
        position, turn, J = np.empty((n, 3)), np.empty(9), np.empty((2, n, 3, model.nv))
        for i, (body, local) in enumerate(points._places):
            at = position[i]
            mujoco.mj_local2Global(data, at, turn, local, IDENTITY_QUATERNION, body, 0)
            mujoco.mj_jac(model, data, J[0, i], None, at, body)
            mujoco.mj_jacDot(model, data, J[1, i], None, at, body)
        velocity, bias = (J.reshape(-1, model.nv) @ self.qvel).reshape(2, n, 3)
        return {
            "position": read_only(position),
            "jacobian": read_only(J[0]),
            "velocity": read_only(velocity),
            "bias_acceleration": read_only(bias),
        }

    @property
    def com(self) -> Float[Array, " 3"]:
        """Whole-body centre of mass [m]."""
        return self._position_data.subtree_com[1].copy()

    @property
    def com_jacobian(self) -> Float[Array, "3 nv"]:
        """Jacobian of the centre of mass."""
        J = np.empty((3, self.model.nv))
        mujoco.mj_jacSubtreeCom(self.model, self._position_data, J, 1)
        return J

    @property
    def com_velocity(self) -> Float[Array, " 3"]:
        """Velocity of the centre of mass [m/s]."""
        return self._momentum[0]

    @property
    def angular_momentum(self) -> Float[Array, " 3"]:
        """Angular momentum about the centre of mass [kg m²/s]."""
        return self._momentum[1]

    @property
    def com_bias_acceleration(self) -> Float[Array, " 3"]:
        """Acceleration of the centre of mass where the generalised one is zero [m/s²].

        The force that moves the root is what the whole body needs: its mass times acceleration less
        gravity.
        """
        return self.bias[:3] / self._engine.mass + self._engine.gravity

    def angular_jacobian(self, body: str | int) -> Float[Array, "3 nv"]:
        """Jacobian of a body's angular velocity, world axes."""
        J = np.empty((3, self.model.nv))
        mujoco.mj_jacBody(self.model, self._position_data, None, J, self._index(body))
        return J

    @property
    def angular_momentum_jacobian(self) -> Float[Array, "3 nv"]:
        """Matrix that gives the angular momentum about the centre of mass from the velocity."""
        A = np.empty((3, self.model.nv))
        mujoco.mj_angmomMat(self.model, self._position_data, A, 1)
        return A

    def angular_bias_acceleration(self, body: str | int) -> Float[Array, " 3"]:
        """Angular acceleration of a body where the generalised one is zero [rad/s²]."""
        index, rate = self._index(body), np.empty((3, self.model.nv))
        mujoco.mj_jacDot(self.model, self._data, None, rate, np.zeros(3), index)
        return rate @ self.qvel

    @property
    def mass_matrix(self) -> Float[Array, "nv nv"]:
        """Joint-space inertia :math:`M(q)`."""
        if "M" not in self._known:
            M, data = np.empty((self.model.nv, self.model.nv)), self._position_data
            mujoco.mj_crb(self.model, data)
            mujoco.mj_fullM(self.model, data, M)
            self._known["M"] = read_only(M)
        return self._known["M"]

    @property
    def bias(self) -> Float[Array, " nv"]:
        """Generalised force :math:`h(q, v)` of gravity, centrifugal and Coriolis terms."""
        if "h" not in self._known:
            h = np.empty(self.model.nv)
            mujoco.mj_rne(self.model, self._data, 0, h)
            self._known["h"] = read_only(h)
        return self._known["h"]

    def inverse_dynamics(self, qacc: Float[Array, " nv"]) -> Float[Array, " nv"]:
        r"""Return the generalised force of an acceleration, without contact or joint limits.

        .. math:: \tau = M \dot v + h - \tau_{passive} .
        """
        data, tau = self._data, np.empty(self.model.nv)
        mujoco.mj_passive(self.model, data)
        data.qacc[:] = qacc
        mujoco.mj_rne(self.model, data, 1, tau)
        return tau + self.model.dof_armature * qacc - data.qfrc_passive

    def generalised_force(
        self,
        body: int,
        point: Float[Array, " 3"],
        force: Float[Array, " 3"],
        torque: Float[Array, " 3"],
    ) -> Float[Array, " nv"]:
        """Return the generalised force of a force at a world point of a body, and a torque."""
        result = np.zeros(self.model.nv)
        data = self._position_data
        mujoco.mj_applyFT(self.model, data, force, torque, point, body, result)
        return result

    @property
    def _momentum(self):
        if "momentum" not in self._known:
            data = self._data
            mujoco.mj_subtreeVel(self.model, data)
            found = data.subtree_linvel[1].copy(), data.subtree_angmom[1].copy()
            self._known["momentum"] = read_only(found[0]), read_only(found[1])
        return self._known["momentum"]


def integrate(
    model: mujoco.MjModel, qpos: Float[Array, " nq"], step: Float[Array, " nv"]
) -> Float[Array, " nq"]:
    """Return the configuration a tangent step away from ``qpos``."""
    result = np.array(qpos)
    mujoco.mj_integratePos(model, result, step, 1.0)
    return result


def sweep(
    human: Human,
    motion: Motion | Float[Array, "n_frames nq"],
    qvel: Float[Array, "n_frames nv"] | None = None,
    *,
    model: mujoco.MjModel | None = None,
) -> Iterator[BodyState]:
    """Yield the state of every frame of a motion.

    Args:
        motion: The motion, or its configurations alone.
        qvel: Velocities, where configurations are given; zero if absent.
        model: The person's model with other segment lengths; their own if absent.
    """
    if isinstance(motion, Motion):
        motion, qvel = motion.qpos, motion.qvel
    state = None
    for k, qpos in enumerate(motion):
        v = None if qvel is None else qvel[k]
        state = BodyState(human, qpos, v, model=model) if state is None else state.moved_to(qpos, v)
        yield state


def body_paths(
    human: Human, qpos: Float[Array, "n_frames nq"], bodies: Sequence[int]
) -> tuple[Float[Array, "n_frames n_bodies 3"], Float[Array, "n_frames n_bodies 3 3"]]:
    """Return origins [m] and rotations of bodies, world axes, in every frame of a motion."""
    chosen = list(bodies)
    origins = np.empty((len(qpos), len(bodies), 3))
    rotations = np.empty((len(qpos), len(bodies), 3, 3))
    for f, state in enumerate(sweep(human, qpos)):
        origins[f], rotations[f] = state.origins[chosen], state.rotations[chosen]
    return origins, rotations

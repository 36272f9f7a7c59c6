r"""The evaluated state of a body: where its points are, how they move, and what moves them.

Having a :class:`State` *is* having run forward kinematics at its configuration and velocity.
Positions, Jacobians and drifts can be asked for in any order; each is computed once.

For any function of the configuration :math:`x = f(q)`, with MuJoCo's velocity :math:`v`,

.. math:: \dot x = J v, \qquad \ddot x = J \dot v + \dot J v

(Eqs. 2 and 9 of [Boukheddimi]_). The last term, here called *drift*, is the acceleration that
remains where :math:`\dot v = 0`; it comes from the engine's own recursion over the bodies.
"""

from itertools import count

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.models import Human

_STAMPS = count()


class PointSet:
    """Points fixed to bodies of one person.

    Args:
        human: The person.
        bodies: Body name of each point.
        local: Position of each point in its body's frame [m].
    """

    def __init__(self, human: Human, bodies: list[str], local: Float[Array, "n_points 3"]):
        self.body = np.array([human.body(b) for b in bodies], dtype=int)
        self.local = np.array(local, dtype=float).reshape(-1, 3)
        if len(self.body) != len(self.local):
            raise ParameterError(f"{len(self.body)} bodies for {len(self.local)} points")
        model = human.model
        above = np.zeros((model.nbody, model.nv))  # which velocities move a body
        for body in range(1, model.nbody):
            above[body] = above[model.body_parentid[body]]
            start = model.body_dofadr[body]
            above[body, start : start + model.body_dofnum[body]] = 1.0
        self.moved = above[self.body][:, None, :]

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.body)


class State:
    """A body at a configuration and velocity.

    Args:
        human: The person.
        qpos: Configuration.
        qvel: Velocity; zero if absent.

    Attributes:
        qpos: The configuration.
        qvel: The velocity.
        stamp: A number of its own for every evaluation, of this state or any other.
    """

    def __init__(
        self,
        human: Human,
        qpos: Float[Array, " nq"],
        qvel: Float[Array, " nv"] | None = None,
    ):
        self.human, self.model = human, human.model
        self._data = mujoco.MjData(self.model)
        self._share = self.model.body_mass[1:] / self.model.body_mass.sum()
        self.move_to(qpos, np.zeros(self.model.nv) if qvel is None else qvel)

    @property
    def mass(self) -> float:
        """Body mass [kg]."""
        return float(self.model.body_mass.sum())

    def move_to(self, qpos: Float[Array, " nq"], qvel: Float[Array, " nv"]) -> "State":
        """Evaluate another configuration and velocity; return this state."""
        model, data = self.model, self._data
        self.qpos, self.qvel = np.array(qpos), np.array(qvel)
        data.qpos[:], data.qvel[:], data.qacc[:] = qpos, qvel, 0.0
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_comVel(model, data)
        mujoco.mj_rnePostConstraint(model, data)  # accelerations of all bodies where qacc = 0
        self._known: dict = {}
        self.stamp = next(_STAMPS)
        return self

    def integrate(self, qacc: Float[Array, " nv"], step: float) -> "State":
        """Move on by ``step`` [s] under a constant acceleration; return this state."""
        qpos = self.qpos.copy()
        mujoco.mj_integratePos(self.model, qpos, self.qvel + 0.5 * step * qacc, step)
        return self.move_to(qpos, self.qvel + step * qacc)

    def difference(self, qpos: Float[Array, " nq"]) -> Float[Array, " nv"]:
        """Return the tangent step that leads from ``qpos`` to this configuration."""
        step = np.empty(self.model.nv)
        mujoco.mj_differentiatePos(self.model, step, 1.0, qpos, self.qpos)
        return step

    def rotation(self, body: str) -> Float[Array, "3 3"]:
        """Return the rotation of a body: its axes are the columns."""
        return self.rotation_of(self.human.body(body)).copy()

    def rotation_of(self, body: int) -> Float[Array, "3 3"]:
        """Return the rotation of a body by its index in the model; valid until the state moves."""
        return self._data.xmat[body].reshape(3, 3)

    def position(self, points: PointSet) -> Float[Array, "n_points 3"]:
        """Return where points are [m]."""
        return self._once(points, "position", self._position)

    def jacobian(self, points: PointSet) -> Float[Array, "n_points 3 nv"]:
        """Return the Jacobian of points' positions with respect to MuJoCo's velocity."""
        return self._once(points, "jacobian", self._jacobian)

    def velocity(self, points: PointSet) -> Float[Array, "n_points 3"]:
        """Return the velocity of points [m/s]."""
        return self._once(points, "velocity", lambda p: self.jacobian(p) @ self.qvel)

    def drift(self, points: PointSet) -> Float[Array, "n_points 3"]:
        """Return the acceleration points have where the generalised acceleration is zero [m/s²]."""
        return self._once(points, "drift", self._drift)

    @property
    def com(self) -> Float[Array, " 3"]:
        """Whole-body centre of mass [m]."""
        return self._data.subtree_com[1].copy()

    @property
    def com_jacobian(self) -> Float[Array, "3 nv"]:
        """Jacobian of the centre of mass."""
        J = np.empty((3, self.model.nv))
        mujoco.mj_jacSubtreeCom(self.model, self._data, J, 1)
        return J

    @property
    def com_drift(self) -> Float[Array, " 3"]:
        """Acceleration of the centre of mass where the generalised acceleration is zero [m/s²]."""
        linear, angular = self._bodies
        arm = self._data.xipos[1:] - self._data.subtree_com[1]
        return self._share @ (linear[1:] + (angular[1:] @ arm[:, :, None])[:, :, 0])

    def angular_jacobian(self, body: str) -> Float[Array, "3 nv"]:
        """Jacobian of a body's angular velocity, world axes."""
        J = np.empty((3, self.model.nv))
        mujoco.mj_jacBody(self.model, self._data, None, J, self.human.body(body))
        return J

    def angular_drift(self, body: str) -> Float[Array, " 3"]:
        """Angular acceleration of a body where the generalised acceleration is zero [rad/s²]."""
        return self._data.cacc[self.human.body(body), :3].copy()

    @property
    def mass_matrix(self) -> Float[Array, "nv nv"]:
        """Joint-space inertia :math:`M(q)`."""
        if "M" not in self._known:
            M = np.empty((self.model.nv, self.model.nv))
            mujoco.mj_crb(self.model, self._data)
            mujoco.mj_fullM(self.model, self._data, M)
            self._known["M"] = M
        return self._known["M"]

    @property
    def bias(self) -> Float[Array, " nv"]:
        """Generalised force of gravity, centrifugal and Coriolis terms: :math:`h(q, v)`."""
        h = np.empty(self.model.nv)
        mujoco.mj_rne(self.model, self._data, 0, h)
        return h

    def _once(self, points: PointSet, what: str, compute):
        key = (id(points), what)
        if key not in self._known:
            self._known[key] = compute(points)
            self._known[id(points)] = points  # keeps the id from being given to another set
        return self._known[key]

    def _position(self, points: PointSet):
        rotation = self._data.xmat.reshape(-1, 3, 3)[points.body]
        return self._data.xpos[points.body] + (rotation @ points.local[:, :, None])[:, :, 0]

    def _jacobian(self, points: PointSet):
        data = self._data
        arm = self.position(points) - data.subtree_com[1]
        angular, linear = data.cdof[:, :3], data.cdof[:, 3:]
        J = np.empty((len(points), 3, self.model.nv))
        x, y, z = arm[:, 0:1], arm[:, 1:2], arm[:, 2:3]
        ax, ay, az = angular[:, 0], angular[:, 1], angular[:, 2]
        J[:, 0] = linear[:, 0] + ay * z - az * y
        J[:, 1] = linear[:, 1] + az * x - ax * z
        J[:, 2] = linear[:, 2] + ax * y - ay * x
        J *= points.moved
        return J

    def _drift(self, points: PointSet):
        linear, angular = self._bodies
        arm = self.position(points) - self._data.subtree_com[1]
        return linear[points.body] + (angular[points.body] @ arm[:, :, None])[:, :, 0]

    @property
    def _bodies(self):
        r"""Value and gradient of every body's acceleration field, where nothing accelerates.

        With :math:`r` from the centre of mass of the whole body,
        :math:`a(r) = a_0 + ([\alpha]_\times + [\omega]_\times^2)\, r`.
        """
        if "bodies" not in self._known:
            data = self._data
            turn = _skew(data.cvel[:, :3])
            linear = data.cacc[:, 3:] + (turn @ data.cvel[:, 3:, None])[:, :, 0]
            linear += self.model.opt.gravity  # the engine lets gravity push up
            self._known["bodies"] = linear, _skew(data.cacc[:, :3]) + turn @ turn
        return self._known["bodies"]


def _skew(vectors):
    """Return the matrices of cross products with vectors (n, 3, 3)."""
    out = np.zeros((len(vectors), 3, 3))
    out[:, 2, 1], out[:, 1, 2] = vectors[:, 0], -vectors[:, 0]
    out[:, 0, 2], out[:, 2, 0] = vectors[:, 1], -vectors[:, 1]
    out[:, 1, 0], out[:, 0, 1] = vectors[:, 2], -vectors[:, 2]
    return out

r"""Equations of motion of a person as CasADi expressions, for optimisation.

They are generated from the compiled MuJoCo model of any :class:`Human` and are smooth functions of
plain vectors: OpenSim's pelvis angles replace the quaternion of the free joint.

**Coordinates.** :math:`q`, :math:`\dot q` and :math:`\ddot q` are vectors of length ``nv`` in the
order of :meth:`~plantigrade.models.Human.to_coordinates`: ``pelvis_tilt``, ``pelvis_list``,
``pelvis_rotation`` [rad], ``pelvis_tx``, ``pelvis_ty``, ``pelvis_tz`` [m] in OpenSim's axes
(forward, up, right), then the hinges [rad] in MuJoCo's order. The rotation of the pelvis is

.. math:: R = R_y(-\mathrm{tilt})\, R_x(\mathrm{list})\, R_z(\mathrm{rotation}).

At a list of ±90° the axes of tilt and rotation coincide, so that rates and generalised forces of
these two coordinates are not unique. Wrenches in world axes are unaffected.

**Method.** Recursions over the bodies: :mod:`plantigrade.dynamics.recursions`.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.site import Point
from plantigrade.dynamics.links import inertia
from plantigrade.dynamics.recursions import LinkTree
from plantigrade.errors import ParameterError
from plantigrade.extras import require
from plantigrade.models import Human
from plantigrade.spatial.conventions import (
    OPENSIM_TO_WORLD,
    PELVIS,
    free_joint_to_pelvis_rates,
    pelvis_rates_to_free_joint,
)

if TYPE_CHECKING:
    import casadi

ROOTS = ("pelvis", "com", "coordinates")


class SymbolicHuman:
    """Kinematics and dynamics of a person as CasADi functions of q, qd and qdd.

    Every method returns a :class:`casadi.Function`, built at the first call and cached. Points and
    forces are columns in world axes: x forward, y left, z up.

    Args:
        gravity: Gravity [m/s²], world axes; the model's if absent.

    Attributes:
        human: The person.
        nv: Number of coordinates.
        names: Names of the coordinates, in the order of q.
        mass: Body mass of the model [kg].
        gravity: Gravity [m/s²], world axes.

    Example:
        >>> body = SymbolicHuman(Human.create(1.74, 70.0))
        >>> q = np.zeros(body.nv)
        >>> tau = body.inverse_dynamics()(q, 0 * q, 0 * q)
        >>> round(float(tau[2]), 6)  # the ground must carry the weight [N]
        686.7
    """

    def __init__(self, human: Human, gravity: Float[Array, " 3"] | None = None):
        model = human.model
        self.human = human
        self.nv: int = model.nv
        self.names: tuple[str, ...] = PELVIS + human.coordinates
        self.mass = float(model.body_mass[1:].sum())
        self.gravity = np.array(model.opt.gravity if gravity is None else gravity, dtype=float)
        self._tree = LinkTree(human, self.gravity)
        self._functions: dict[tuple, Any] = {}
        self._symbols: dict[str, Any] = {}

    def from_mujoco(
        self,
        qpos: Float[Array, "n_frames nq"],
        qvel: Float[Array, "n_frames nv"],
        qacc: Float[Array, "n_frames nv"],
    ) -> tuple[
        Float[Array, "n_frames nv"], Float[Array, "n_frames nv"], Float[Array, "n_frames nv"]
    ]:
        """Return q, qd and qdd of a motion in MuJoCo's variables.

        Raises:
            ParameterError: If the pelvis list is 90°, where the rates of its angles are not unique.
        """
        _, q = self.human.to_coordinates(qpos)
        rates, accelerations = free_joint_to_pelvis_rates(q[:, :3], qvel[:, 3:6], qacc[:, 3:6])
        qd = np.hstack([rates, qvel[:, :3] @ OPENSIM_TO_WORLD, qvel[:, 6:]])
        qdd = np.hstack([accelerations, qacc[:, :3] @ OPENSIM_TO_WORLD, qacc[:, 6:]])
        return q, qd, qdd

    def to_mujoco(
        self,
        q: Float[Array, "n_frames nv"],
        qd: Float[Array, "n_frames nv"],
        qdd: Float[Array, "n_frames nv"],
    ) -> tuple[
        Float[Array, "n_frames nq"], Float[Array, "n_frames nv"], Float[Array, "n_frames nv"]
    ]:
        """Return qpos, qvel and qacc, the inverse of :meth:`from_mujoco`; never singular."""
        qpos = self.human.from_coordinates(self.names, q)
        omega, alpha = pelvis_rates_to_free_joint(q[:, :3], qd[:, :3], qdd[:, :3])
        qvel = np.hstack([qd[:, 3:6] @ OPENSIM_TO_WORLD.T, omega, qd[:, 6:]])
        qacc = np.hstack([qdd[:, 3:6] @ OPENSIM_TO_WORLD.T, alpha, qdd[:, 6:]])
        return qpos, qvel, qacc

    def frames(self) -> "casadi.Function":
        """Return q ↦ ``position`` (3, n_bodies) [m] and ``rotation`` (3, 3 n_bodies).

        Bodies are in the order of :attr:`Human.body_names`; columns ``3 i`` to ``3 i + 2`` of
        ``rotation`` map the axes of body ``i`` to world axes.
        """

        def build(ca: Any, q: Any):
            every = range(len(self._tree.links))
            rotation, position = self._tree.frames(ca, q, self._tree.turns(ca, q), every)
            return {
                "position": ca.horzcat(*(position[i] for i in every)),
                "rotation": ca.horzcat(*(rotation[i] for i in every)),
            }

        return self._function("frames", ("q",), build)

    def angular_velocities(self) -> "casadi.Function":
        """Return (q, qd) ↦ ``angular_velocity`` (3, n_bodies) of every body, world [rad/s]."""

        def build(ca: Any, q: Any, qd: Any):
            every = range(len(self._tree.links))
            turns = self._tree.turns(ca, q)
            rotation, _ = self._tree.frames(ca, q, turns, every)
            state = self._tree.outward_pass(ca, turns, qd)
            columns = [ca.mtimes(rotation[i], state.omega[i]) for i in every]
            return {"angular_velocity": ca.horzcat(*columns)}

        return self._function("angular_velocities", ("q", "qd"), build)

    def positions(self, points: Sequence[Point]) -> "casadi.Function":
        """Return q ↦ ``position`` (3, n_points) of points, world [m]."""
        return self._of_points("position", points, "q")

    def velocities(self, points: Sequence[Point]) -> "casadi.Function":
        """Return (q, qd) ↦ ``velocity`` (3, n_points) of points, world [m/s]."""
        return self._of_points("velocity", points, "q", "qd")

    def com(self) -> "casadi.Function":
        """Return q ↦ ``com`` (3,), the whole body's centre of mass, world [m]."""

        def build(ca: Any, q: Any):
            arm = self._tree.arm(ca, self._tree.turns(ca, q))
            return {"com": self._tree.translation(ca, q) + arm}

        return self._function("com", ("q",), build)

    def momentum(self) -> "casadi.Function":
        """Return (q, qd) ↦ ``linear`` and ``angular`` momentum, each (3,), world axes.

        The linear momentum [kg m/s] is mass times the velocity of the centre of mass, about which
        the angular momentum [kg m²/s] is taken.
        """

        def build(ca: Any, q: Any, qd: Any):
            turns = self._tree.turns(ca, q)
            state = self._tree.outward_pass(ca, turns, qd)
            linear, angular = [], []
            for link, omega, velocity in zip(
                self._tree.links, state.omega, state.velocity, strict=True
            ):
                linear.append(link.mass * velocity + ca.cross(omega, link.first))
                angular.append(ca.mtimes(inertia(link), omega) + ca.cross(link.first, velocity))
            _, p, about_pelvis = self._tree.inward_pass(ca, turns, linear, angular)
            arm = self._tree.arm(ca, turns)
            return {"linear": p, "angular": about_pelvis - ca.cross(arm, p)}

        return self._function("momentum", ("q", "qd"), build)

    def inverse_dynamics(
        self, points: Sequence[Point] = (), *, root: str = "pelvis"
    ) -> "casadi.Function":
        r"""Return (q, qd, qdd, forces) ↦ ``tau`` (nv,), the required generalised forces.

        .. math:: \tau = M(q)\,\ddot q + h(q, \dot q) - \sum_k J_k^T f_k

        The first six rows are the residual at the root, zero for a body in contact with the ground
        alone. The three choices are

        * ``"pelvis"``: world force [N] and moment about the pelvis' origin, world axes [N m]. No
          posture is singular, and second derivatives take the fewest operations: best for
          constraints of an optimisation.
        * ``"com"``: the same with the moment about the centre of mass. Force and moment are then
          the rates of linear and angular momentum, which are independent: best for residuals with
          separate weights. The centre of mass depends on every coordinate, so second derivatives
          take a third more operations.
        * ``"coordinates"``: generalised forces of the pelvis angles [N m] and translations [N], in
          the order of q, with power :math:`\tau^T \dot q`; singular at a list of ±90°.

        Returns:
            Function of q, qd, qdd and, with points, ``forces`` (3, n_points): forces on the body,
            world [N].
        """

        def build(ca: Any, q: Any, qd: Any, qdd: Any, forces: Any = None):
            tau, force, moment, arm = self._tree.newton_euler(ca, points, q, qd, qdd, forces)
            first = {
                "pelvis": (force, moment),
                "com": (force, moment - ca.cross(arm, force)),
                "coordinates": (ca.vertcat(*tau[:3]), ca.mtimes(OPENSIM_TO_WORLD.T, force)),
            }[root]
            return {"tau": ca.vertcat(*first, *tau[6:])}

        if root not in ROOTS:
            raise ParameterError(f"{root=} must be one of {', '.join(ROOTS)}")
        inputs = ("q", "qd", "qdd", "forces") if points else ("q", "qd", "qdd")
        return self._function("inverse_dynamics", inputs, build, root, *points)

    def _of_points(self, name: str, points: Sequence[Point], *inputs: str) -> "casadi.Function":
        """Return positions or velocities, depending on the number of inputs."""

        def build(ca: Any, *state: Any):
            return {name: self._tree.points(ca, points, *state)[len(inputs) - 1]}

        return self._function(name, inputs, build, *points)

    def _function(
        self, name: str, inputs: tuple[str, ...], build: Callable, *key: Any
    ) -> "casadi.Function":
        """Return the cached function that ``build`` makes from symbols.

        Raises:
            MissingExtra: If CasADi is not installed.
        """
        ca = require("casadi", "synthesis")
        points = [each for each in key if isinstance(each, Point)]
        if (name, *key) not in self._functions:
            for point in points:
                self.human.body(point.body)  # raises for an unknown body
            symbols = [self._symbol(ca, i, len(points)) for i in inputs]
            outputs = build(ca, *symbols)
            self._functions[(name, *key)] = ca.Function(
                name, symbols, list(outputs.values()), list(inputs), list(outputs)
            )
        return self._functions[(name, *key)]

    def _symbol(self, ca: Any, name: str, n_points: int) -> Any:
        """Return an input; coordinates and rates are the same symbols in all functions."""
        if name == "forces":
            return ca.SX.sym(name, 3, n_points)
        if name not in self._symbols:
            self._symbols[name] = ca.SX.sym(name, self.nv)
        return self._symbols[name]

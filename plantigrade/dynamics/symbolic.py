r"""The equations of motion of one person as CasADi expressions, for optimisation.

They are generated from the compiled MuJoCo model, so that every :class:`Human` has them, and are
smooth in plain vectors: the quaternion of the free joint is replaced by OpenSim's pelvis angles.

**Coordinates.** :math:`q`, :math:`\dot q` and :math:`\ddot q` are vectors of length ``nv`` in the
order of :meth:`~plantigrade.models.Human.to_coordinates`: ``pelvis_tilt``, ``pelvis_list``,
``pelvis_rotation`` [rad], ``pelvis_tx``, ``pelvis_ty``, ``pelvis_tz`` [m] in OpenSim's axes
(forward, up, right), then the hinges [rad] as MuJoCo orders them. The pelvis is turned by

.. math:: R = R_y(-\mathrm{tilt})\, R_x(\mathrm{list})\, R_z(\mathrm{rotation}).

At a list of ±90° the axes of tilt and rotation coincide: rates are no longer unique, and forces of
these two coordinates cannot be told apart. Wrenches in world axes do not suffer from that.

**Method.** Every body has its own axes. With angular velocity :math:`\omega`, its derivative
:math:`\alpha`, and the acceleration :math:`a` of the body's origin (gravity is an acceleration of
the world), a point :math:`r` of the body accelerates by

.. math:: a + U r, \qquad U = \hat\alpha + \hat\omega\hat\omega,

and a body of mass :math:`m`, first moment :math:`h = \int r\,dm` and second moment
:math:`\Sigma = \int r r^T dm` asks for a force and a moment about its origin of

.. math:: f = m a + U h, \qquad
    n = h \times a + \mathrm{vex}(U\Sigma - (U\Sigma)^T).

Going outwards gives :math:`\omega, \alpha, a`, coming back gives :math:`f, n`, and a hinge with
axis :math:`e` bears :math:`e^T n`: the recursive Newton–Euler algorithm [Featherstone2008]_. The
pelvis angles are its first three hinges.

Bodies keep MuJoCo's axes, in which most hinges turn about x, y or z: such a turn costs six
operations a vector, against fifteen for an oblique axis. CasADi drops what is multiplied by zero
while the expressions are made. Where expressions of several functions meet in one, ``casadi.cse``
merges the parts they share.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.site import Point
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.spatial.conventions import (
    OPENSIM_TO_WORLD,
    PELVIS,
    free_joint_to_pelvis_rates,
    pelvis_rates_to_free_joint,
    rotation_matrix,
)

if TYPE_CHECKING:
    import casadi
    import mujoco

ROOTS = ("pelvis", "com", "coordinates")
_ROUNDING = 1e-13  # constants this much smaller than their neighbours are rounding of zero


@dataclass(frozen=True)
class _Link:
    """A moving body as constants, in its own axes.

    Attributes:
        parent: Index of the parent link; -1 is the world.
        offset: Origin in the parent's frame (3, 1) [m].
        turn: Fixed rotation to the parent's axes (3, 3); None if they are the same.
        hinges: (index in q, axis) of every hinge, in order.
        mass: Mass [kg].
        first: First moment of mass about the origin (3, 1) [kg m].
        second: Second moment of mass about the origin (3, 3) [kg m²].
    """

    parent: int
    offset: Array
    turn: Array | None
    hinges: tuple[tuple[int, Array], ...]
    mass: float
    first: Array
    second: Array


@dataclass
class _State:
    """What the way outwards finds, one entry a link; vectors in the link's axes."""

    omega: list[Any]  # [rad/s]
    alpha: list[Any]  # [rad/s²]
    velocity: list[Any]  # of the origin [m/s]
    U: list[Any]  # [1/s²]
    acceleration: list[Any]  # of the origin [m/s²]


class SymbolicHuman:
    """One person's kinematics and dynamics as CasADi functions of q, qd and qdd.

    Every method returns a :class:`casadi.Function`, built at the first call and kept. Points and
    forces are columns. World axes throughout: x forward, y left, z up.

    Args:
        human: The person.
        gravity: Gravity [m/s²], world axes; the model's if absent.

    Attributes:
        human: The person.
        nv: Number of coordinates.
        names: Their names, in the order of q.
        mass: Body mass of the model [kg].
        gravity: Gravity [m/s²], world axes.

    Raises:
        ParameterError: If the model is more than a free pelvis with hinges at the bodies' origins.

    Example:
        >>> body = SymbolicHuman(Human.create(1.74, 70.0))
        >>> q = np.zeros(body.nv)
        >>> wrench = body.root_wrench()(q, 0 * q, 0 * q)
        >>> round(float(wrench[2]), 6)  # the ground must carry the weight [N]
        686.7
    """

    def __init__(self, human: Human, gravity: Float[Array, " 3"] | None = None):
        model = human.model
        self.human = human
        self.nv: int = model.nv
        self.names: tuple[str, ...] = PELVIS + human.coordinates
        self.mass = float(model.body_mass[1:].sum())
        self.gravity = np.array(model.opt.gravity if gravity is None else gravity, dtype=float)
        self._links = _links(model)
        self._functions: dict[tuple, Any] = {}

    # Conversions ------------------------------------------------------------------------------

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
            ParameterError: If the pelvis lists by 90°, where the rates of its angles are not
                unique.
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
        """Return qpos, qvel and qacc; the inverse of :meth:`from_mujoco`, without exceptions."""
        qpos = self.human.from_coordinates(self.names, q)
        omega, alpha = pelvis_rates_to_free_joint(q[:, :3], qd[:, :3], qdd[:, :3])
        qvel = np.hstack([qd[:, 3:6] @ OPENSIM_TO_WORLD.T, omega, qd[:, 6:]])
        qacc = np.hstack([qdd[:, 3:6] @ OPENSIM_TO_WORLD.T, alpha, qdd[:, 6:]])
        return qpos, qvel, qacc

    # Kinematics -------------------------------------------------------------------------------

    def frames(self) -> "casadi.Function":
        """Return q ↦ ``position`` (3, n_bodies) [m] and ``rotation`` (3, 3 n_bodies).

        Bodies are in the order of :attr:`Human.body_names`; columns ``3 i`` to ``3 i + 2`` of
        ``rotation`` map the axes of body ``i`` to world axes.
        """

        def build(ca: Any, q: Any):
            every = range(len(self._links))
            rotation, position = self._frames(ca, q, self._turns(ca, q), every)
            return {
                "position": ca.horzcat(*(position[i] for i in every)),
                "rotation": ca.horzcat(*(rotation[i] for i in every)),
            }

        return self._function("frames", ("q",), build)

    def angular_velocities(self) -> "casadi.Function":
        """Return (q, qd) ↦ ``angular_velocity`` (3, n_bodies) of every body, world [rad/s]."""

        def build(ca: Any, q: Any, qd: Any):
            every = range(len(self._links))
            turns = self._turns(ca, q)
            rotation, _ = self._frames(ca, q, turns, every)
            state = self._outwards(ca, turns, qd)
            columns = [ca.mtimes(rotation[i], state.omega[i]) for i in every]
            return {"angular_velocity": ca.horzcat(*columns)}

        return self._function("angular_velocities", ("q", "qd"), build)

    def positions(self, points: Sequence[Point]) -> "casadi.Function":
        """Return q ↦ ``position`` (3, n_points) of points, world [m]."""

        def build(ca: Any, q: Any):
            return {"position": self._points(ca, points, q)[0]}

        return self._function("positions", ("q",), build, *points)

    def velocities(self, points: Sequence[Point]) -> "casadi.Function":
        """Return (q, qd) ↦ ``velocity`` (3, n_points) of points, world [m/s]."""

        def build(ca: Any, q: Any, qd: Any):
            return {"velocity": self._points(ca, points, q, qd)[1]}

        return self._function("velocities", ("q", "qd"), build, *points)

    def accelerations(self, points: Sequence[Point]) -> "casadi.Function":
        """Return (q, qd, qdd) ↦ ``acceleration`` (3, n_points) of points, world [m/s²]."""

        def build(ca: Any, q: Any, qd: Any, qdd: Any):
            return {"acceleration": self._points(ca, points, q, qd, qdd)[2]}

        return self._function("accelerations", ("q", "qd", "qdd"), build, *points)

    def com(self) -> "casadi.Function":
        """Return q ↦ ``com`` (3,), the whole body's centre of mass, world [m]."""

        def build(ca: Any, q: Any):
            return {"com": self._translation(ca, q) + self._arm(ca, self._turns(ca, q))}

        return self._function("com", ("q",), build)

    # Dynamics ---------------------------------------------------------------------------------

    def momentum(self) -> "casadi.Function":
        """Return (q, qd) ↦ ``linear`` and ``angular`` momentum, each (3,), world axes.

        The linear momentum [kg m/s] is mass times the velocity of the centre of mass, about which
        the angular momentum [kg m²/s] is taken.
        """

        def build(ca: Any, q: Any, qd: Any):
            turns = self._turns(ca, q)
            state = self._outwards(ca, turns, qd)
            linear, angular = [], []
            for link, omega, velocity in zip(self._links, state.omega, state.velocity, strict=True):
                linear.append(link.mass * velocity + ca.cross(omega, link.first))
                angular.append(ca.mtimes(_inertia(link), omega) + ca.cross(link.first, velocity))
            _, p, about_pelvis = self._inwards(ca, turns, linear, angular)
            arm = self._arm(ca, turns)
            return {"linear": p, "angular": about_pelvis - ca.cross(arm, p)}

        return self._function("momentum", ("q", "qd"), build)

    def energy(self) -> "casadi.Function":
        """Return (q, qd) ↦ ``kinetic`` and ``potential`` energy [J].

        The potential energy is zero where the centre of mass is at the world's origin.
        """

        def build(ca: Any, q: Any, qd: Any):
            turns = self._turns(ca, q)
            state = self._outwards(ca, turns, qd)
            kinetic = 0
            for link, omega, v in zip(self._links, state.omega, state.velocity, strict=True):
                kinetic += 0.5 * link.mass * ca.dot(v, v)
                kinetic += ca.dot(v, ca.cross(omega, link.first))
                kinetic += 0.5 * ca.dot(omega, ca.mtimes(_inertia(link), omega))
            com = self._translation(ca, q) + self._arm(ca, turns)
            return {"kinetic": kinetic, "potential": -self.mass * ca.dot(self.gravity, com)}

        return self._function("energy", ("q", "qd"), build)

    def inverse_dynamics(
        self, points: Sequence[Point] = (), *, root: str = "pelvis"
    ) -> "casadi.Function":
        r"""Return (q, qd, qdd, forces) ↦ ``tau`` (nv,), what the joints must do.

        .. math:: \tau = M(q)\,\ddot q + h(q, \dot q) - \sum_k J_k^T f_k

        The first six rows are what is missing at the root; they must be zero for a body that only
        the ground touches. The three choices are zero together. They are

        * ``"pelvis"``: world force [N] and moment about the pelvis' origin, world axes [N m]. No
          posture is singular, and second derivatives take the fewest operations: best as rows of
          an optimisation.
        * ``"com"``: the same with the moment about the centre of mass. Force and moment are then
          the rates of linear and angular momentum and independent of each other: best to report
          residuals, and its two kinds of rows can be weighed apart. The centre of mass depends on
          every coordinate, so second derivatives take a third more operations.
        * ``"coordinates"``: generalised forces of the pelvis angles [N m] and translations [N], in
          the order of q, so that power is :math:`\tau^T \dot q`; singular where the angles are.

        Args:
            points: Where forces act.
            root: What the first six rows are.

        Returns:
            Function of q, qd, qdd and, where there are points, ``forces`` (3, n_points): forces
            on the body, world [N].
        """

        def build(ca: Any, q: Any, qd: Any, qdd: Any, forces: Any = None):
            tau, force, moment, arm = self._newton_euler(ca, points, q, qd, qdd, forces)
            first = {
                "pelvis": (force, moment),
                "com": (force, moment - ca.cross(arm, force)),
                "coordinates": (ca.vertcat(*tau[:3]), ca.mtimes(OPENSIM_TO_WORLD.T, force)),
            }[root]
            return {"tau": ca.vertcat(*first, *tau[6:])}

        _check_root(root, ROOTS)
        inputs = ("q", "qd", "qdd", "forces") if points else ("q", "qd", "qdd")
        return self._function("inverse_dynamics", inputs, build, root, *points)

    def root_wrench(
        self, points: Sequence[Point] = (), *, root: str = "pelvis"
    ) -> "casadi.Function":
        """Return (q, qd, qdd, forces) ↦ ``wrench`` (6,) that is missing at the root.

        World force [N] and moment [N m], the first six rows of :meth:`inverse_dynamics` without
        the others. Without points there are no ``forces``, and the wrench is what the motion asks
        of the ground.

        Args:
            points: Where forces act.
            root: ``"pelvis"`` or ``"com"``: what the moment is about.
        """
        _check_root(root, ROOTS[:2])

        def build(ca: Any, q: Any, qd: Any, qdd: Any, forces: Any = None):
            _, force, moment, arm = self._newton_euler(ca, points, q, qd, qdd, forces)
            if root == "com":
                moment = moment - ca.cross(arm, force)
            return {"wrench": ca.vertcat(force, moment)}

        inputs = ("q", "qd", "qdd", "forces") if points else ("q", "qd", "qdd")
        return self._function("root_wrench", inputs, build, root, *points)

    def zero_moment_point(self, ground: float = 0.0) -> "casadi.Function":
        r"""Return (q, qd, qdd) ↦ ``zmp`` (2,): x and y on the ground, world [m].

        .. math:: p_x = c_x - \frac{(c_z - z) F_x + M_y}{F_z}, \qquad
            p_y = c_y - \frac{(c_z - z) F_y - M_x}{F_z}

        with the force :math:`F` and the moment :math:`M` about the pelvis' origin :math:`c` that
        the motion asks for. In free fall, where :math:`F_z = 0`, the division has no finite result.

        Args:
            ground: Height :math:`z` of the level ground [m].
        """

        def build(ca: Any, q: Any, qd: Any, qdd: Any):
            _, force, moment, arm = self._newton_euler(ca, (), q, qd, qdd, None)
            pelvis = self._translation(ca, q)
            drop = pelvis[2] - ground
            x = pelvis[0] - (drop * force[0] + moment[1]) / force[2]
            y = pelvis[1] - (drop * force[1] - moment[0]) / force[2]
            return {"zmp": ca.vertcat(x, y)}

        return self._function("zero_moment_point", ("q", "qd", "qdd"), build, float(ground))

    # Recursions -------------------------------------------------------------------------------

    def _function(
        self, name: str, inputs: tuple[str, ...], build: Callable, *key: Any
    ) -> "casadi.Function":
        """Return a function made by ``build`` from symbols, or the one made before."""
        import casadi as ca

        points = [each for each in key if isinstance(each, Point)]
        if (name, *key) not in self._functions:
            for point in points:
                self.human.body(point.body)  # refuses what does not exist
            symbols = [
                ca.SX.sym(i, 3, len(points)) if i == "forces" else ca.SX.sym(i, self.nv)
                for i in inputs
            ]
            outputs = build(ca, *symbols)
            self._functions[(name, *key)] = ca.Function(
                name, symbols, list(outputs.values()), list(inputs), list(outputs)
            )
        return self._functions[(name, *key)]

    def _translation(self, ca: Any, q: Any):
        """Return the pelvis' origin, a derivative of it if given one of q; world."""
        return ca.mtimes(_sparse(ca, OPENSIM_TO_WORLD), q[3:6])

    def _turns(self, ca: Any, q: Any) -> list[list[Any]]:
        """Return for every hinge of every link the rotation to the axes before it."""
        return [[_turn(ca, axis, q[i]) for i, axis in link.hinges] for link in self._links]

    def _frames(
        self, ca: Any, q: Any, turns: list[list[Any]], wanted: Any
    ) -> tuple[dict[int, Any], dict[int, Any]]:
        """Return rotations to world axes and origins of the wanted links and all before them."""
        rotation: dict[int, Any] = {}
        position: dict[int, Any] = {}
        needed = set(wanted)
        for i in reversed(range(len(self._links))):
            if i in needed and self._links[i].parent >= 0:
                needed.add(self._links[i].parent)
        for i in sorted(needed):
            link = self._links[i]
            if link.parent < 0:
                R, p = ca.SX.eye(3), self._translation(ca, q)
            else:
                R = rotation[link.parent]
                p = position[link.parent] + ca.mtimes(R, _sparse(ca, link.offset))
            if link.turn is not None:
                R = ca.mtimes(R, link.turn)
            for turn in turns[i]:
                R = ca.mtimes(R, turn)
            rotation[i], position[i] = R, p
        return rotation, position

    def _points(self, ca: Any, points: Sequence[Point], q: Any, qd: Any = None, qdd: Any = None):
        """Return positions, velocities and accelerations of points, each (3, n_points)."""
        links = [self.human.body(p.body) - 1 for p in points]
        turns = self._turns(ca, q)
        rotation, origin = self._frames(ca, q, turns, links)
        state = None if qd is None else self._outwards(ca, turns, qd, qdd)
        columns: tuple[list[Any], ...] = ([], [], [])
        for i, point in zip(links, points, strict=True):
            R = rotation[i]
            down = ca.DM([0.0, 0.0, -point.radius])
            local = _sparse(ca, np.array(point.position).reshape(3, 1))
            columns[0].append(origin[i] + ca.mtimes(R, local) + down)
            if state is None:
                continue
            r = local + ca.mtimes(R.T, down)  # to the same point, in the body's axes
            v = state.velocity[i] + ca.cross(state.omega[i], r)
            columns[1].append(ca.mtimes(R, v))
            if qdd is not None:
                a = state.acceleration[i] + ca.mtimes(state.U[i], r)
                columns[2].append(ca.mtimes(R, a))
        return tuple(ca.horzcat(*c) if c else ca.SX(3, 0) for c in columns)

    def _outwards(
        self,
        ca: Any,
        turns: list[list[Any]],
        qd: Any,
        qdd: Any = None,
        gravity: Array | None = None,
    ) -> _State:
        """Return the motion of every link; accelerations mean something with qdd only."""
        state = _State([], [], [], [], [])
        qdd = ca.SX(self.nv, 1) if qdd is None else qdd
        for k, link in enumerate(self._links):
            if link.parent < 0:
                omega, alpha = ca.SX.zeros(3), ca.SX.zeros(3)
                v, a = self._translation(ca, qd), self._translation(ca, qdd)
                if gravity is not None:
                    a = a - gravity
            else:
                r = _sparse(ca, link.offset)
                omega, alpha = state.omega[link.parent], state.alpha[link.parent]
                v = state.velocity[link.parent] + ca.cross(omega, r)
                a = state.acceleration[link.parent] + ca.mtimes(state.U[link.parent], r)
            if link.turn is not None:
                omega, alpha, v, a = (ca.mtimes(link.turn.T, x) for x in (omega, alpha, v, a))
            for (i, axis), R in zip(link.hinges, turns[k], strict=True):
                omega, alpha, v, a = (ca.mtimes(R.T, x) for x in (omega, alpha, v, a))
                e = _sparse(ca, axis)
                alpha = alpha + e * qdd[i] + ca.cross(omega * qd[i], e)
                omega = omega + e * qd[i]
            state.omega.append(omega)
            state.alpha.append(alpha)
            state.velocity.append(v)
            state.U.append(_rates_of_place(ca, omega, alpha))
            state.acceleration.append(a)
        return state

    def _inwards(
        self, ca: Any, turns: list[list[Any]], forces: list[Any], moments: list[Any]
    ) -> tuple[list[Any], Any, Any]:
        """Add up forces and moments (or momenta) from the ends of the limbs to the world.

        Args:
            ca: CasADi.
            turns: From :meth:`_turns`.
            forces: One a link, in its axes; the list is used up.
            moments: About the links' origins; the list is used up.

        Returns:
            What each hinge bears about its axis, in the order of q; the sum of all forces and of
            all moments about the pelvis' origin, world axes.
        """
        borne: list[Any] = [0] * self.nv
        for k in reversed(range(len(self._links))):
            link, f, n = self._links[k], forces[k], moments[k]
            for (i, axis), R in zip(reversed(link.hinges), reversed(turns[k]), strict=True):
                borne[i] = ca.dot(axis, n)
                f, n = ca.mtimes(R, f), ca.mtimes(R, n)
            if link.turn is not None:
                f, n = ca.mtimes(link.turn, f), ca.mtimes(link.turn, n)
            if link.parent < 0:
                return borne, f, n
            forces[link.parent] = forces[link.parent] + f
            moments[link.parent] = moments[link.parent] + n + ca.cross(_sparse(ca, link.offset), f)
        raise AssertionError("no link hangs on the world")

    def _arm(self, ca: Any, turns: list[list[Any]]):
        """Return the centre of mass less the pelvis' origin, world axes."""
        first: list[Any] = [_sparse(ca, link.first) for link in self._links]
        heavier = [link.mass for link in self._links]
        for k in reversed(range(len(self._links))):
            link, h = self._links[k], first[k]
            for R in reversed(turns[k]):
                h = ca.mtimes(R, h)
            if link.turn is not None:
                h = ca.mtimes(link.turn, h)
            if link.parent < 0:
                return h / self.mass
            heavier[link.parent] += heavier[k]
            first[link.parent] = first[link.parent] + h + heavier[k] * _sparse(ca, link.offset)
        raise AssertionError("no link hangs on the world")

    def _newton_euler(
        self, ca: Any, points: Sequence[Point], q: Any, qd: Any, qdd: Any, external: Any
    ) -> tuple[list[Any], Any, Any, Any]:
        """Return hinge moments, root force and moment about the pelvis' origin, and the arm."""
        turns = self._turns(ca, q)
        state = self._outwards(ca, turns, qd, qdd, self.gravity)
        forces, moments = [], []
        for link, U, a in zip(self._links, state.U, state.acceleration, strict=True):
            h, S = _sparse(ca, link.first), _sparse(ca, link.second)
            US = ca.mtimes(U, S)
            spin = ca.vertcat(US[2, 1] - US[1, 2], US[0, 2] - US[2, 0], US[1, 0] - US[0, 1])
            forces.append(link.mass * a + ca.mtimes(U, h))
            moments.append(spin + ca.cross(h, a))
        loads = self._loads(ca, points, q, turns, external)
        for i, (f, n) in loads.items():
            forces[i], moments[i] = forces[i] - f, moments[i] - n
        tau, force, moment = self._inwards(ca, turns, forces, moments)
        return tau, force, moment, self._arm(ca, turns)

    def _loads(
        self, ca: Any, points: Sequence[Point], q: Any, turns: list[list[Any]], external: Any
    ) -> dict[int, tuple[Any, Any]]:
        r"""Return forces and moments about the origin of every loaded link, in its axes.

        With forces :math:`f_k` at points :math:`r_k` of a body turned by :math:`R`, the moment is
        :math:`\sum_k r_k \times R^T f_k = \mathrm{vex}((DR)^T - DR)` with
        :math:`D = \sum_k r_k f_k^T`, so that only one rotation is needed for all of them.
        """
        columns: dict[int, list[int]] = {}
        for k, point in enumerate(points):
            columns.setdefault(self.human.body(point.body) - 1, []).append(k)
        rotation, _ = self._frames(ca, q, turns, columns)
        loads = {}
        for i, each in columns.items():
            D, total, below = ca.SX.zeros(3, 3), ca.SX.zeros(3), ca.SX.zeros(3)
            for k in each:
                f, rho = external[:, k], points[k].radius
                D = D + ca.mtimes(_sparse(ca, np.array(points[k].position)), f.T)
                below = below + ca.vertcat(rho * f[1], -rho * f[0], 0)  # (0, 0, -rho) x f
                total = total + f
            DR = ca.mtimes(D, rotation[i])
            turn = ca.vertcat(DR[1, 2] - DR[2, 1], DR[2, 0] - DR[0, 2], DR[0, 1] - DR[1, 0])
            loads[i] = (
                ca.mtimes(rotation[i].T, total),
                turn + ca.mtimes(rotation[i].T, below),
            )
        return loads


def _rates_of_place(ca: Any, omega: Any, alpha: Any):
    """Return U, which gives a point's acceleration from its place in the body (3, 3) [1/s²]."""
    x, y, z = (omega[i] for i in range(3))
    a, b, c = (alpha[i] for i in range(3))
    xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
    return ca.blockcat(
        [
            [-yy - zz, xy - c, xz + b],
            [xy + c, -xx - zz, yz - a],
            [xz - b, yz + a, -xx - yy],
        ]
    )


def _sparse(ca: Any, values: Array):
    """Return constants without their zeros, so that CasADi leaves these products out."""
    return ca.sparsify(ca.DM(values))


def _turn(ca: Any, axis: Array, angle: Any):
    r"""Return the rotation about an axis, :math:`c I + s \hat e + (1 - c) e e^T` (3, 3)."""
    c, s = ca.cos(angle), ca.sin(angle)
    along = np.flatnonzero(axis)
    if len(along) == 1:  # a frame's own axis: the four entries of a plane turn
        k = int(along[0])
        i, j = (k + 1) % 3, (k + 2) % 3
        s = float(axis[k]) * s
        R = ca.SX(3, 3)
        R[k, k], R[i, i], R[j, j], R[i, j], R[j, i] = 1, c, c, -s, s
        return R
    v = 1 - c
    R = ca.SX.zeros(3, 3)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        R[i, i] = axis[i] ** 2 + (1 - axis[i] ** 2) * c
        mixed, turned = float(axis[i] * axis[j]) * v, float(axis[k]) * s
        R[i, j], R[j, i] = mixed - turned, mixed + turned
    return R


def _inertia(link: _Link) -> Array:
    """Return the rotational inertia about a link's origin (3, 3) [kg m²]."""
    return np.trace(link.second) * np.eye(3) - link.second


def _links(model: "mujoco.MjModel") -> tuple[_Link, ...]:
    """Return the bodies of a model, the pelvis' angles as the hinges of the first.

    Raises:
        ParameterError: If the model is more than a free body with hinges at the bodies' origins.
    """
    import mujoco

    hinge = int(mujoco.mjtJoint.mjJNT_HINGE)
    passive = (model.dof_damping, model.dof_armature, model.dof_frictionloss, model.jnt_stiffness)
    fine = (
        np.count_nonzero(model.body_parentid[1:] == 0) == 1
        and int(model.jnt_bodyid[0]) == 1
        and model.nq == model.nv + 1 == model.njnt + 6  # one free joint
        and np.all(model.jnt_type[1:] == hinge)
        and not np.any(model.jnt_pos)
        and not any(np.any(each) for each in passive)
    )
    if not fine:
        raise ParameterError(
            "a symbolic model is one free pelvis with hinges at the origins of their bodies and no "
            "springs, dampers or armature; this MuJoCo model has something else"
        )
    links = []
    for b in range(1, model.nbody):
        if b == 1:
            axes = -np.eye(3)[1], np.eye(3)[0], np.eye(3)[2]  # tilt, list, rotation
            hinges = tuple(enumerate(axes))
        else:
            first, count = int(model.body_jntadr[b]), int(model.body_jntnum[b])
            joints = range(first, first + count)
            hinges = tuple(
                (int(model.jnt_dofadr[j]), _clean(model.jnt_axis[j], 1.0)) for j in joints
            )
        quat = model.body_quat[b]
        aligned = b == 1 or bool(np.all(quat[1:] == 0.0))
        mass, com = float(model.body_mass[b]), np.array(model.body_ipos[b])
        axes_of_inertia = rotation_matrix(np.array(model.body_iquat[b]))
        central = axes_of_inertia @ np.diag(model.body_inertia[b]) @ axes_of_inertia.T
        second = 0.5 * np.trace(central) * np.eye(3) - central + mass * np.outer(com, com)
        links.append(
            _Link(
                int(model.body_parentid[b]) - 1,
                _clean(model.body_pos[b], 1.0),
                None if aligned else rotation_matrix(np.array(quat)),
                hinges,
                mass,
                _clean(mass * com, mass),
                _clean(second, float(np.trace(second))),
            )
        )
    return tuple(links)


def _check_root(root: str, allowed: tuple[str, ...]) -> None:
    if root not in allowed:
        raise ParameterError(f"{root=} must be one of {', '.join(allowed)}")


def _clean(values: Array, scale: float) -> Array:
    """Return values with those that are only rounding beside ``scale`` set to zero."""
    values = np.array(values, float)
    return np.where(np.abs(values) < _ROUNDING * scale, 0.0, values)

r"""Recursions over the bodies of a person, as CasADi expressions.

Every body has its own axes. With angular velocity :math:`\omega`, its derivative
:math:`\alpha`, and the acceleration :math:`a` of the body's origin (gravity is an acceleration of
the world), a point :math:`r` of the body accelerates by

.. math:: a + U r, \qquad U = \hat\alpha + \hat\omega\hat\omega,

and a body of mass :math:`m`, first moment :math:`h = \int r\,dm` and second moment
:math:`\Sigma = \int r r^T dm` requires a force and a moment about its origin of

.. math:: f = m a + U h, \qquad
    n = h \times a + \mathrm{vex}(U\Sigma - (U\Sigma)^T).

The outward pass gives :math:`\omega, \alpha, a`, the inward pass :math:`f, n`, and a hinge with
axis :math:`e` transmits the moment :math:`e^T n`: the recursive Newton–Euler algorithm
[Featherstone2008]_. The pelvis angles are the first three hinges.

Bodies keep MuJoCo's axes, in which most hinges rotate about x, y or z; such a rotation costs six
operations per vector, an oblique axis fifteen. CasADi drops products with zero when expressions are
built; ``casadi.cse`` merges common subexpressions of several functions.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.site import Point
from plantigrade.dynamics.links import links_of
from plantigrade.models import Human
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD


@dataclass
class LinkMotion:
    """Result of the outward pass, one entry per link; vectors in the link's axes."""

    omega: list[Any]  # [rad/s]
    alpha: list[Any]  # [rad/s²]
    velocity: list[Any]  # of the origin [m/s]
    U: list[Any]  # [1/s²]
    acceleration: list[Any]  # of the origin [m/s²]


class LinkTree:
    """The bodies of one person, from the pelvis to the ends of the limbs.

    Every method takes CasADi and symbols and returns expressions.

    Args:
        gravity: Gravity [m/s²], world axes.

    Attributes:
        human: The person.
        links: The bodies, parents first.
        nv: Number of coordinates.
        mass: Body mass [kg].
        gravity: Gravity [m/s²], world axes.

    Raises:
        ParameterError: If the model is not a free pelvis with hinges at the bodies' origins.
    """

    def __init__(self, human: Human, gravity: Float[Array, " 3"]):
        self.human, self.links = human, links_of(human.model)
        self.nv, self.gravity = human.model.nv, gravity
        self.mass = float(human.model.body_mass[1:].sum())
        self._kept: dict[str, tuple[tuple[Any, ...], Any]] = {}

    def _once(self, name: str, given: tuple[Any, ...], make: Callable[[], Any]) -> Any:
        """Return what was made from the same expressions before: functions of a body share much."""
        before = self._kept.get(name, ((), None))[0]
        if len(before) != len(given) or any(a is not b for a, b in zip(before, given, strict=True)):
            self._kept[name] = given, make()
        return self._kept[name][1]

    def translation(self, ca: Any, q: Any):
        """Return the pelvis' origin, or its derivative for a derivative of q; world."""
        return ca.mtimes(sparse(ca, OPENSIM_TO_WORLD), q[3:6])

    def turns(self, ca: Any, q: Any) -> list[list[Any]]:
        """Return for every hinge of every link the rotation to the preceding axes."""
        return self._once(
            "turns",
            (q,),
            lambda: [[_turn(ca, axis, q[i]) for i, axis in link.hinges] for link in self.links],
        )

    def frames(
        self, ca: Any, q: Any, turns: list[list[Any]], links: Any
    ) -> tuple[dict[int, Any], dict[int, Any]]:
        """Return rotations to world axes and origins of links, the given and their ancestors."""
        rotation, position = self._once("frames", (q, turns), lambda: ({}, {}))
        needed = set(links)
        for i in reversed(range(len(self.links))):
            if i in needed and self.links[i].parent >= 0:
                needed.add(self.links[i].parent)
        for i in sorted(needed - set(rotation)):
            link = self.links[i]
            if link.parent < 0:
                R, p = ca.SX.eye(3), self.translation(ca, q)
            else:
                R = rotation[link.parent]
                p = position[link.parent] + ca.mtimes(R, sparse(ca, link.offset))
            if link.turn is not None:
                R = ca.mtimes(R, link.turn)
            for turn in turns[i]:
                R = ca.mtimes(R, turn)
            rotation[i], position[i] = R, p
        return rotation, position

    def points(self, ca: Any, points: Sequence[Point], q: Any, qd: Any = None):
        """Return positions and, with ``qd``, velocities of points, each (3, n_points)."""
        links = [self.human.body(p.body) - 1 for p in points]
        turns = self.turns(ca, q)
        rotation, origin = self.frames(ca, q, turns, links)
        state = None if qd is None else self.outward_pass(ca, turns, qd)
        columns: tuple[list[Any], ...] = ([], [])
        for i, point in zip(links, points, strict=True):
            R = rotation[i]
            down = ca.DM([0.0, 0.0, -point.radius])
            local = sparse(ca, np.array(point.position).reshape(3, 1))
            columns[0].append(origin[i] + ca.mtimes(R, local) + down)
            if state is None:
                continue
            r = local + ca.mtimes(R.T, down)  # to the same point, in the body's axes
            v = state.velocity[i] + ca.cross(state.omega[i], r)
            columns[1].append(ca.mtimes(R, v))
        return tuple(ca.horzcat(*c) if c else ca.SX(3, 0) for c in columns)

    def outward_pass(
        self,
        ca: Any,
        turns: list[list[Any]],
        qd: Any,
        qdd: Any = None,
        gravity: Array | None = None,
    ) -> LinkMotion:
        """Return the motion of every link; accelerations are valid only with qdd."""
        if qdd is None and gravity is None:
            still = ca.SX(self.nv, 1)
            return self._once(
                "motion", (turns, qd), lambda: self._outward(ca, turns, qd, still, None)
            )
        return self._outward(ca, turns, qd, qdd, gravity)

    def _outward(
        self, ca: Any, turns: list[list[Any]], qd: Any, qdd: Any, gravity: Array | None
    ) -> LinkMotion:
        state = LinkMotion([], [], [], [], [])
        for k, link in enumerate(self.links):
            if link.parent < 0:
                omega, alpha = ca.SX.zeros(3), ca.SX.zeros(3)
                v, a = self.translation(ca, qd), self.translation(ca, qdd)
                if gravity is not None:
                    a = a - gravity
            else:
                r = sparse(ca, link.offset)
                omega, alpha = state.omega[link.parent], state.alpha[link.parent]
                v = state.velocity[link.parent] + ca.cross(omega, r)
                a = state.acceleration[link.parent] + ca.mtimes(state.U[link.parent], r)
            if link.turn is not None:
                omega, alpha, v, a = (ca.mtimes(link.turn.T, x) for x in (omega, alpha, v, a))
            for (i, axis), R in zip(link.hinges, turns[k], strict=True):
                omega, alpha, v, a = (ca.mtimes(R.T, x) for x in (omega, alpha, v, a))
                e = sparse(ca, axis)
                alpha = alpha + e * qdd[i] + ca.cross(omega * qd[i], e)
                omega = omega + e * qd[i]
            state.omega.append(omega)
            state.alpha.append(alpha)
            state.velocity.append(v)
            state.U.append(_rates_of_place(ca, omega, alpha))
            state.acceleration.append(a)
        return state

    def inward_pass(
        self, ca: Any, turns: list[list[Any]], forces: list[Any], moments: list[Any]
    ) -> tuple[list[Any], Any, Any]:
        """Accumulate forces and moments (or momenta) of the links from the ends of the limbs.

        Moments are about the links' origins. Both lists are modified.

        Returns:
            The moment of each hinge about its axis, in the order of q; the sum of all forces and of
            all moments about the pelvis' origin, world axes.
        """
        hinge_moments: list[Any] = [0] * self.nv
        for k in reversed(range(len(self.links))):
            link, f, n = self.links[k], forces[k], moments[k]
            for (i, axis), R in zip(reversed(link.hinges), reversed(turns[k]), strict=True):
                hinge_moments[i] = ca.dot(axis, n)
                f, n = ca.mtimes(R, f), ca.mtimes(R, n)
            if link.turn is not None:
                f, n = ca.mtimes(link.turn, f), ca.mtimes(link.turn, n)
            if link.parent < 0:
                return hinge_moments, f, n
            forces[link.parent] = forces[link.parent] + f
            moments[link.parent] = moments[link.parent] + n + ca.cross(sparse(ca, link.offset), f)
        raise AssertionError("no link has the world as its parent")

    def arm(self, ca: Any, turns: list[list[Any]]):
        """Return the centre of mass relative to the pelvis' origin, world axes."""
        return self._once("arm", (turns,), lambda: self._arm(ca, turns))

    def _arm(self, ca: Any, turns: list[list[Any]]):
        first: list[Any] = [sparse(ca, link.first) for link in self.links]
        subtree_mass = [link.mass for link in self.links]
        for k in reversed(range(len(self.links))):
            link, h = self.links[k], first[k]
            for R in reversed(turns[k]):
                h = ca.mtimes(R, h)
            if link.turn is not None:
                h = ca.mtimes(link.turn, h)
            if link.parent < 0:
                return h / self.mass
            subtree_mass[link.parent] += subtree_mass[k]
            first[link.parent] = first[link.parent] + h + subtree_mass[k] * sparse(ca, link.offset)
        raise AssertionError("no link has the world as its parent")

    def newton_euler(
        self, ca: Any, points: Sequence[Point], q: Any, qd: Any, qdd: Any, external: Any
    ) -> tuple[list[Any], Any, Any, Any]:
        """Return hinge moments, root force and moment about the pelvis' origin, and the arm."""
        turns = self.turns(ca, q)
        state = self.outward_pass(ca, turns, qd, qdd, self.gravity)
        forces, moments = [], []
        for link, U, a in zip(self.links, state.U, state.acceleration, strict=True):
            h, S = sparse(ca, link.first), sparse(ca, link.second)
            US = ca.mtimes(U, S)
            spin = ca.vertcat(US[2, 1] - US[1, 2], US[0, 2] - US[2, 0], US[1, 0] - US[0, 1])
            forces.append(link.mass * a + ca.mtimes(U, h))
            moments.append(spin + ca.cross(h, a))
        loads = self.loads(ca, points, q, turns, external)
        for i, (f, n) in loads.items():
            forces[i], moments[i] = forces[i] - f, moments[i] - n
        tau, force, moment = self.inward_pass(ca, turns, forces, moments)
        return tau, force, moment, self.arm(ca, turns)

    def loads(
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
        rotation, _ = self.frames(ca, q, turns, columns)
        loads = {}
        for i, each in columns.items():
            D, total, below = ca.SX.zeros(3, 3), ca.SX.zeros(3), ca.SX.zeros(3)
            for k in each:
                f, rho = external[:, k], points[k].radius
                D = D + ca.mtimes(sparse(ca, np.array(points[k].position)), f.T)
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
    """Return U, which maps a point's position in the body to its acceleration (3, 3) [1/s²]."""
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


def sparse(ca: Any, values: Array):
    """Return constants as a sparse matrix, so that CasADi omits products with zero."""
    return ca.sparsify(ca.DM(values))


def _turn(ca: Any, axis: Array, angle: Any):
    r"""Return the rotation about an axis, :math:`c I + s \hat e + (1 - c) e e^T` (3, 3)."""
    c, s = ca.cos(angle), ca.sin(angle)
    along = np.flatnonzero(axis)
    if len(along) == 1:  # a coordinate axis: the four entries of a plane rotation
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

r"""Equations of motion of the six segments on the table, and one integration step.

With the reduced mass matrix :math:`M`, bias :math:`h`, the joint torques and the force :math:`F` on
the hands,

.. math:: M(\theta)\,\ddot\theta + h(\theta, \dot\theta) =
    S^T T(\theta, \dot\theta, A) + J^T F(\theta, \dot\theta), \qquad
    \dot W = T^T \dot\theta + F^T J \dot\theta,

where the work :math:`W` is integrated together with the motion for comparison with the energy that
MuJoCo computes independently. The integrator is the classical fourth-order Runge–Kutta method;
activation is linear within a step.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from plantigrade.vaulting.joint_torques import (
    muscle_torques,
    relative_load,
    stop_torques,
    strengths,
)
from plantigrade.vaulting.segments import JOINT_NAMES, Segments
from plantigrade.vaulting.table import VaultingTable

N_JOINTS = len(JOINT_NAMES)
EXTRAS = ("force_x", "force_z", "com_vx", "com_vz", "hand_x", "hand_z", "use")
"""Outputs at the start of a step: forces [N], velocities [m/s], positions [m], and the maximum load
of a joint relative to its strength [1]."""


@dataclass(frozen=True)
class Equations:
    """The equations of one gymnast on one table, as CasADi functions."""

    segments: Segments
    table: VaultingTable

    @property
    def n(self) -> int:
        """Number of moving coordinates."""
        return len(self.segments.moving)

    @cached_property
    def _symbols(self) -> tuple[Any, Any, Any]:
        import casadi as ca

        names = ("theta", "rate", "activation")
        sizes = (self.n, self.n, N_JOINTS)
        return tuple(ca.SX.sym(name, size) for name, size in zip(names, sizes, strict=True))  # type: ignore[return-value]

    @cached_property
    def _expressions(self) -> dict[str, Any]:
        """Expressions of :attr:`_symbols`: acceleration, power, torques and :data:`EXTRAS`."""
        import casadi as ca

        theta, rate, activation = self._symbols
        tree = self.segments.tree()
        a = ca.SX.sym("a", self.n)
        q = self.segments.spread(ca, theta)
        qd, qdd = (self.segments.spread(ca, x, rates=True) for x in (rate, a))
        tau, force, _, arm = tree.newton_euler(ca, (), q, qd, qdd, None)
        all_forces = [force[0], force[2], tau[0], *tau[6:]]
        required = ca.vertcat(*(all_forces[i] for i in self.segments.moving))
        M, h = ca.jacobian(required, a), ca.substitute(required, a, ca.SX.zeros(self.n))
        hand = self.segments.hand(ca, tree, q)
        x, z = hand[0], hand[2] - self.table.table_height
        J = ca.jacobian(ca.vertcat(x, z), theta)
        v = ca.mtimes(J, rate)
        F = ca.vertcat(*self.table.force(x, z, v[0], v[1], ca))
        angle, speed = ca.vertsplit(q[6:]), ca.vertsplit(qd[6:])
        strength = strengths(self.segments.human)
        muscle = muscle_torques(strength, angle, speed, ca.vertsplit(activation), ca)
        end = stop_torques(strength, angle, speed, ca)
        joint = [m + e for m, e in zip(muscle, end, strict=True)]
        T = [ca.SX(0), ca.SX(0), ca.SX(0), *joint]
        T = ca.vertcat(*(T[i] for i in self.segments.moving))
        L = ca.chol(M).T
        acceleration = ca.solve(L.T, ca.solve(L, T + ca.mtimes(J.T, F) - h))
        com = tree.translation(ca, q) + arm
        vcom = ca.jtimes(com, theta, rate)
        return {
            "acceleration": acceleration,
            "power": ca.dot(T, rate) + ca.dot(F, v),
            "extras": ca.vertcat(F, vcom[0], vcom[2], x, z, relative_load(strength, joint, ca)),
            "torque": ca.vertcat(*muscle),
            "stop": ca.vertcat(*end),
            "com": com,
            "hand_velocity": v,
        }

    def function(self, *names: str) -> Any:
        """Return (theta, rate, activation) ↦ expressions by name."""
        import casadi as ca

        outputs = [self._expressions[name] for name in names]
        return ca.Function("of_state", [*self._symbols], outputs, {"cse": True})

    @cached_property
    def step(self) -> Any:
        """(state, activation now, activation then, step [s]) ↦ next state, :data:`EXTRAS`.

        The state is theta, its rate and the accumulated work [J].
        """
        import casadi as ca

        n = self.n
        slope = self.function("acceleration", "power", "extras")
        y, h = ca.SX.sym("state", 2 * n + 1), ca.SX.sym("h")
        now, then = ca.SX.sym("now", N_JOINTS), ca.SX.sym("then", N_JOINTS)

        def rate(state: Any, activation: Any) -> tuple[Any, Any]:
            a, power, extras = slope.call([state[:n], state[n : 2 * n], activation], True, False)
            return ca.vertcat(state[n : 2 * n], a, power), extras

        middle = 0.5 * (now + then)
        k1, extras = rate(y, now)
        k2, _ = rate(y + 0.5 * h * k1, middle)
        k3, _ = rate(y + 0.5 * h * k2, middle)
        k4, _ = rate(y + h * k3, then)
        after = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
        return ca.Function("step", [y, now, then, h], [after, extras], {"cse": True})

"""What acts on a person besides the ground and their own joints: wrenches, devices, moving ground.

Their values at a time are parameters of the dynamics, so that problems that differ in nothing else
share compiled functions, and one motion is a warm start of the next.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.plan import ContactPlan
from plantigrade.contact.site import Point
from plantigrade.spatial.conventions import OPENSIM_TO_WORLD

if TYPE_CHECKING:
    from plantigrade.dynamics.symbolic import SymbolicHuman

SLACK_ROUNDING = float(np.deg2rad(1.0))
"""Rounding of the angle at which a spring that only pulls becomes taut [rad]. Chosen."""


@runtime_checkable
class Acting(Protocol):
    """A force and a moment on a body."""

    @property
    def point(self) -> Point:
        """Where the force acts."""
        ...

    def values(self, times: Float[Array, " n"], plan: ContactPlan) -> Float[Array, "n 6"]:
        """Return force [N] and moment [N m], world axes."""
        ...


@runtime_checkable
class Worn(Protocol):
    """A device that adds torque at a joint."""

    @property
    def coordinate(self) -> str:
        """Name of the coordinate."""
        ...

    def values(self, times: Float[Array, " n"], plan: ContactPlan) -> Float[Array, "n 3"]:
        """Return torque [N m], stiffness [N m/rad] and the angle where a spring is taut [rad]."""
        ...


class External:
    """Wrenches and devices of a person who does a task."""

    def __init__(
        self,
        wrenches: Sequence[Acting] = (),
        devices: Sequence[Worn] = (),
        plan: ContactPlan | None = None,
    ):
        self.wrenches, self.devices, self.plan = tuple(wrenches), tuple(devices), plan

    @property
    def n_parameters(self) -> int:
        """Number of parameters at a time."""
        return 6 * len(self.wrenches) + 3 * len(self.devices) + 3 * self.carried

    @property
    def carried(self) -> bool:
        """Whether the ground moves, and the axes of the plan with it."""
        return self.plan is not None and self.plan.motion is not None

    def parameters(self, times: Float[Array, " n"]) -> Float[Array, "n n_parameters"]:
        """Return what acts at times, in the axes of the ground, for :meth:`taken`."""
        columns = [np.zeros((len(times), 0))]
        for each in self.wrenches:
            assert self.plan is not None
            wrench = each.values(times, self.plan)
            columns += [wrench[:, :3] @ self.plan.to_world, wrench[:, 3:] @ self.plan.to_world]
        for each in self.devices:
            assert self.plan is not None
            columns.append(each.values(times, self.plan))
        if self.plan is not None and self.plan.motion is not None:
            columns.append(self.plan.motion.acceleration(times) @ OPENSIM_TO_WORLD)
        return np.hstack(columns)

    def in_space(self, a: Any, p: Any) -> Any:
        """Return accelerations in the axes of the plan with those of moving ground (CasADi).

        Only the acceleration of the pelvis differs: axes that move with the ground do not turn.
        """
        import casadi as ca

        return ca.vertcat(a[:3], a[3:6] + p[-3:], a[6:]) if self.carried else a

    def forces(self, p: Any) -> list[Any]:
        """Return the forces among the parameters (CasADi) [N]."""
        return [p[6 * i : 6 * i + 3] for i in range(len(self.wrenches))]

    def less_moments(self, sym: "SymbolicHuman", q: Any, v: Any, p: Any, tau: Any) -> Any:
        """Return generalised forces (CasADi) less those of the moments."""
        import casadi as ca

        for i, each in enumerate(self.wrenches):
            moment = p[6 * i + 3 : 6 * i + 6]
            omega = sym.angular_velocities()(q, v)[:, sym.human.body(each.point.body) - 1]
            by_hinges = ca.jtimes(omega, v, moment, True)[6:]
            tau = tau - ca.vertcat(ca.SX.zeros(3), moment, by_hinges)
        return tau

    def torques(self, names: Sequence[str], q: Any, p: Any, root: Any = np.sqrt) -> dict[int, Any]:
        """Return the torque of the devices by hinge [N m], from angles, CasADi or arrays.

        Args:
            q: Their angles, a list of arrays or a CasADi vector [rad].
            p: Parameters, a list of arrays or a CasADi vector.
            root: Square root of that kind.
        """
        found: dict[int, Any] = {}
        for k, device in enumerate(self.devices):
            i, first = names.index(device.coordinate), 6 * len(self.wrenches) + 3 * k
            torque, stiffness, taut = p[first], p[first + 1], p[first + 2]
            over = q[i] - taut
            pulled = (over + root(over * over + SLACK_ROUNDING**2)) / 2
            found[i] = found.get(i, 0.0) + torque - stiffness * pulled
        return found

    def torque_at(
        self, names: Sequence[str], times: Float[Array, " n"], angles: Float[Array, "n n_hinges"]
    ) -> Float[Array, "n n_hinges"]:
        """Return the torque of the devices at times and angles of the hinges [N m]."""
        out, p = np.zeros(angles.shape), list(self.parameters(times).T)
        for i, torque in self.torques(names, list(angles.T), p).items():
            out[:, i] = torque
        return out

"""Contact of the hands with the table, from touchdown to take-off."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.vaulting.approach import Approach
from plantigrade.vaulting.compiled_steps import Stepper
from plantigrade.vaulting.equations import EXTRAS, N_JOINTS, Equations
from plantigrade.vaulting.segments import JOINT_NAMES, Segments
from plantigrade.vaulting.table import VaultingTable

MAX_CONTACT_TIME = 0.4
"""Maximum duration of hand contact [s]; longer contacts count as no take-off. Chosen."""
TIME_STEP = 1e-3  #: Time step of the integration [s]. Chosen
NODE_INTERVAL = 0.05  #: Interval between activation nodes [s]. Chosen
N_NODES = 6  #: Number of activation nodes per joint; the last value is held. Chosen
OVERLOAD_COST = 1.0  #: Cost of a joint load of twice the strength [m/s]. Chosen
MIN_COM_HEIGHT = 0.1
"""Minimum height of the centre of mass above the hands at touchdown [m]. Chosen."""
_FORCE_Z, _VX, _VZ, _HAND_X, _HAND_Z, _USE = (
    EXTRAS.index(name) for name in ("force_z", "com_vx", "com_vz", "hand_x", "hand_z", "use")
)


@dataclass(frozen=True, eq=False)
class HandContact:
    """A contact phase."""

    time: Float[Array, " n"]  #: Time from touchdown [s]
    #: theta, its rate and the accumulated work, for the moving coordinates
    state: Float[Array, "n ny"]
    #: Outputs in the order of :data:`~plantigrade.vaulting.equations.EXTRAS`
    extras: Float[Array, "n ne"]
    activation: Float[Array, "n 5"]  #: Activation of each joint
    left: bool  #: Whether the hands left the table; the last frame is then the take-off

    @property
    def rise(self) -> float:
        """Upward velocity of the centre of mass at the end [m/s]."""
        return float(self.extras[-1, _VZ])


@dataclass(frozen=True)
class Vault:
    """A gymnast, a table and an approach.

    Args:
        segments: The gymnast.
        table: The table.
        approach: State at touchdown.
        step: Time step [s].
    """

    segments: Segments
    table: VaultingTable
    approach: Approach
    step: float = TIME_STEP

    @cached_property
    def equations(self) -> Equations:
        """The equations of motion."""
        return Equations(self.segments, self.table)

    @cached_property
    def stepper(self) -> Stepper:
        """The integrator."""
        return Stepper(self.equations.step, end_index=_FORCE_Z)

    def __reduce__(self):
        """Pickle without machine code, which is compiled again in the other process."""
        return type(self), (self.segments, self.table, self.approach, self.step)

    def with_step(self, step: float) -> "Vault":
        """Return the same vault with another time step [s] and shared equations."""
        return self._sharing(replace(self, step=step))

    def with_approach(self, approach: Approach) -> "Vault":
        """Return the same gymnast and table with another approach."""
        if self.segments.elbow is not None and approach.elbow != self.approach.elbow:
            segments = replace(self.segments, elbow=float(approach.posture[2]))
            return replace(self, segments=segments, approach=approach)
        return self._sharing(replace(self, approach=approach))

    def _sharing(self, other: "Vault") -> "Vault":
        vars(other)["equations"], vars(other)["stepper"] = self.equations, self.stepper
        return other

    @cached_property
    def start(self) -> Float[Array, " ny"]:
        """State at touchdown: both hands on the table, at x = 0.

        Raises:
            ParameterError: If the hands would not touch the table, because they move upwards or the
                body is not above them.
        """
        moving, off = list(self.segments.moving), np.zeros(N_JOINTS)
        theta = np.r_[0.0, 0.0, self.approach.posture][moving]
        omega = np.zeros(len(moving))
        omega[2] = -self.approach.somersault
        found = self.equations.function("extras", "com", "hand_velocity")
        extras, com, _ = (x.full().ravel() for x in found(theta, omega, off))
        theta[0] -= extras[_HAND_X]
        theta[1] -= extras[_HAND_Z]
        omega[:2] = [self.approach.speed - extras[_VX], self.approach.rise - extras[_VZ]]
        down = -float(found(theta, omega, off)[2].full()[1, 0])
        if not down > 0.0:
            raise ParameterError(
                f"the hands never touch the table: they move up at {-down:.1f} m/s where they "
                "should come down; arrive with less rise or more somersault"
            )
        above = float(com[2] - self.table.table_height - extras[_HAND_Z])
        if not above > MIN_COM_HEIGHT:
            raise ParameterError(
                f"the hands never touch the table: the centre of mass would be {above:.2f} m above "
                f"them, and less than {MIN_COM_HEIGHT:g} m is a crash; raise the trunk"
            )
        return np.r_[theta, omega, 0.0]

    def contact(self, nodes: Float[Array, "k j"]) -> HandContact:
        """Return the hand contact for activations, one row per node, one column per moving joint.

        Raises:
            ParameterError: If an activation is outside -1 to 1 or the number of columns is wrong.
        """
        if nodes.ndim != 2 or nodes.shape[1] != len(self.segments.joints):
            names = ", ".join(JOINT_NAMES[i] for i in self.segments.joints)
            raise ParameterError(f"activations need one column for each of {names}")
        if not np.abs(nodes).max() <= 1.0:
            raise ParameterError(
                f"an activation of {nodes.flat[np.abs(nodes).argmax()]:.3g} is not between -1, all "
                "strength in flexion, and 1, all in extension"
            )
        u = self.activation(nodes)
        y, e = self.stepper(self.start, u, self.step)
        n = len(y)
        left = bool(n < len(u) - 1 and np.isfinite(y).all())
        if not left:  # keep the finite frames
            n = int(np.isfinite(np.hstack([y, e])).all(axis=1).argmin()) or n
            y, e = y[:n], e[:n]
        time = self.step * np.arange(n)
        if left:
            y, e, u, time = self._taken_off(y, e, u, time)
        return HandContact(time, y, e, u[: len(y)], left)

    def activation(self, nodes: Float[Array, "k j"]) -> Float[Array, "m 5"]:
        """Return the activation at the boundaries of the steps; zero for a fixed joint."""
        time = self.step * np.arange(round(MAX_CONTACT_TIME / self.step) + 2)
        at = NODE_INTERVAL * np.arange(len(nodes))
        u = np.zeros((len(time), N_JOINTS))
        for i, column in zip(self.segments.joints, nodes.T, strict=True):
            u[:, i] = np.interp(time, at, column)
        return u

    def objective(self, nodes: Float[Array, "k j"]) -> float:
        """Return the objective of a search, the penalised upward velocity at take-off [m/s].

        The velocity is that of the first step without force; joint loads above the muscles'
        strength are penalised. The value is -inf if the hands do not leave the table.
        """
        u = self.activation(nodes)
        y, e = self.stepper(self.start, u, self.step)
        if not len(y) < len(u) - 1 or not np.isfinite(e[-1]).all():
            return -np.inf
        return float(e[-1, _VZ] - OVERLOAD_COST * max(float(e[:, _USE].max()) - 1.0, 0.0))

    def _taken_off(
        self, y: Array, e: Array, u: Array, time: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Return the contact truncated where the force becomes zero within the last step."""
        low, high = 0.0, 1.0
        first, then = u[len(y) - 2], u[len(y) - 1]
        for _ in range(40):
            share = 0.5 * (low + high)
            middle = np.array([first, (1 - share) * first + share * then])
            middle = np.vstack([middle, middle[-1:], middle[-1:]])
            states, extras = self.stepper(y[-2], middle, share * self.step, min_steps=2)
            if extras[1, _FORCE_Z] > 0.0:
                low = share
            else:
                high = share
        states, extras = states[1:2], extras[1:2]
        time = np.r_[time[:-1], time[-2] + share * self.step]
        u = np.vstack([u[: len(y) - 1], middle[1:2]])
        return np.vstack([y[:-1], states]), np.vstack([e[:-1], extras]), u, time

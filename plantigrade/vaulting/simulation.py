"""One contact of the hands with the table, from touchdown to take-off."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.vaulting.approach import Approach
from plantigrade.vaulting.compiled import Stepper
from plantigrade.vaulting.equations import EXTRAS, JOINTS, Equations
from plantigrade.vaulting.segments import NAMES, Segments
from plantigrade.vaulting.table import Table

LONGEST = 0.4
"""Hands that are on the table longer than this do not leave it [s]."""
STEP = 1e-3
"""Length of a step of the integration [s]."""
NODE = 0.05
"""Between two nodes of activation [s]."""
NODES = 6
"""Nodes of each joint: what the last says holds from then on."""
OVERUSE = 1.0
"""What it costs a vault that a joint bears twice what its muscles could hold [m/s]."""
LOWEST = 0.1
"""Least height of the centre of mass above the hands at touchdown [m]."""
_FORCE_Z, _VX, _VZ, _HAND_X, _HAND_Z, _USE = (
    EXTRAS.index(name) for name in ("force_z", "com_vx", "com_vz", "hand_x", "hand_z", "use")
)


@dataclass(frozen=True, eq=False)
class Contact:
    """A contact phase.

    Attributes:
        time: From touchdown [s].
        state: theta, its rate and the work done, of the coordinates that move.
        extras: As :data:`~plantigrade.vaulting.equations.EXTRAS` has them.
        activation: Of each joint.
        left: Whether the hands left the table; the last frame is then that instant.
    """

    time: Float[Array, " n"]
    state: Float[Array, "n ny"]
    extras: Float[Array, "n ne"]
    activation: Float[Array, "n 5"]
    left: bool

    @property
    def rise(self) -> float:
        """Velocity of the centre of mass upward at the end [m/s]."""
        return float(self.extras[-1, _VZ])


@dataclass(frozen=True)
class Vault:
    """A gymnast who arrives at a table.

    Args:
        segments: The gymnast.
        table: The table.
        approach: How the gymnast arrives.
        step: Length of a step [s].
    """

    segments: Segments
    table: Table
    approach: Approach
    step: float = STEP

    @cached_property
    def equations(self) -> Equations:
        """The equations of motion."""
        return Equations(self.segments, self.table)

    @cached_property
    def stepper(self) -> Stepper:
        """What makes the steps."""
        return Stepper(self.equations.step, leave=_FORCE_Z)

    def __reduce__(self):
        """Travel to another process without machine code, which is made again there."""
        return type(self), (self.segments, self.table, self.approach, self.step)

    def with_step(self, step: float) -> "Vault":
        """Return the same vault in other steps [s]; the equations are not made anew."""
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
            ParameterError: If the hands would not touch: they do not come down, or the body is not
                above them.
        """
        moving, off = list(self.segments.moving), np.zeros(JOINTS)
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
        if not above > LOWEST:
            raise ParameterError(
                f"the hands never touch the table: the centre of mass would be {above:.2f} m above "
                f"them, and less than {LOWEST:g} m is a crash; raise the trunk"
            )
        return np.r_[theta, omega, 0.0]

    def contact(self, nodes: Float[Array, "k j"]) -> Contact:
        """Return what happens with activations, one row a node, one column a joint that moves.

        Raises:
            ParameterError: If one is not between -1 and 1, or the columns are not those joints.
        """
        if nodes.ndim != 2 or nodes.shape[1] != len(self.segments.joints):
            names = ", ".join(NAMES[i] for i in self.segments.joints)
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
        if not left:  # what there is of it
            n = int(np.isfinite(np.hstack([y, e])).all(axis=1).argmin()) or n
            y, e = y[:n], e[:n]
        time = self.step * np.arange(n)
        if left:
            y, e, u, time = self._taken_off(y, e, u, time)
        return Contact(time, y, e, u[: len(y)], left)

    def activation(self, nodes: Float[Array, "k j"]) -> Float[Array, "m 5"]:
        """Return the activation at the ends of all steps; of a fixed joint zero."""
        time = self.step * np.arange(round(LONGEST / self.step) + 2)
        at = NODE * np.arange(len(nodes))
        u = np.zeros((len(time), JOINTS))
        for i, column in zip(self.segments.joints, nodes.T, strict=True):
            u[:, i] = np.interp(time, at, column)
        return u

    def worth(self, nodes: Float[Array, "k j"]) -> float:
        """Return what a search makes great: the velocity upward at take-off [m/s].

        It is that of the first step without force, and less where a joint runs into its end harder
        than its muscles could hold; -inf where the hands do not leave.
        """
        u = self.activation(nodes)
        y, e = self.stepper(self.start, u, self.step)
        if not len(y) < len(u) - 1 or not np.isfinite(e[-1]).all():
            return -np.inf
        return float(e[-1, _VZ] - OVERUSE * max(float(e[:, _USE].max()) - 1.0, 0.0))

    def _taken_off(
        self, y: Array, e: Array, u: Array, time: Array
    ) -> tuple[Array, Array, Array, Array]:
        """Return the contact cut where the force becomes zero, within the last step."""
        low, high = 0.0, 1.0
        first, then = u[len(y) - 2], u[len(y) - 1]
        for _ in range(40):
            share = 0.5 * (low + high)
            middle = np.array([first, (1 - share) * first + share * then])
            middle = np.vstack([middle, middle[-1:], middle[-1:]])
            states, extras = self.stepper(y[-2], middle, share * self.step, least=2)
            if extras[1, _FORCE_Z] > 0.0:
                low = share
            else:
                high = share
        states, extras = states[1:2], extras[1:2]
        time = np.r_[time[:-1], time[-2] + share * self.step]
        u = np.vstack([u[: len(y) - 1], middle[1:2]])
        return np.vstack([y[:-1], states]), np.vstack([e[:-1], extras]), u, time

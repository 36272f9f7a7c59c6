r"""Joint position, velocity and acceleration limits as bounds of the generalised acceleration.

With a coordinate :math:`q` of range :math:`[\underline q, \bar q]`, a rate :math:`\lambda` and a
step :math:`\Delta t`,

.. math:: \ddot q \ge -\lambda^2 (q - \underline q) - 2 \lambda \dot q, \qquad
    \ddot q \le (\dot q_{max} - \dot q) / \Delta t,

and likewise above: the coordinate approaches its limit no faster than a critically damped spring
would, and never passes it.
"""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import State
from plantigrade.models import Human

FASTEST_ACCELERATION = 2000.0  # of any coordinate [rad/s² or m/s²]; no walking joint is near it
FASTEST = 30.0  # of any hinge [rad/s]
RATE = 50.0  # of the approach to a limit [1/s]


class JointLimits:
    """Bounds of the generalised acceleration.

    Args:
        human: The person.
        step: Time step of the motion [s].
        fastest: Greatest speed of any hinge [rad/s].
        acceleration: Greatest acceleration of any coordinate.
        ranges: Lower and upper limit of each hinge [rad]; the person's own if absent.
    """

    def __init__(
        self,
        human: Human,
        step: float,
        *,
        fastest: float = FASTEST,
        acceleration: float = FASTEST_ACCELERATION,
        ranges: Float[Array, "2 n_hinges"] | None = None,
    ):
        self.step, self.acceleration = step, acceleration
        self.rate = min(RATE, 0.25 / step)
        self._pull = self.rate**2 * np.array(human.limits if ranges is None else ranges)
        self._swift = fastest / step

    def bounds(self, state: State) -> tuple[Float[Array, " nv"], Float[Array, " nv"]]:
        """Return the lower and upper bounds at a state; never crossed."""
        q, v = state.qpos[7:], state.qvel[6:]
        most = self.acceleration
        both = np.empty((2, len(state.qvel)))
        both[:, :6] = [[-most], [most]]
        slow = v / self.step
        below, above = self._pull - (self.rate**2 * q + 2 * self.rate * v)
        np.maximum(below, -self._swift - slow, out=both[0, 6:])
        np.minimum(above, self._swift - slow, out=both[1, 6:])
        np.minimum(np.maximum(both, -most, out=both), most, out=both)
        low, high = both
        crossed = low > high
        if crossed.any():
            low[crossed] = high[crossed] = 0.5 * (low + high)[crossed]
        return low, high

r"""Joint position, velocity and acceleration limits as bounds of the generalised acceleration.

With a coordinate :math:`q` of range :math:`[\underline q, \bar q]`, a rate :math:`\lambda` and a
step :math:`\Delta t`,

.. math:: \ddot q \ge -\lambda^2 (q - \underline q) - 2 \lambda \dot q, \qquad
    \ddot q \le (\dot q_{max} - \dot q) / \Delta t,

and likewise above: the coordinate approaches its limit no faster than a critically damped spring
would, and never passes it.
"""

from dataclasses import dataclass
from math import inf

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human


@dataclass(frozen=True, kw_only=True)
class JointLimitSettings:
    """Limits that are not the person's ranges of motion."""

    max_acceleration: float = inf
    """Greatest acceleration of any coordinate [rad/s², m/s²]."""
    max_velocity: float = inf
    """Greatest velocity of any hinge [rad/s]."""
    approach_per_step: float = 0.25
    """Rate at which a hinge comes to rest at its limit, by time steps. Chosen for stability."""


class JointLimits:
    """Bounds of the generalised acceleration.

    Args:
        human: The person.
        step: Time step of the motion [s].
        settings: Limits of velocity and acceleration.
        ranges: Lower and upper limit of each hinge [rad]; the person's own if absent.
    """

    def __init__(
        self,
        human: Human,
        step: float,
        *,
        settings: JointLimitSettings | None = None,
        ranges: Float[Array, "2 n_hinges"] | None = None,
    ):
        s = settings or JointLimitSettings()
        self.acceleration = s.max_acceleration
        rate = s.approach_per_step / step
        low, high = human.limits if ranges is None else ranges
        swift = np.full(len(low), s.max_velocity / step)
        # The bounds are the tighter ones of four lines in q and v: two below, two above.
        self._lines = np.array([rate**2 * low, -swift, rate**2 * high, swift])
        self._by_q = np.array([[rate**2], [0.0], [rate**2], [0.0]])
        self._by_v = np.array([[2 * rate], [1 / step], [2 * rate], [1 / step]])

    def bounds(self, state: BodyState) -> tuple[Float[Array, " nv"], Float[Array, " nv"]]:
        """Return the lower and upper bounds at a state; never crossed."""
        q, v, most = state.qpos[7:], state.qvel[6:], self.acceleration
        lines = self._lines - self._by_q * q - self._by_v * v
        low, high = both = np.empty((2, len(state.qvel)))
        low[:6], high[:6] = -most, most
        np.maximum(lines[0], lines[1], out=low[6:])
        np.minimum(lines[2], lines[3], out=high[6:])
        np.minimum(np.maximum(both, -most, out=both), most, out=both)
        crossed = low > high
        if crossed.any():
            low[crossed] = high[crossed] = 0.5 * (low + high)[crossed]
        return low, high

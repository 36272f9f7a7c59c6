r"""All coordinates at once: a posture, reached or passed at a given time.

The paper asks for the posture "at the end of each phase" and leaves the gains open. Here they
follow the time that is left. (A constant gain is too slow for a double support of 0.1 s or too
stiff for a swing of 0.5 s, whichever it is chosen for.)
"""

from collections.abc import Callable

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.wbc.tasks.landing import LandingSettings
from plantigrade.wbc.tasks.task import Target, Task


class PostureTask(Task):
    r"""Draws every coordinate to a posture that stays or moves, with constant gains.

    With :math:`e` the way from the posture to the configuration,

    .. math:: \dot v = \dot v^* - \lambda_p e - \lambda_d (v - v^*) .

    Args:
        target: Configuration, with velocity and acceleration where it moves; the quaternion is
            normalised here.
        weight: Cost of a squared unit of acceleration missed, of each coordinate or of all.
    """

    def __init__(self, target: Target, *, name: str = "posture", **gains):
        super().__init__(name, target, **gains)

    def error(self, state, time):
        """Return the tangent step from the posture to the configuration."""
        posture = self.aim(time)[0].copy()
        posture[3:7] /= np.linalg.norm(posture[3:7])
        return state.difference(posture)

    def velocity(self, state, time, jacobian=None):
        """Return the generalised velocity."""
        return state.qvel

    def jacobian(self, state, time):
        """Return the identity."""
        return np.eye(state.model.nv)

    def bias_acceleration(self, state, time):
        """Return zero."""
        return np.zeros(state.model.nv)


class TimedPosture(PostureTask):
    r"""Draws every coordinate to a fixed posture, to pass it at a given time and velocity.

    With :math:`e` the way from the posture :math:`q_e`, which is passed at the velocity
    :math:`v_e`, and :math:`T` the time to go,

    .. math:: \dot v = -\frac{6}{T^2} e - \frac{1}{T} (4 v + 2 v_e),

    the path of least acceleration from here and now to there and then. In the last moments, when
    the gains would grow without end, the body follows the straight line into the posture.

    Args:
        target: Function of time that returns the posture of the present phase and the time at
            which the phase ends [s].
        velocity: Function of time that returns the velocity at which the posture is passed; it is
            reached at rest if absent.
        min_time_left: Time left below which the gains grow no further [s]; as of feet that land.
    """

    def __init__(
        self,
        target: Callable[[float], tuple[Float[Array, " nq"], float]],
        velocity: Callable[[float], Float[Array, " nv"]] | None = None,
        *,
        min_time_left: float = LandingSettings.min_time_left,
        name: str = "posture",
    ):
        super().__init__(target, name=name)
        self.passed, self.min_time_left = velocity, min_time_left

    def acceleration(self, state, time, jacobian=None) -> Float[Array, " nv"]:
        """Return the desired generalised acceleration."""
        posture, end = self.aim(time)[:2]
        passed = np.zeros(len(state.qvel)) if self.passed is None else self.passed(time)
        error, left = state.difference(posture), end - time
        if left >= self.min_time_left:
            return -6 * error / left**2 - (4 * state.qvel + 2 * passed) / left
        error = error + passed * max(left, 0.0)
        short = self.min_time_left
        return -6 * error / short**2 - 4 * (state.qvel - passed) / short

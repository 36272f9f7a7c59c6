r"""The orientation of a body.

The error is the rotation vector :math:`e = \log(R R^{*T})`, world axes. Its exact rate is
:math:`\dot e = J_l^{-1}(e)\,\omega` with the left Jacobian of the rotation group; for the small
errors a task lives with, :math:`J_l \approx 1` and the Jacobian of the task is that of the angular
velocity.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.wbc.tasks.task import Task


class OrientationTask(Task):
    """Holds a body at an orientation.

    Args:
        body: Name of the body.
        target: Its rotation; its axes are the columns.
        directions: World axes about which it counts, one row each; all if absent.
        name: Name.
        gains: ``stiffness`` and ``damping``.
    """

    def __init__(
        self,
        body: str,
        target: Float[Array, "3 3"],
        directions: Float[Array, "n_rows 3"] | None = None,
        name: str = "",
        **gains,
    ):
        super().__init__(name or f"orientation of {body}", **gains)
        self.body, self.target = body, target
        self._directions = np.eye(3) if directions is None else directions

    def error(self, state, time):
        """Return the rotation vector from the target to the body [rad]."""
        turn = Rotation.from_matrix(state.rotation(self.body) @ self.target.T)
        return self._directions @ turn.as_rotvec()

    def jacobian(self, state, time):
        """Return the Jacobian of the body's angular velocity."""
        return self._directions @ state.angular_jacobian(self.body)

    def bias_acceleration(self, state, time):
        """Return its angular acceleration where nothing accelerates [rad/s²]."""
        return self._directions @ state.angular_bias_acceleration(self.body)

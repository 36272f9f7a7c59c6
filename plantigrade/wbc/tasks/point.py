"""A point of the body, the orientation of a segment."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import PointSet, State
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.wbc.tasks.task import Task

Directions = Callable[[State, float], np.ndarray]


class PointTask(Task):
    r"""Moves one point of the body along a trajectory, in some or all directions.

    Args:
        point: One point.
        target: Its trajectory [m].
        directions: Unit vectors along which the point is controlled, one row each: an array
            (rows of the identity for world axes), or a function of state and time. No rows means
            that the task rests. Where directions turn with the body their own rate is neglected:
            the error is projected on the directions of the moment.
        farthest: Error beyond which the pull grows no further [m]: a point that cannot get where
            it should must not be torn at.
    """

    def __init__(
        self,
        point: PointSet,
        target: Trajectory,
        directions: Float[Array, "n_rows 3"] | Directions | None = None,
        name: str = "point",
        farthest: float = np.inf,
        **gains,
    ):
        super().__init__(name, **gains)
        self.farthest = farthest
        self.point, self.target = point, target
        self._wanted = directions
        self._known: tuple[object, float] = (None, np.nan)
        self._now = np.zeros((0, 3))

    def _directions(self, state: State, time: float) -> np.ndarray:
        if not callable(self._wanted):
            return np.eye(3) if self._wanted is None else self._wanted
        if self._known[0] is not state or self._known[1] != time:
            self._known = (state, time)
            self._now = self._wanted(state, time)
        return self._now

    def _along(self, state: State, time: float, values: np.ndarray) -> np.ndarray:
        """Return the parts of vectors (3, ...) along the directions."""
        return values if self._wanted is None else self._directions(state, time) @ values

    def error(self, state, time):
        """Return the way from the target to the point, along the directions [m]."""
        if self._wanted is not None and not len(self._directions(state, time)):
            return np.zeros(0)
        away = self._along(state, time, state.position(self.point)[0] - self.target(time)[0])
        if self.farthest < np.inf:
            away = np.clip(away, -self.farthest, self.farthest)
        return away

    def jacobian(self, state, time):
        """Return the Jacobian of the point along the directions."""
        return self._along(state, time, state.jacobian(self.point)[0])

    def bias_acceleration(self, state, time):
        """Return its acceleration along them where nothing accelerates [m/s²]."""
        return self._along(state, time, state.bias_acceleration(self.point)[0])

    def target_rates(self, state, time):
        """Return velocity and acceleration of the target along the directions."""
        _, velocity, acceleration = self.target(time)
        return self._along(state, time, velocity), self._along(state, time, acceleration)


class OrientationTask(Task):
    r"""Holds a body at an orientation.

    The error is the rotation vector :math:`e = \log(R R^{*T})`, world axes. For small errors its
    rate is the angular velocity (the left Jacobian of the rotation group is nearly 1).

    Args:
        body: Name of the body.
        target: Its rotation; its axes are the columns.
        directions: World axes about which it counts, one row each; all if absent.
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

"""A point of the body, the orientation of a segment."""

from collections.abc import Callable
from math import hypot, inf

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.wbc.tasks.task import Target, Task

Directions = Callable[[BodyState, float], Array]


class PointTask(Task):
    r"""Moves one point of the body to a place or along a trajectory, in some or all directions.

    Args:
        point: The point, or several of which ``which`` is meant.
        target: Its place, or its trajectory [m].
        directions: Unit vectors along which the point is controlled, one row each: an array
            (rows of the identity for world axes), or a function of state and time. No rows means
            that the task rests. Where directions turn with the body their own rate is neglected:
            the error is projected on the directions of the moment.
        max_error: Error beyond which the pull grows no further [m]: a point that cannot get where
            it should must not be torn at.
        which: Which of several points.
    """

    def __init__(
        self,
        point: PointSet,
        target: Target = None,
        directions: Float[Array, "n_rows 3"] | Directions | None = None,
        name: str = "point",
        max_error: float = inf,
        which: int = 0,
        **gains,
    ):
        super().__init__(name, target, **gains)
        self.point, self.which, self.max_error = point, which, max_error
        self.directions = directions
        self._known: tuple[object, float] = (None, np.nan)
        self._now = np.zeros((0, 3))

    def _directions(self, state: BodyState, time: float) -> Array:
        if not callable(self.directions):
            return np.eye(3) if self.directions is None else self.directions
        if self._known[0] is not state or self._known[1] != time:
            self._known = (state, time)
            self._now = self.directions(state, time)
        return self._now

    def _along(self, state: BodyState, time: float, values: Array) -> Array:
        """Return the parts of vectors (3, ...) along the directions."""
        return values if self.directions is None else self._directions(state, time) @ values

    def rests(self, state, time):
        """Return whether there are no directions now."""
        return self.directions is not None and not len(self._directions(state, time))

    def error(self, state, time):
        """Return the way from the target to the point, along the directions [m]."""
        away = state.position(self.point)[self.which] - self.aim(time)[0]
        away = self._along(state, time, away)
        if self.max_error < inf:
            away = away * min(1.0, self.max_error / max(hypot(*away.tolist()), 1e-9))
        return away

    def jacobian(self, state, time):
        """Return the Jacobian of the point along the directions."""
        return self._along(state, time, state.jacobian(self.point)[self.which])

    def velocity(self, state, time, jacobian=None):
        """Return its velocity along the directions [m/s]."""
        return self._along(state, time, state.velocity(self.point)[self.which])

    def bias_acceleration(self, state, time):
        """Return its acceleration along them where nothing accelerates [m/s²]."""
        return self._along(state, time, state.bias_acceleration(self.point)[self.which])

    def acceleration(self, state, time, jacobian=None):
        """Return the desired acceleration along the directions [m/s²]."""
        _, velocity, acceleration = self.aim(time)
        if self.directions is not None and np.ndim(velocity):
            velocity, acceleration = (self._along(state, time, v) for v in (velocity, acceleration))
        right = acceleration - self.stiffness * self.error(state, time)
        return right - self.damping * (self.velocity(state, time) - velocity)


class OrientationTask(Task):
    r"""Leads a body to an orientation.

    The error is the rotation vector :math:`e = \log(R R^{*T})`, world axes. For small errors its
    rate is the angular velocity (the left Jacobian of the rotation group is nearly 1).

    Args:
        body: Name of the body, or its index.
        target: Its rotation; its axes are the columns. With angular velocity and acceleration
            where it turns, world axes [rad/s, rad/s²].
        directions: World axes about which it counts, one row each; all if absent.
    """

    def __init__(
        self,
        body: str | int,
        target: Target = None,
        directions: Float[Array, "n_rows 3"] | None = None,
        name: str = "",
        **gains,
    ):
        super().__init__(name or f"orientation of {body}", target, **gains)
        self.body, self.directions = body, directions

    def error(self, state, time):
        """Return the rotation vector from the target to the body, about all axes [rad]."""
        return -rotation_to(self.aim(time)[0], state.rotation(self.body))

    def jacobian(self, state, time):
        """Return the Jacobian of the body's angular velocity."""
        return state.angular_jacobian(self.body)

    def bias_acceleration(self, state, time):
        """Return its angular acceleration where nothing accelerates [rad/s²]."""
        return state.angular_bias_acceleration(self.body)

    def _asks(self, matrix, right):
        rows = super()._asks(matrix, right)
        return rows if self.directions is None else rows.along(self.directions)


class AlignmentTask(OrientationTask):
    """Turns a body by a rotation that is given anew at every instant.

    Args:
        target: Rotation vector that is left to go, world axes [rad]. It is not differentiated, and
            the bias acceleration is left out.
    """

    def error(self, state, time):
        """Return the rotation vector from the target to the body [rad]."""
        return -self.aim(time)[0]

    def bias_acceleration(self, state, time):
        """Return zero."""
        return np.zeros(3)


def axis_error(goal: Float[Array, "*n 3 3"], now: Float[Array, "*n 3 3"]) -> Float[Array, "*n 3"]:
    r"""Return half the sum of the cross products of axes, :math:`\sin\theta` about the axis.

    For small errors it is the rotation vector that leads to one orientation from another.
    """
    M = now @ np.swapaxes(goal, -1, -2)
    skew = M - np.swapaxes(M, -1, -2)
    return 0.5 * np.stack([skew[..., 1, 2], skew[..., 2, 0], skew[..., 0, 1]], axis=-1)


def rotation_to(goal: Float[Array, "3 3"], now: Float[Array, "3 3"]) -> Float[Array, " 3"]:
    """Return the rotation vector that leads to one orientation from another, world axes [rad]."""
    to, start, error = np.empty(4), np.empty(4), np.empty(3)
    mujoco.mju_mat2Quat(to, np.ascontiguousarray(goal).ravel())
    mujoco.mju_mat2Quat(start, np.ascontiguousarray(now).ravel())
    mujoco.mju_subQuat(error, to, start)  # in the axes of what is now
    return now @ error

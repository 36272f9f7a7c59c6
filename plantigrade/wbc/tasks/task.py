r"""The one interface of all tasks.

A task is an error :math:`e(q, t) = f(q) - f^*(t)` that is to go to zero. It does so by second-order
dynamics,

.. math:: \ddot e = -\lambda_p e - \lambda_d \dot e,

(the paper prints :math:`-\lambda_p \dot e - \lambda_d \dot e`, a slip: the first term must be the
error itself). With Eqs. 2 and 9, :math:`\dot e = J v - \dot f^*` and
:math:`\ddot e = J \dot v + \dot J v - \ddot f^*`, so the generalised acceleration has to
satisfy

.. math:: J \dot v = \ddot f^* - \lambda_p e - \lambda_d \dot e - \dot J v.

These are the task's rows. A strict order (:mod:`plantigrade.wbc.order`) stacks them in levels, a
weighted program (:mod:`plantigrade.wbc.whole_body`) sums their squares by the tasks' weights. See
[Boukheddimi]_ and [Samson1991]_.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import BodyState
from plantigrade.wbc.rows import Rows

Target = Callable[[float], Any] | tuple[Any, Any, Any] | Array | None
"""A target: a function of time that returns value, velocity and acceleration (a
:class:`~plantigrade.kinematics.trajectory.Trajectory`), these three, or a value that stays."""


class Task(ABC):
    r"""Something to regulate to zero.

    Subclasses give :meth:`error`, :meth:`jacobian` and :meth:`bias_acceleration`. All three may
    return no rows while the task is not active. Subclasses take name, stiffness, damping and weight
    as well.

    Args:
        name: Its name in plots and messages.
        target: :math:`f^*`; may be set anew at any time.
        stiffness: :math:`\lambda_p` [1/s²].
        damping: :math:`\lambda_d` [1/s]; critical if absent.
        weight: Cost of a squared unit of acceleration missed, of each row or of all; a strict order
            weighs tasks of one level by it.
    """

    causes_impact = False  # whether velocities jump where it begins
    initialises = False  # whether the first posture is corrected until it is satisfied
    at_least = False  # whether more than the desired acceleration is welcome

    def __init__(
        self,
        name: str,
        target: Target = None,
        *,
        stiffness: float = 400.0,
        damping: float | None = None,
        weight: float | Float[Array, " n_rows"] = 1.0,
    ):
        self.name, self.target, self.weight = name, target, weight
        self.stiffness = stiffness
        self.damping = 2.0 * stiffness**0.5 if damping is None else damping

    @abstractmethod
    def error(self, state: BodyState, time: float) -> Float[Array, " n_rows"]:
        """Return :math:`e = f(q) - f^*(t)`."""

    @abstractmethod
    def jacobian(self, state: BodyState, time: float) -> Float[Array, "n_rows nv"]:
        r"""Return :math:`J = \partial f / \partial q` with respect to MuJoCo's velocity."""

    @abstractmethod
    def bias_acceleration(self, state: BodyState, time: float) -> Float[Array, " n_rows"]:
        r"""Return :math:`\dot J v`."""

    def velocity(
        self, state: BodyState, time: float, jacobian: Array | None = None
    ) -> Float[Array, " n_rows"]:
        """Return :math:`J v`; :math:`J` may be given where it is known."""
        return (self.jacobian(state, time) if jacobian is None else jacobian) @ state.qvel

    def aim(self, time: float) -> Any:
        """Return value, velocity and acceleration of the target: three things, or rows of an array.

        Rates are 0 where it rests.
        """
        target = self.target
        if callable(target):
            return target(time)
        return target if isinstance(target, tuple) else (target, 0.0, 0.0)

    def acceleration(
        self, state: BodyState, time: float, jacobian: Array | None = None
    ) -> Float[Array, " n_rows"]:
        r"""Return the desired acceleration, :math:`\ddot f^* - \lambda_p e - \lambda_d \dot e`."""
        _, velocity, acceleration = self.aim(time)
        right = acceleration - self.stiffness * self.error(state, time)
        return right - self.damping * (self.velocity(state, time, jacobian) - velocity)

    def rests(self, state: BodyState, time: float) -> bool:
        """Return whether the task is inactive now."""
        return False

    def begin(self, state: BodyState, time: float) -> bool:
        """Take note of a new instant, before its rows.

        Returns:
            Whether velocities have to jump here: a contact that begins stops its points at once.
        """
        return False

    def reset(self) -> None:
        """Forget what was noted; the next instant is the first."""
        return

    def rows(
        self,
        state: BodyState,
        time: float = 0.0,
        *,
        acceleration: Float[Array, " n_rows"] | None = None,
    ) -> Rows:
        """Return the rows of the generalised acceleration.

        Args:
            state: The state of the body.
            time: Time of the target [s].
            acceleration: Desired acceleration, from a law of your own; by target and gains if
                absent.
        """
        if self.rests(state, time):
            return self._asks(np.zeros((0, len(state.qvel))), np.zeros(0))
        jacobian = self.jacobian(state, time)
        if acceleration is None:
            acceleration = self.acceleration(state, time, jacobian)
        return self._asks(jacobian, acceleration - self.bias_acceleration(state, time))

    def position_rows(self, state: BodyState, time: float) -> Rows:
        """Return the rows of a step of the configuration that undoes the error."""
        return self._asks(self.jacobian(state, time), -self.error(state, time))

    def velocity_rows(self, state: BodyState, time: float) -> Rows:
        """Return the rows of the velocity right after a contact has begun."""
        matrix = self.jacobian(state, time)
        return self._asks(matrix, np.zeros(len(matrix)))

    def _asks(self, matrix: Array, right: Array) -> Rows:
        return Rows(matrix, right, self.weight, self.name, self.at_least)

r"""The one interface of all tasks.

A task is an error :math:`e(q, t) = f(q) - f^*(t)` that is to go to zero. It does so by second-order
dynamics,

.. math:: \ddot e = -\lambda_p e - \lambda_d \dot e,

(the paper prints :math:`-\lambda_p \dot e - \lambda_d \dot e`, a slip: the first term must be the
error itself). With Eqs. 2 and 9, :math:`\dot e = J v - \dot f^*` and
:math:`\ddot e = J \dot v + \dot J v - \ddot f^*`, so the generalised acceleration is asked to
satisfy

.. math:: J \dot v = -\lambda_p e - \lambda_d \dot e + \ddot f^* - \dot J v.

See [Boukheddimi]_ and [Samson1991]_.
"""

from abc import ABC, abstractmethod

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import State
from plantigrade.wbc.hierarchy import Level


class Task(ABC):
    r"""Something to regulate to zero.

    Subclasses give :meth:`error`, :meth:`jacobian` and :meth:`bias_acceleration`; a task whose
    target moves gives :meth:`target_rates` too. All four may return no rows while the task is not
    active. Subclasses take name, stiffness and damping as well.

    Args:
        name: What it is called in plots and messages.
        stiffness: :math:`\lambda_p` [1/s²].
        damping: :math:`\lambda_d` [1/s]; critical if absent.
    """

    causes_impact = False  # whether velocities jump where it begins
    initialises = False  # whether the first posture is corrected until it is satisfied

    def __init__(self, name: str, *, stiffness: float = 400.0, damping: float | None = None):
        self.name = name
        self.stiffness = stiffness
        self.damping = 2.0 * stiffness**0.5 if damping is None else damping

    @abstractmethod
    def error(self, state: State, time: float) -> Float[Array, " n_rows"]:
        """Return :math:`e = f(q) - f^*(t)`."""

    @abstractmethod
    def jacobian(self, state: State, time: float) -> Float[Array, "n_rows nv"]:
        r"""Return :math:`J = \partial f / \partial q` with respect to MuJoCo's velocity."""

    @abstractmethod
    def bias_acceleration(self, state: State, time: float) -> Float[Array, " n_rows"]:
        r"""Return :math:`\dot J v`."""

    def target_rates(
        self, state: State, time: float
    ) -> tuple[Float[Array, " n_rows"], Float[Array, " n_rows"]] | None:
        r"""Return :math:`\dot f^*` and :math:`\ddot f^*`; None where the target rests."""
        return None

    def begin(self, state: State, time: float) -> bool:
        """Take note of a new instant before anything is asked of it.

        Returns:
            Whether velocities have to jump here: a contact that begins stops its points at once.
        """
        return False

    def reset(self) -> None:
        """Forget what was noted; the next instant is the first."""
        return

    def position_level(self, state: State, time: float) -> Level:
        """Return the rows this task asks of a step of the configuration: to undo its error."""
        return Level.equation(self.jacobian(state, time), -self.error(state, time), self.name)

    def level(self, state: State, time: float) -> Level:
        """Return the rows this task asks of the generalised acceleration."""
        error = self.error(state, time)
        if not len(error):
            return Level.equation(np.zeros((0, len(state.qvel))), error, self.name)
        matrix = self.jacobian(state, time)
        rate = matrix @ state.qvel
        wanted = -self.stiffness * error - self.bias_acceleration(state, time)
        moving = self.target_rates(state, time)
        if moving is not None:
            rate = rate - moving[0]
            wanted = wanted + moving[1]
        return Level.equation(matrix, wanted - self.damping * rate, self.name)

    def velocity_level(self, state: State, time: float) -> Level:
        """Return the rows this task asks of the velocity right after a contact has begun."""
        matrix = self.jacobian(state, time)
        return Level.equation(matrix, np.zeros(len(matrix)), self.name)

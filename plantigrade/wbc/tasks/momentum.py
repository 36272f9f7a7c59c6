r"""The centre of mass and the angular momentum about it.

Linear and angular momentum change only by forces that act within the soles, and walking regulates
both [Herr2008]_.
"""

import numpy as np

from plantigrade.kinematics.state import CROSS, State
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.wbc.tasks.task import Task

_AXES = {"x": 0, "y": 1, "z": 2}
LEVER = 0.5  # an angular momentum error counts as a force error with this lever arm [m]


class ComTask(Task):
    """Moves the centre of mass along a trajectory.

    Args:
        target: Its trajectory [m].
        axes: Which world axes: ``"xyz"``, ``"xy"``, ``"z"``, …
    """

    def __init__(self, target: Trajectory, axes: str = "xyz", name: str = "", **gains):
        super().__init__(name or f"centre of mass {axes}", **gains)
        self.target = target
        self._axes = slice(None) if axes == "xyz" else np.array([_AXES[a] for a in axes])

    def error(self, state, time):
        """Return the way from the target to the centre of mass [m]."""
        return (state.com - self.target(time)[0])[self._axes]

    def jacobian(self, state, time):
        """Return the Jacobian of the centre of mass."""
        return state.com_jacobian[self._axes]

    def bias_acceleration(self, state, time):
        """Return its acceleration where nothing accelerates [m/s²]."""
        return state.com_bias_acceleration[self._axes]

    def target_rates(self, state, time):
        """Return velocity and acceleration of the target."""
        _, velocity, acceleration = self.target(time)
        return velocity[self._axes], acceleration[self._axes]

    def distance(self, state, time: float) -> float:
        """Return how far the centre of mass is from its target, in the axes that count [m]."""
        return float(np.linalg.norm(self.error(state, time)))


class AngularMomentumTask(Task):
    r"""Regulates the angular momentum about the centre of mass, and how far the body has turned.

    :math:`L = A(q) v` with the rows :math:`A` of the centroidal momentum matrix [Orin2013]_. No
    configuration has :math:`L` as its rate; the error is the tangent step from the posture of the
    moment, weighted as :math:`L` weighs velocities, :math:`e = A(q)\,(q \ominus q^*(t))`, the
    whole body's share in having turned too far; its rate is taken as :math:`L - L^*(t)`.

    All rows are divided by mass and :data:`LEVER`, so that they compare with those of the centre
    of mass [m/s²].

    Args:
        target: Path of the angular momentum [kg m²/s].
        posture: Path of the configuration.
        turn: By how much the body is to have turned further than that, as momentum integrated
            [kg m²]; not at all if absent.
    """

    def __init__(
        self,
        target: Trajectory,
        posture: Trajectory,
        name: str = "angular momentum",
        stiffness: float = 25.0,
        turn: Trajectory | None = None,
        **gains,
    ):
        super().__init__(name, stiffness=stiffness, **gains)
        self.target, self.posture, self.turn = target, posture, turn

    def error(self, state, time):
        """Return by how much the whole body has turned too far [m]."""
        posture = self.posture(time)[0].copy()
        posture[3:7] /= np.linalg.norm(posture[3:7])
        error = self.jacobian(state, time) @ state.difference(posture)
        return error if self.turn is None else error - self.turn(time)[0] / (state.mass * LEVER)

    def jacobian(self, state, time):
        """Return the angular rows of the centroidal momentum matrix."""
        return _about_com(state, state.mass_matrix[:6])

    def bias_acceleration(self, state, time):
        """Return the rate of the angular momentum where nothing accelerates."""
        return _about_com(state, state.bias[:6])

    def target_rates(self, state, time):
        """Return angular momentum and its rate on the path."""
        rates = self.target(time) / (state.mass * LEVER)
        return rates[0], rates[1]


def _about_com(state: State, root: np.ndarray) -> np.ndarray:
    """Return the moments about the centre of mass of wrenches at the root, scaled."""
    moment = state.rotation(1) @ root[3:6]
    arm = state.qpos[:3] - state.com
    return (moment + (arm @ CROSS).reshape(3, 3) @ root[:3]) / (state.mass * LEVER)

"""The whole-body centre of mass."""

import numpy as np

from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.wbc.tasks.task import Task

_AXES = {"x": 0, "y": 1, "z": 2}


class ComTask(Task):
    """Moves the centre of mass along a trajectory.

    Args:
        target: Its trajectory [m].
        axes: Which world axes: ``"xyz"``, ``"xy"``, ``"z"``, …
        name: Name.
        gains: ``stiffness`` and ``damping``.
    """

    def __init__(self, target: Trajectory, axes: str = "xyz", name: str = "", **gains):
        super().__init__(name or f"centre of mass {axes}", **gains)
        self.target = target
        self._axes = [_AXES[a] for a in axes]

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
        rates = self.target(time)[1:, self._axes]
        return rates[0], rates[1]

    def distance(self, state, time: float) -> float:
        """Return how far the centre of mass is from its target, in the axes that count [m]."""
        return float(np.linalg.norm(self.error(state, time)))

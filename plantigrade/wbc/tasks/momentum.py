r"""Angular momentum.

Turning has a price: the angular momentum changes only by the moment of forces that act within the
soles. Linear and angular momentum are the two halves of one law, and walking regulates both
[Herr2008]_.
"""

import numpy as np

from plantigrade.kinematics.state import State
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.spatial.conventions import rotation_matrix
from plantigrade.wbc.tasks.task import Task

LEVER = 0.5  # an angular momentum error counts as a force error with this lever arm [m]


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
        name: Name.
        gains: ``stiffness`` and ``damping``.
    """

    def __init__(
        self,
        target: Trajectory,
        posture: Trajectory,
        name: str = "angular momentum",
        stiffness: float = 25.0,
        **gains,
    ):
        super().__init__(name, stiffness=stiffness, **gains)
        self.target, self.posture = target, posture

    def error(self, state, time):
        """Return by how much the whole body has turned too far [m]."""
        posture = self.posture(time)[0].copy()
        posture[3:7] /= np.linalg.norm(posture[3:7])
        return self.jacobian(state, time) @ state.difference(posture)

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
    moment = rotation_matrix(state.qpos[None, 3:7])[0] @ root[3:6]
    arm = state.qpos[:3] - state.com
    return (moment + np.cross(arm, root[:3].T).T) / (state.mass * LEVER)

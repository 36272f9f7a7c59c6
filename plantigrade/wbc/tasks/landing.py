r"""Feet that come down by forces: the heel arrives in time and at rest, where it is needed.

Without forces a velocity may jump; with them a foot must come down so that its heel reaches the
ground when the contact begins, and what speed is left is taken up by the sole
(:class:`~plantigrade.wbc.tasks.contact.SoleContactTask`): no impact, no impulse.
"""

from collections.abc import Sequence

import numpy as np

from plantigrade.constants import GRAVITY
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.wbc.hierarchy import Level
from plantigrade.wbc.tasks.point import PointTask
from plantigrade.wbc.tasks.task import Task

LEAD = 0.15  # a foot is led to the ground this long before it touches [s]
SHORTEST = 0.03  # time to go below which its gains grow no further [s]
FURTHEST = 0.15  # a foot is put down at most this far from its recorded place [m]


class LandingTask(Task):
    r"""Brings parts of the feet to the ground at the time they are to touch it, at rest.

    With :math:`h` the mean height of the part's points and :math:`T` the time to go,

    .. math:: \ddot h = -\frac{6}{T^2} h - \frac{4}{T} \dot h,

    the path of least acceleration to :math:`h = \dot h = 0`.

    Args:
        points: The contact sites.
        landings: Which points come down together, and when [s].
    """

    def __init__(
        self,
        points: SitePoints,
        landings: Sequence[tuple[np.ndarray, float]],
        name: str = "landing",
    ):
        super().__init__(name)
        self.points, self.landings = points, landings

    def _coming(self, time: float) -> list[tuple[np.ndarray, float]]:
        return [(i, at - time) for i, at in self.landings if 0 < at - time < LEAD]

    def _means(self, values, time: float) -> np.ndarray:
        coming = self._coming(time)
        if not coming:
            return np.zeros((0, *values.shape[1:]))
        return np.array([values[i].mean(axis=0) for i, _ in coming])

    def error(self, state, time):
        """Return the mean height of each part that comes down [m]."""
        return self._means(self.points.height(state), time)

    def jacobian(self, state, time):
        """Return the Jacobian of these heights."""
        return self._means(state.jacobian(self.points)[:, 2], time)

    def bias_acceleration(self, state, time):
        """Return their acceleration where nothing accelerates [m/s²]."""
        return self._means(state.bias_acceleration(self.points)[:, 2], time)

    def level(self, state, time):
        """Return the rows this task asks of the generalised acceleration."""
        left = np.array([max(t, SHORTEST) for _, t in self._coming(time)])
        matrix = self.jacobian(state, time)
        wanted = -6 * self.error(state, time) / left**2 - 4 * (matrix @ state.qvel) / left
        return Level.equation(matrix, wanted - self.bias_acceleration(state, time), self.name)


class PlacingHeelTask(PointTask):
    r"""Moves a swinging heel along its path, displaced as the body is.

    A body whose centre of mass is off its path by :math:`e` cannot be caught by the foot it stands
    on for long; the next one is put down where it will be needed, further by

    .. math:: e + \dot e / \omega, \qquad \omega = \sqrt{g / z},

    by how much the *extrapolated* centre of mass is off [Hof2008]_.

    Args:
        point: The heel.
        target: Its path [m].
        directions: As of :class:`~plantigrade.wbc.tasks.PointTask`.
        com: Path of the centre of mass [m].
    """

    def __init__(self, point: PointSet, target: Trajectory, directions, com: Trajectory, name: str):
        super().__init__(point, target, directions, name)
        self.com = com

    def error(self, state, time):
        """Return the way from the displaced target to the point, along the directions [m]."""
        here, speed, _ = self.com(time)
        slow = np.sqrt(max(state.com[2], 0.1) / GRAVITY)
        away = state.com - here + slow * (state.com_jacobian @ state.qvel - speed)
        size = float(np.linalg.norm(away))
        if size > FURTHEST:
            away = away * (FURTHEST / size)
        return super().error(state, time) - self._along(state, time, away)

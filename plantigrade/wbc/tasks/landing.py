r"""Feet that come down by forces: they arrive in time, where they are needed.

Without forces a velocity may jump; with them a foot must come down so that its heel reaches the
ground when the contact begins, and what speed is left is taken up by the sole
(:class:`~plantigrade.wbc.tasks.contact.SoleContactTask`): no impact, no impulse.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.constants import GRAVITY
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.wbc.tasks.point import PointTask
from plantigrade.wbc.tasks.task import Task


@dataclass(frozen=True, kw_only=True)
class LandingSettings:
    """How feet are led to the ground."""

    lead_time: float = 0.15
    """Time before touchdown from which a foot is led to the ground [s]. Chosen."""
    min_time_left: float = 0.10
    """Time left until touchdown below which the gains grow no further [s]. Chosen: the floor brakes
    the foot too."""
    max_displacement: float = 0.15
    """Greatest displacement of a footstep from its recorded place [m]. Chosen."""


class LandingTask(Task):
    r"""Brings parts of the feet to the ground at the time they are to touch it.

    With :math:`e` the mean height of the part's points above its path and :math:`T` the time to go,

    .. math:: \ddot e = -\frac{6}{T^2} e - \frac{4}{T} \dot e,

    the path of least acceleration to :math:`e = \dot e = 0`. Without a path the ground is it, and
    the part arrives at rest: a foot that is led so brakes a leg that a walker lets fall.

    Args:
        points: The contact sites.
        landings: Which points come down together, and when [s].
        paths: Height of each landing's points over time (one column) [m].
    """

    def __init__(
        self,
        points: SitePoints,
        landings: Sequence[tuple[np.ndarray, float]],
        paths: Sequence[Trajectory] | None = None,
        name: str = "landing",
        settings: LandingSettings | None = None,
    ):
        super().__init__(name)
        self.settings = settings or LandingSettings()
        self.points, self.landings = points, landings
        self.paths = paths or [Trajectory.fixed(np.zeros(1)) for _ in landings]

    def _coming(self, time: float) -> list[tuple[np.ndarray, float]]:
        lead = self.settings.lead_time
        return [(i, at - time) for i, at in self.landings if 0 < at - time < lead]

    def _path(self, time: float) -> np.ndarray:
        """Return height, its rate and bend on the paths of what comes down, one row each."""
        lead, pairs = self.settings.lead_time, zip(self.paths, self.landings, strict=True)
        on = [path(time) for path, (_, at) in pairs if 0 < at - time < lead]
        return np.array(on).reshape(-1, 3)

    def _means(self, values, time: float) -> np.ndarray:
        coming = self._coming(time)
        if not coming:
            return np.zeros((0, *values.shape[1:]))
        return np.array([values[i].mean(axis=0) for i, _ in coming])

    def error(self, state, time):
        """Return how high each part that comes down is above its path [m]."""
        return self._means(self.points.height(state), time) - self._path(time)[:, 0]

    def jacobian(self, state, time):
        """Return the Jacobian of these heights."""
        return self._means(state.jacobian(self.points)[:, 2], time)

    def bias_acceleration(self, state, time):
        """Return their acceleration where nothing accelerates [m/s²]."""
        return self._means(state.bias_acceleration(self.points)[:, 2], time)

    def rests(self, state, time):
        """Return whether nothing comes down now."""
        return not self._coming(time)

    def acceleration(self, state, time, jacobian=None):
        """Return the desired accelerations of these heights [m/s²]."""
        left = np.array([max(t, self.settings.min_time_left) for _, t in self._coming(time)])
        _, rate, bend = self._path(time).T
        desired = bend - 6 * self.error(state, time) / left**2
        return desired - 4 * (self.velocity(state, time, jacobian) - rate) / left


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
        settings: How far it is displaced.
    """

    def __init__(
        self,
        point: PointSet,
        target: Trajectory,
        directions,
        com: Trajectory,
        name: str,
        settings: LandingSettings | None = None,
        **gains,
    ):
        super().__init__(point, target, directions, name, **gains)
        self.com, self.max_displacement = com, (settings or LandingSettings()).max_displacement

    def error(self, state, time):
        """Return the way from the displaced target to the point, along the directions [m]."""
        here, velocity, _ = self.com(time)
        slow = np.sqrt(max(state.com[2], 0.1) / GRAVITY)
        away = state.com - here + slow * (state.com_velocity - velocity)
        size = float(np.linalg.norm(away))
        if size > self.max_displacement:
            away = away * (self.max_displacement / size)
        return super().error(state, time) - self._along(state, time, away)

r"""Points that stay above the ground.

An inequality, not a tracked height: with :math:`h` the height of a point,

.. math:: \ddot h \ge -\lambda_p h - \lambda_d \dot h ,

which leaves the point alone as long as it does not approach the ground too fast.
"""

from collections.abc import Callable

import numpy as np

from plantigrade.arrays import Array, Bool
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.wbc.hierarchy import Level
from plantigrade.wbc.tasks.task import Task

NEAR = 0.10  # a point higher above the ground than this needs no guard [m]
SUNK = 0.001  # a point that touches is guarded too where it is deeper than this [m]


class FloorTask(Task):
    """Keeps points above the ground.

    Args:
        points: The contact sites.
        guarded: Function of time that says which of them to guard (not those that touch, unless
            they have sunk); all if absent.
        name: Name.
        gains: ``stiffness`` and ``damping``.
    """

    initialises = True

    def __init__(
        self,
        points: SitePoints,
        guarded: Callable[[float], Bool[Array, " n_points"]] | None = None,
        name: str = "floor",
        stiffness: float = 1600.0,
        **gains,
    ):
        super().__init__(name, stiffness=stiffness, **gains)
        self.points, self._guarded = points, guarded
        self._known: tuple[object, float] = (None, np.nan)
        self._low = np.zeros(len(points), dtype=bool)

    def _which(self, state, time):
        if self._known[0] is not state or self._known[1] != time:
            height = self.points.height(state)
            which = height < NEAR
            if self._guarded is not None:
                which &= self._guarded(time) | (height < -SUNK)
            self._known, self._low = (state, time), which
        return self._low

    def error(self, state, time):
        """Return the heights of the points that are guarded [m]."""
        return self.points.height(state)[self._which(state, time)]

    def jacobian(self, state, time):
        """Return the Jacobian of these heights."""
        return state.jacobian(self.points)[self._which(state, time), 2]

    def bias_acceleration(self, state, time):
        """Return the vertical acceleration of the points where nothing accelerates [m/s²]."""
        return state.bias_acceleration(self.points)[self._which(state, time), 2]

    def level(self, state, time):
        """Return the rows, as inequalities."""
        rows = super().level(state, time)
        return Level(rows.matrix, rows.lower, np.full(len(rows.lower), np.inf), self.name)

    def position_level(self, state, time):
        """Return the rows that lift sunken points out of the ground, as inequalities."""
        rows = super().position_level(state, time)
        return Level(rows.matrix, rows.lower, np.full(len(rows.lower), np.inf), self.name)

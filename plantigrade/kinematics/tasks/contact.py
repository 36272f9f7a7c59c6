r"""Points that rest on the ground.

A point in contact does not move: :math:`v_c = 0`, hence :math:`a_c = 0` [Baraff1993]_. A contact
that begins stops its points at once (an inelastic impact); from then on each is held at the spot
where it landed and, should it have landed beside the ground, let down onto it.

Contact points of one segment cannot move independently: their rows are reduced to the (at most
six) motions of that segment, without loss: with :math:`v_{points} = X \, t` for the segment's twist
:math:`t` and :math:`X = Q R`, the least-squares problem of :math:`Q^T v_{points}` is the same.
"""

from collections.abc import Callable

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.kinematics.hierarchy import Level
from plantigrade.kinematics.state import PointSet, State
from plantigrade.kinematics.tasks.task import Task


class ContactTask(Task):
    """Holds points that touch the ground.

    Args:
        points: The contact points: centres of small spheres.
        radius: Radius of each sphere [m].
        active: Function of time that says which of them touch.
        name: Name.
        gains: ``stiffness`` and ``damping``.
    """

    def __init__(
        self,
        points: PointSet,
        radius: Float[Array, " n_points"],
        active: Callable[[float], Bool[Array, " n_points"]],
        name: str = "contact",
        **gains,
    ):
        super().__init__(name, **gains)
        self.points, self.radius, self._schedule = points, radius, active
        self.spot = np.full((len(points), 3), np.nan)
        self.on = np.zeros(len(points), dtype=bool)

    def begin(self, state, time):
        """Note which points touch now; a new one is held at the spot it is above."""
        on = self._schedule(time)
        new = on & ~self.on
        if new.any():
            self.spot[new] = state.position(self.points)[new]
            self.spot[new, 2] = self.radius[new]
        self.on = on.copy()
        return bool(new.any())

    def error(self, state: State, time: float):
        """Return how far each point is from its spot [m]."""
        return (state.position(self.points)[self.on] - self.spot[self.on]).ravel()

    def jacobian(self, state: State, time: float):
        """Return the Jacobian of the points that touch."""
        return state.jacobian(self.points)[self.on].reshape(-1, state.model.nv)

    def drift(self, state: State, time: float):
        """Return their acceleration where nothing accelerates [m/s²]."""
        return state.drift(self.points)[self.on].ravel()

    def level(self, state, time):
        """Return the rows, reduced to the motions of the segments that touch."""
        return self._reduced(state, super().level(state, time))

    def velocity_level(self, state, time):
        """Return the rows that stop the points, reduced likewise."""
        return self._reduced(state, super().velocity_level(state, time))

    def _reduced(self, state: State, full: Level) -> Level:
        body = self.points.body[self.on]
        position = state.position(self.points)[self.on]
        matrix, right = [], []
        for segment in np.unique(body):
            mine = np.flatnonzero(body == segment)
            rows = (3 * mine[:, None] + np.arange(3)).ravel()
            A, b = full.matrix[rows], full.lower[rows]
            if len(mine) > 2:
                Q = np.linalg.qr(_twist(position[mine] - position[mine].mean(axis=0)))[0]
                A, b = Q.T @ A, Q.T @ b
            matrix.append(A)
            right.append(b)
        if not matrix:
            return full
        return Level.equation(np.vstack(matrix), np.concatenate(right), self.name)


def _twist(arm: np.ndarray) -> np.ndarray:
    """Return the matrix from a segment's twist to its points' velocities (3 n, 6)."""
    X = np.zeros((len(arm), 3, 6))
    X[:, 0, 0] = X[:, 1, 1] = X[:, 2, 2] = 1.0
    X[:, 0, 4], X[:, 0, 5] = arm[:, 2], -arm[:, 1]
    X[:, 1, 3], X[:, 1, 5] = -arm[:, 2], arm[:, 0]
    X[:, 2, 3], X[:, 2, 4] = arm[:, 1], -arm[:, 0]
    return X.reshape(-1, 6)

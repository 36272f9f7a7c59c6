r"""Points that rest on the ground.

A point in contact does not move: :math:`v_c = 0`, hence :math:`a_c = 0` [Baraff1993]_. A contact
that begins stops its points at once (an inelastic impact); from then on each is held at the spot
where it landed. A point that by the schedule should touch but is still above the ground comes down
first, free to move along it.

Contact points of one segment cannot move independently: their rows are reduced to the (at most
six) motions of that segment, without loss: with :math:`v_{points} = X \, t` for the segment's twist
:math:`t` and :math:`X = Q R`, the least-squares problem of :math:`Q^T v_{points}` is the same.
"""

from collections.abc import Callable

import numpy as np

from plantigrade.arrays import Array, Bool
from plantigrade.errors import ParameterError
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import State
from plantigrade.wbc.hierarchy import Level
from plantigrade.wbc.tasks.task import Task

TOUCHING = 0.002  # a point no higher than this above the ground touches it [m]
SOLE = 60.0  # rate at which a landing sole comes to rest [1/s]: 0.2 m/s stop within 2 mm
APPROACH = 40.0  # rate at which a point comes down that should touch already [1/s]


class ContactTask(Task):
    """Holds points that touch the ground, and brings down those that should.

    Args:
        points: The contact sites.
        active: Function of time that says which of them should touch.
        name: Name.
        gains: ``stiffness`` and ``damping``.

    Attributes:
        on: Which points touch.
        coming: Which should touch and do not yet.
        spot: Where each that touches is held: centre of the sphere [m].
    """

    causes_impact = True

    def __init__(
        self,
        points: SitePoints,
        active: Callable[[float], Bool[Array, " n_points"]],
        name: str = "contact",
        **gains,
    ):
        super().__init__(name, **gains)
        order = np.unique(points.body, return_index=True)[1]
        if (np.diff(points.body) != 0).sum() != len(order) - 1:
            raise ParameterError("contact points of one segment must follow one another")
        self.points, self._schedule = points, active
        self._bases: dict[bytes, np.ndarray] = {}
        self.reset()

    def reset(self):
        """Forget the spots; the next instant is the first."""
        n = len(self.points)
        self.spot = np.full((n, 3), np.nan)
        self.on, self.coming = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)

    def begin(self, state, time):
        """Note which points touch now; a new one is held where it lands."""
        scheduled = self._schedule(time)
        position = state.position(self.points)
        low = self.points.height(state) < TOUCHING
        on = scheduled & (self.on | low)
        new = on & ~self.on
        if new.any():
            self.spot[new] = position[new]
            self.spot[new, 2] = self.points.radius[new]
        self.on, self.coming = on, scheduled & ~on
        return bool(new.any())

    def error(self, state: State, time: float):
        """Return how far points are from their spots, then how high the coming ones are [m]."""
        position = state.position(self.points)
        held = (position[self.on] - self.spot[self.on]).ravel()
        return np.concatenate([held, self.points.height(state)[self.coming]])

    def jacobian(self, state: State, time: float):
        """Return the Jacobian of the points that touch, then of the coming ones' heights."""
        J = state.jacobian(self.points)
        return np.concatenate([J[self.on].reshape(-1, state.model.nv), J[self.coming, 2]])

    def bias_acceleration(self, state: State, time: float):
        """Return their acceleration where nothing accelerates [m/s²]."""
        bias = state.bias_acceleration(self.points)
        return np.concatenate([bias[self.on].ravel(), bias[self.coming, 2]])

    def level(self, state, time):
        """Return the rows, reduced to the motions of the segments that touch."""
        full = super().level(state, time)
        n = 3 * int(self.on.sum())
        if len(full.lower) > n:  # those that come down have a rate of their own
            rate = full.matrix[n:] @ state.qvel
            height = self.points.height(state)[self.coming]
            bias = self.bias_acceleration(state, time)[n:]
            full.lower[n:] = -(APPROACH**2) * height - 2 * APPROACH * rate - bias
        return self._reduced(state, full)

    def position_level(self, state, time):
        """Return the rows that bring the points to their spots, reduced likewise."""
        return self._reduced(state, super().position_level(state, time))

    def velocity_level(self, state, time):
        """Return the rows that stop the points that touch, reduced likewise."""
        n = 3 * int(self.on.sum())
        full = super().velocity_level(state, time)
        return self._reduced(state, Level.equation(full.matrix[:n], full.lower[:n], self.name))

    def _reduced(self, state: State, full: Level) -> Level:
        body = self.points.body[self.on]
        matrix, right = [full.matrix[3 * len(body) :]], [full.lower[3 * len(body) :]]
        for segment in np.unique(body):
            mine = np.flatnonzero(body == segment)
            rows = slice(3 * mine[0], 3 * mine[-1] + 3)  # points of a segment are neighbours
            A, b = full.matrix[rows], full.lower[rows]
            if len(mine) > 2:
                turned = self._motions(state, int(segment), len(mine))
                A, b = turned @ A, turned @ b
            matrix.append(A)
            right.append(b)
        return Level.equation(np.concatenate(matrix), np.concatenate(right), self.name)

    def _motions(self, state: State, segment: int, n: int) -> np.ndarray:
        """Return an orthonormal basis of what a segment's points can do together (6, 3 n).

        It is fixed to the segment, so that it is computed once for each set of points.
        """
        on = self.on & (self.points.body == segment)
        key = on.tobytes()
        if key not in self._bases:
            local = self.points.local[on]
            Q = np.linalg.qr(_twist(local - local.mean(axis=0)))[0]
            self._bases[key] = Q.T.reshape(6, n, 3)
        return (self._bases[key] @ state.rotation(segment).T).reshape(6, 3 * n)


class SoleContactTask(ContactTask):
    """Holds the points of a sole from the moment they should touch, wherever they are.

    A point that is not on its spot yet is drawn there by a critically damped spring, as heel pad
    and shoe do; nothing stops at once.
    """

    def begin(self, state, time):
        """Note which points are held now; a new one is held at the spot it is above."""
        on = self._schedule(time)
        new = on & ~self.on
        if new.any():
            position = state.position(self.points)
            self.spot[new] = position[new]
            self.spot[new, 2] = self.points.radius[new]
        self.on, self.coming = on.copy(), np.zeros_like(on)
        return bool(new.any())


def _twist(arm: np.ndarray) -> np.ndarray:
    """Return the matrix from a segment's twist to its points' velocities (3 n, 6)."""
    X = np.zeros((len(arm), 3, 6))
    X[:, 0, 0] = X[:, 1, 1] = X[:, 2, 2] = 1.0
    X[:, 0, 4], X[:, 0, 5] = arm[:, 2], -arm[:, 1]
    X[:, 1, 3], X[:, 1, 5] = -arm[:, 2], arm[:, 0]
    X[:, 2, 3], X[:, 2, 4] = arm[:, 1], -arm[:, 0]
    return X.reshape(-1, 6)

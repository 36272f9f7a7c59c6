r"""Points that rest on the ground, points that stay above it.

A point in contact does not move: :math:`v_c = 0`, :math:`a_c = 0` [Baraff1993]_. A contact
that begins stops its points at once (an inelastic impact); from then on each is held at the spot
where it landed. A point that by the schedule should touch but is still above the ground comes down
first, free to move along it.

Contact points of one segment cannot move independently: their rows are reduced to the (at most
six) motions of that segment, without loss: with :math:`v_{points} = X \, t` for the segment's twist
:math:`t` and :math:`X = Q R`, the least-squares problem of :math:`Q^T v_{points}` is the same.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool
from plantigrade.constants import FRICTION
from plantigrade.contact.site import contact_sites
from plantigrade.errors import ParameterError
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.wbc.rows import Rows
from plantigrade.wbc.tasks.task import Task
from plantigrade.wbc.touching import Touching


@dataclass(frozen=True, kw_only=True)
class ContactSettings:
    """When points of the soles touch, and how those come down that do not."""

    touching_height: float = 0.002
    """Height above the ground up to which a point touches it [m]. Chosen."""
    approach_rate: float = 40.0
    """Rate at which a point comes down that should touch already, and natural frequency of the
    critically damped floor that slows points which approach it [1/s]. Chosen."""
    guarded_height: float = 0.10
    """Height above the ground up to which a floor guards points [m]. Chosen: farther points cannot
    reach it within a tick."""
    guarded_depth: float = 0.001
    """Depth in the ground from which a floor guards points that should touch, too [m]. Chosen."""


class ContactTask(Task):
    """Holds points that touch the ground, and brings down those that should.

    :meth:`begin` has to be called at every instant.

    Args:
        points: The contact sites.
        active: Function of time that says which of them should touch; always all if absent.
        settings: When a point touches, and how it comes down.

    Attributes:
        on: Which points touch.
        coming: Which should touch and do not yet.
        spot: Where each that touches is held: centre of the sphere [m].
    """

    causes_impact = True

    def __init__(
        self,
        points: SitePoints,
        active: Callable[[float], Bool[Array, " n_points"]] | None = None,
        name: str = "contact",
        *,
        settings: ContactSettings | None = None,
        **gains,
    ):
        super().__init__(name, **gains)
        self.settings = settings or ContactSettings()
        order = np.unique(points.body, return_index=True)[1]
        if (np.diff(points.body) != 0).sum() != len(order) - 1:
            raise ParameterError("contact points of one segment must follow one another")
        all_on = np.ones(len(points), dtype=bool)
        self.points, self._schedule = points, active or (lambda time: all_on)
        self._known: dict[bytes, list] = {}  # by the points that touch
        self.reset()

    @classmethod
    def of(cls, human: Human, **gains) -> "ContactTask":
        """Return the task that keeps both soles of a person on the ground."""
        return cls(SitePoints(human, contact_sites(human)), **gains)

    def touching(self, state: BodyState, friction: float = FRICTION) -> Touching:
        """Return the points that touch, as level ground carries them."""
        on = self.on
        place = state.position(self.points)[on]
        place[:, 2] -= self.points.radius[on]
        normal = np.tile([0.0, 0.0, 1.0], (len(place), 1))
        return Touching(self.points.body[on], place, normal, friction)

    def reset(self):
        """Forget the spots; the next instant is the first."""
        n = len(self.points)
        self.spot = np.full((n, 3), np.nan)
        self.on, self.coming = np.zeros(n, dtype=bool), np.zeros(n, dtype=bool)

    def begin(self, state, time):
        """Note which points touch now; a new one is held where it lands."""
        scheduled = self._schedule(time)
        on = self._held(state, scheduled)
        new = on & ~self.on
        if new.any():
            self.spot[new] = state.position(self.points)[new]
            self.spot[new, 2] = self.points.radius[new]
        self.on, self.coming = on, scheduled & ~on
        return bool(new.any())

    def _held(self, state: BodyState, scheduled: Bool[Array, " n"]) -> Bool[Array, " n"]:
        """Return which points are held of those that are to touch: once they have come down."""
        return scheduled & (self.on | (self.points.height(state) < self.settings.touching_height))

    def error(self, state: BodyState, time: float):
        """Return how far points are from their spots, then how high the coming ones are [m]."""
        position = state.position(self.points)
        held = (position[self.on] - self.spot[self.on]).ravel()
        return np.concatenate([held, self.points.height(state)[self.coming]])

    def jacobian(self, state: BodyState, time: float):
        """Return the Jacobian of the points that touch, then of the coming ones' heights."""
        J = state.jacobian(self.points)
        return np.concatenate([J[self.on].reshape(-1, state.model.nv), J[self.coming, 2]])

    def bias_acceleration(self, state: BodyState, time: float):
        """Return their acceleration where nothing accelerates [m/s²]."""
        bias = state.bias_acceleration(self.points)
        return np.concatenate([bias[self.on].ravel(), bias[self.coming, 2]])

    def acceleration(self, state, time, jacobian=None):
        """Return the desired accelerations; points that come down have a rate of their own."""
        desired = super().acceleration(state, time, jacobian)
        if self.coming.any():
            height = self.points.height(state)[self.coming]
            rate = self.velocity(state, time, jacobian)[-len(height) :]
            fast = self.settings.approach_rate
            desired[-len(height) :] = -(fast**2) * height - 2 * fast * rate
        return desired

    def velocity_rows(self, state, time):
        """Return the rows that stop the points that touch, reduced likewise."""
        n = 3 * int(self.on.sum())
        full = self.jacobian(state, time)[:n]
        return self._reduced(state, Rows(full, np.zeros(n), self.weight, self.name))

    def rows(self, state, time=0.0, *, acceleration=None):
        """Return the rows, reduced to the motions of the segments that touch."""
        return self._reduced(state, super().rows(state, time, acceleration=acceleration))

    def position_rows(self, state, time):
        """Return the rows that bring the points to their spots, reduced likewise."""
        return self._reduced(state, super().position_rows(state, time))

    def _reduced(self, state: BodyState, full: Rows) -> Rows:
        n = 3 * int(self.on.sum())
        matrix, right = [full.matrix[n:]], [full.right[n:]]
        for segment, rows, basis in self._segments():
            A, b = full.matrix[rows], full.right[rows]
            if basis is not None:
                turned = (basis @ state.rotation(segment).T).reshape(6, -1)
                A, b = turned @ A, turned @ b
            matrix.append(A)
            right.append(b)
        return self._asks(np.concatenate(matrix), np.concatenate(right))

    def _segments(self) -> list[tuple[int, slice, np.ndarray | None]]:
        """Return the segments that touch, their rows, and what more than two points can do there.

        That is an orthonormal basis (6, n, 3), fixed to the segment.
        """
        key = self.on.tobytes()
        if key not in self._known:
            body, local = self.points.body[self.on], self.points.local[self.on]
            self._known[key] = []
            for segment in np.unique(body):
                mine = np.flatnonzero(body == segment)  # neighbours
                arm = local[mine] - local[mine].mean(axis=0)
                Q = np.linalg.qr(_twist(arm))[0].T.reshape(6, -1, 3) if len(mine) > 2 else None
                self._known[key].append((int(segment), slice(3 * mine[0], 3 * mine[-1] + 3), Q))
        return self._known[key]


class SoleContactTask(ContactTask):
    """Holds the points of a sole from the moment they should touch, wherever they are.

    A point that is not on its spot yet is drawn there by a critically damped spring, as heel pad
    and shoe do; nothing stops at once.
    """

    def _held(self, state, scheduled):
        """Return all of them: each at the spot it is above."""
        return scheduled.copy()


class FloorTask(Task):
    r"""Keeps points above the ground.

    An inequality, not a tracked height: with :math:`h` the height of a point,

    .. math:: \ddot h \ge -\lambda_p h - \lambda_d \dot h ,

    which leaves the point alone as long as it does not approach the ground too fast.

    Args:
        points: The contact sites.
        guarded: Function of time that says which of them to guard (not those that touch, unless
            they have sunk); all if absent.
        settings: Which points are guarded, and how firmly.
    """

    initialises = at_least = True

    def __init__(
        self,
        points: SitePoints,
        guarded: Callable[[float], Bool[Array, " n_points"]] | None = None,
        name: str = "floor",
        *,
        settings: ContactSettings | None = None,
    ):
        self.settings = settings or ContactSettings()
        super().__init__(name, stiffness=self.settings.approach_rate**2)
        self.points, self._guarded = points, guarded
        self._known: tuple[object, float] = (None, np.nan)
        self._low = np.zeros(len(points), dtype=bool)

    def _which(self, state, time):
        if self._known[0] is not state or self._known[1] != time:
            height = self.points.height(state)
            which = height < self.settings.guarded_height
            if self._guarded is not None:
                which &= self._guarded(time) | (height < -self.settings.guarded_depth)
            self._known, self._low = (state, time), which
        return self._low

    def rests(self, state, time):
        """Return whether no point is guarded."""
        return not self._which(state, time).any()

    def error(self, state, time):
        """Return the heights of the points that are guarded [m]."""
        return self.points.height(state)[self._which(state, time)]

    def jacobian(self, state, time):
        """Return the Jacobian of these heights."""
        return state.jacobian(self.points)[self._which(state, time), 2]

    def bias_acceleration(self, state, time):
        """Return the vertical acceleration of the points where nothing accelerates [m/s²]."""
        return state.bias_acceleration(self.points)[self._which(state, time), 2]


def _twist(arm: np.ndarray) -> np.ndarray:
    """Return the matrix from a segment's twist to its points' velocities (3 n, 6)."""
    X = np.zeros((len(arm), 3, 6))
    X[:, 0, 0] = X[:, 1, 1] = X[:, 2, 2] = 1.0
    X[:, 0, 4], X[:, 0, 5] = arm[:, 2], -arm[:, 1]
    X[:, 1, 3], X[:, 1, 5] = -arm[:, 2], arm[:, 0]
    X[:, 2, 3], X[:, 2, 4] = arm[:, 1], -arm[:, 0]
    return X.reshape(-1, 6)

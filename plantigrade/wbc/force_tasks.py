r"""The tasks of a gait that moves by forces, where they differ from those of one that just moves.

Without forces a velocity may jump, and a body may turn as it likes. With them

* a foot comes down so that its heel arrives at the ground when the contact begins
  (:class:`LandingTask`), and what speed is left is taken up by the sole (:class:`SoleContactTask`):
  no impact, no impulse;
* a body that is off its path puts its feet where they catch it (:class:`PlacingHeelTask`);
* turning has a price: the angular momentum changes only by the moment of forces that act within
  the soles. Linear and angular momentum are the two halves of one law, and walking regulates both
  [Herr2008]_ (:class:`AngularMomentumTask`);
* a posture is passed at the speed at which the person passed it, not stopped at
  (:class:`PassingPosture`): stopping 42 joints four times a stride takes moments nobody has.
"""

from collections.abc import Callable, Sequence

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import PointSet, State
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.spatial.conventions import rotation_matrix
from plantigrade.wbc.hierarchy import Level
from plantigrade.wbc.tasks import ContactTask, PointTask, PostureTask, Task

SOLE = 60.0  # rate at which a landing sole comes to rest [1/s]: 0.2 m/s stop within 2 mm
LEAD = 0.15  # a foot is led to the ground this long before it touches [s]
SHORTEST = 0.03  # time to go below which its gains grow no further [s]
FURTHEST = 0.15  # a foot is put down at most this far from its recorded place [m]
LEVER = 0.5  # an angular momentum error counts as a force error with this lever arm [m]


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
            self.spot[new, 2] = self.radius[new]
        self.on, self.coming = on.copy(), np.zeros_like(on)
        return bool(new.any())


class LandingTask(Task):
    r"""Brings parts of the feet to the ground at the time they are to touch it, at rest.

    With :math:`h` the mean height of the part's points and :math:`T` the time to go,

    .. math:: \ddot h = -\frac{6}{T^2} h - \frac{4}{T} \dot h,

    the path of least acceleration to :math:`h = \dot h = 0`.

    Args:
        points: The contact points: centres of small spheres.
        radius: Radius of each sphere [m].
        landings: Which points come down together, and when [s].
        name: Name.
    """

    def __init__(
        self,
        points: PointSet,
        radius: Float[Array, " n_points"],
        landings: Sequence[tuple[np.ndarray, float]],
        name: str = "landing",
    ):
        super().__init__(name)
        self.points, self.radius, self.landings = points, radius, landings

    def _coming(self, time: float) -> list[tuple[np.ndarray, float]]:
        return [(i, at - time) for i, at in self.landings if 0 < at - time < LEAD]

    def _means(self, values, time: float) -> np.ndarray:
        coming = self._coming(time)
        if not coming:
            return np.zeros((0, *values.shape[1:]))
        return np.array([values[i].mean(axis=0) for i, _ in coming])

    def error(self, state, time):
        """Return the mean height of each part that comes down [m]."""
        return self._means(state.position(self.points)[:, 2] - self.radius, time)

    def jacobian(self, state, time):
        """Return the Jacobian of these heights."""
        return self._means(state.jacobian(self.points)[:, 2], time)

    def drift(self, state, time):
        """Return their acceleration where nothing accelerates [m/s²]."""
        return self._means(state.drift(self.points)[:, 2], time)

    def level(self, state, time):
        """Return the rows this task asks of the generalised acceleration."""
        left = np.array([max(t, SHORTEST) for _, t in self._coming(time)])
        matrix = self.jacobian(state, time)
        wanted = -6 * self.error(state, time) / left**2 - 4 * (matrix @ state.qvel) / left
        return Level.equation(matrix, wanted - self.drift(state, time), self.name)


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
        name: Name.
    """

    def __init__(self, point: PointSet, target: Trajectory, directions, com: Trajectory, name: str):
        super().__init__(point, target, directions, name)
        self.com = com

    def error(self, state, time):
        """Return the way from the displaced target to the point, along the directions [m]."""
        here, speed, _ = self.com(time)
        slow = np.sqrt(max(state.com[2], 0.1) / np.linalg.norm(state.model.opt.gravity))
        away = state.com - here + slow * (state.com_jacobian @ state.qvel - speed)
        size = float(np.linalg.norm(away))
        if size > FURTHEST:
            away = away * (FURTHEST / size)
        return super().error(state, time) - self._directions(state, time) @ away


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

    def drift(self, state, time):
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


class PassingPosture(PostureTask):
    r"""Draws every coordinate to a fixed posture, to pass it at a given time and velocity.

    With :math:`e` the way from the posture :math:`q_e`, which is passed at the velocity
    :math:`v_e`, and :math:`T` the time to go,

    .. math:: \dot v = -\frac{6}{T^2} e - \frac{1}{T} (4 v + 2 v_e),

    the path of least acceleration from here and now to there and then. In the last moments, when
    the gains would grow without end, the body follows the straight line into the posture.

    Args:
        target: Function of time that returns the posture of the present phase and the time at
            which the phase ends [s].
        velocity: Function of time that returns the velocity at which the posture is passed.
        shortest: Shortest time to go [s].
        name: Name.
    """

    def __init__(
        self,
        target: Callable[[float], tuple[Float[Array, " nq"], float]],
        velocity: Callable[[float], Float[Array, " nv"]],
        *,
        shortest: float = 0.07,
        name: str = "posture",
    ):
        super().__init__(target, shortest=shortest, name=name)
        self.velocity = velocity

    def acceleration(self, state, time) -> Float[Array, " nv"]:
        """Return the generalised acceleration the posture asks for."""
        posture, end = self.target(time)
        passed, left = self.velocity(time), end - time
        error = state.difference(posture)
        if left >= self.shortest:
            return -6 * error / left**2 - (4 * state.qvel + 2 * passed) / left
        error = error + passed * max(left, 0.0)
        short = self.shortest
        return -6 * error / short**2 - 4 * (state.qvel - passed) / short

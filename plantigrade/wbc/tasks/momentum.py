r"""The centre of mass and the angular momentum about it.

Linear and angular momentum change only by forces that act within the soles, and walking regulates
both [Herr2008]_.
"""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.kinematics.state import BodyState
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.wbc.tasks.task import Target, Task

_AXES = {"x": 0, "y": 1, "z": 2}


class ComTask(Task):
    """Moves the centre of mass to a place, or along a trajectory.

    Args:
        target: The place, or its trajectory [m].
        axes: Which world axes: ``"xyz"``, ``"xy"``, ``"z"``, …
    """

    def __init__(self, target: Target = None, axes: str = "xyz", name: str = "", **gains):
        super().__init__(name or f"centre of mass {axes}", target, **gains)
        self._axes = slice(None) if axes == "xyz" else np.array([_AXES[a] for a in axes])

    def aim(self, time):
        """Return value, velocity and acceleration of the target, in the axes that count."""
        target = super().aim(time)
        if isinstance(self._axes, slice):
            return target
        return tuple(part[self._axes] if np.ndim(part) else part for part in target)

    def error(self, state, time):
        """Return the way from the target to the centre of mass [m]."""
        return state.com[self._axes] - self.aim(time)[0]

    def jacobian(self, state, time):
        """Return the Jacobian of the centre of mass."""
        return state.com_jacobian[self._axes]

    def bias_acceleration(self, state, time):
        """Return its acceleration where nothing accelerates [m/s²]."""
        return state.com_bias_acceleration[self._axes]

    def distance(self, state, time: float) -> float:
        """Return how far the centre of mass is from its target, in the axes that count [m]."""
        return float(np.linalg.norm(self.error(state, time)))


class LinearMomentumTask(ComTask):
    """The same by the linear momentum, the root's rows of the equations of motion.

    Where these are needed anyway, its Jacobian costs nothing.

    Args:
        mass: Body mass [kg].
    """

    def __init__(self, mass: float, target: Target = None, axes: str = "xyz", **gains):
        super().__init__(target, axes, **gains)
        self.mass = mass

    def jacobian(self, state, time):
        """Return the Jacobian of the centre of mass."""
        return (state.mass_matrix[:3] / self.mass)[self._axes]

    def bias_acceleration(self, state, time):
        """Return its acceleration where nothing accelerates [m/s²]."""
        return (state.bias[:3] / self.mass + state.model.opt.gravity)[self._axes]


class AngularMomentumTask(Task):
    r"""Regulates the angular momentum about the centre of mass, and how far the body has turned.

    :math:`L = A(q) v` with the rows :math:`A` of the centroidal momentum matrix [Orin2013]_. No
    configuration has :math:`L` as its rate; the error is the tangent step from the posture of the
    moment, weighted as :math:`L` weighs velocities, :math:`e = A(q)\,(q \ominus q^*(t))`, the
    whole body's share in having turned too far; its rate is taken as :math:`L - L^*(t)`.

    All rows are divided by mass and a lever arm, so that they compare with those of the centre of
    mass [m/s²].

    Args:
        target: Angular momentum, and its rate [kg m²/s]; rest if absent.
        posture: Path of the configuration; how far the body has turned does not count if absent.
        turn: Desired further turn of the body, as momentum integrated [kg m²]; none if absent.
        lever: Lever arm at which an error of the moment counts as one of the force [m].
    """

    def __init__(
        self,
        target: Target = None,
        posture: Trajectory | None = None,
        name: str = "angular momentum",
        stiffness: float = 25.0,
        turn: Trajectory | None = None,
        lever: float = 1.0,
        **gains,
    ):
        super().__init__(name, target, stiffness=stiffness, **gains)
        self.posture, self.turn, self.lever = posture, turn, lever
        self._of: BodyState | None = None
        self._map = np.zeros((3, 6))

    def error(self, state, time):
        """Return by how much the whole body has turned too far [m]."""
        if self.posture is None:
            return np.zeros(3)
        posture = self.posture(time)[0].copy()
        posture[3:7] /= np.linalg.norm(posture[3:7])
        error = self.jacobian(state, time) @ state.difference(posture)
        return error if self.turn is None else error - self.turn(time)[0] / self._scale(state)

    def aim(self, time):
        """Return nothing, and angular momentum and its rate on the path [kg m²/s, N m]."""
        if self.target is None:
            return 0.0, 0.0, 0.0
        momentum, rate, _ = super().aim(time)
        return 0.0, momentum, rate

    def jacobian(self, state, time):
        """Return the angular rows of the centroidal momentum matrix."""
        return self._about_com(state) @ state.mass_matrix[:6]

    def bias_acceleration(self, state, time):
        """Return the rate of the angular momentum where nothing accelerates."""
        return self._about_com(state) @ state.bias[:6]

    def acceleration(self, state, time, jacobian=None):
        """Return the desired rate of the angular momentum."""
        _, momentum, rate = self.aim(time)
        scale = self._scale(state)
        right = rate / scale - self.stiffness * self.error(state, time)
        return right - self.damping * (self.velocity(state, time, jacobian) - momentum / scale)

    def _scale(self, state: BodyState) -> float:
        return state.mass * self.lever

    def _about_com(self, state: BodyState) -> Float[Array, "3 6"]:
        """Return what makes scaled moments about the centre of mass of wrenches at the root."""
        if self._of is not state:
            x, y, z = state.com - state.qpos[:3]
            self._of, self._map = state, np.empty((3, 6))
            self._map[:, :3] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
            self._map[:, 3:] = state.rotation(1)
            self._map /= self._scale(state)
        return self._map

"""The frame of a walk: x along it, wherever it leads in the world.

Torques of joints depend neither on the position of a person nor on their heading. A controller that
walks along x walks along any line, if it observes the world in the frame of that line.
"""

from functools import cached_property

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.control.balance.reference import PLATFORM
from plantigrade.kinematics.state import BodyState
from plantigrade.spatial.conventions import about_vertical
from plantigrade.world import SimulatedWorld, State


class HeadingFrame:
    """A frame that is turned about the vertical.

    Attributes:
        origin: Its position, world [m].
        angle: From the x axis of the world to its own, to the left [rad].
    """

    def __init__(self):
        self.origin, self.angle = np.zeros(2), 0.0

    @property
    def is_world(self) -> bool:
        """Whether it is the world's own."""
        return self.angle == 0.0 and not self.origin.any()

    @property
    def turn(self) -> Float[Array, "3 3"]:
        """Rotation from its axes to the world's."""
        return about_vertical(self.angle)

    def to_world(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n 3"]:
        """Return points of the frame in the world [m]."""
        return points @ self.turn.T + [*self.origin, 0.0]

    def to_walk(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n 3"]:
        """Return points of the world in the frame [m]."""
        return (points - [*self.origin, 0.0]) @ self.turn

    def steer(self, ahead: float, left: float, angle: float) -> None:
        """Turn about a point.

        Args:
            ahead: Its position along x [m].
            left: And along y [m].
            angle: Angle of the turn, to the left [rad].
        """
        local = np.array([ahead, left])
        point = self.origin + self.turn[:2, :2] @ local
        self.angle += angle
        self.origin = point - self.turn[:2, :2] @ local

    def shift(self, left: float) -> None:
        """Move it to the left [m]."""
        self.origin = self.origin + left * self.turn[:2, 1]


class ObservedState(State):
    """A state of the world in a frame."""

    def __init__(self, state: State, frame: HeadingFrame):
        self._state, self._turn = state, frame.turn
        self.world, self.time = state.world, state.time
        self.qpos, self.qvel = state.qpos.copy(), state.qvel.copy()
        self.qpos[:3] = frame.to_walk(state.qpos[:3])
        self.qvel[:3] = state.qvel[:3] @ self._turn
        half = np.array([np.cos(0.5 * frame.angle), 0.0, 0.0, -np.sin(0.5 * frame.angle)])
        mujoco.mju_mulQuat(self.qpos[3:7], half, state.qpos[3:7])
        self.qpos.flags.writeable = self.qvel.flags.writeable = False

    @cached_property
    def body(self) -> BodyState:
        """The evaluated body."""
        return self.world.evaluated(self.qpos, self.qvel)

    @cached_property
    def contact_force(self) -> Float[Array, "n_sites 3"]:
        """Force of the ground at each contact sphere [N]."""
        return self._state.contact_force @ self._turn


class Terrain:
    """The ground of a world in a frame, with the plate that may tilt upon it.

    It has those methods of :class:`~plantigrade.contact.ground.Ground` that a walk needs.
    """

    def __init__(self, world: SimulatedWorld, frame: HeadingFrame):
        self._world, self._frame = world, frame
        self.ground: Ground = world.ground
        self.friction, self.steps = self.ground.friction, self.ground.steps
        self.uneven = self.ground.uneven
        self._plate = mujoco.mj_name2id(world.model, mujoco.mjtObj.mjOBJ_BODY, PLATFORM)
        if self._plate >= 0:
            geom = int(world.model.body_geomadr[self._plate])
            model = world.model
            self._top = float(model.geom_pos[geom, 2] + model.geom_size[geom, 2])

    @property
    def moves(self) -> bool:
        """Whether it may tilt."""
        return self._plate >= 0

    def _pose(self) -> tuple[Array, Array]:
        """Return normal and a point of the plate, world."""
        data = self._world.data
        turn = data.xmat[self._plate].reshape(3, 3)
        return turn[:, 2], data.xpos[self._plate] + self._top * turn[:, 2]

    @property
    def normal(self) -> Float[Array, " 3"]:
        """Its normal."""
        up = self.ground.normal if self._plate < 0 else self._pose()[0]
        return up @ self._frame.turn

    def normal_at(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n 3"]:
        """Return the normal of the ground under points."""
        if self._plate < 0 and self.uneven:
            return self.ground.normal_at(self._frame.to_world(points)) @ self._frame.turn
        normal = np.empty(points.shape)
        normal[:] = self.normal
        return normal

    def under(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n"]:
        """Return its height along the normal, under points [m]."""
        origin = np.array([*self._frame.origin, 0.0])
        if self._plate >= 0:
            normal, point = self._pose()
            return np.full(points.shape[:-1], float(normal @ (point - origin)))
        if not (self.uneven or self.steps):
            up = self.ground.normal
            return np.full(points.shape[:-1], self.ground.height - float(up @ origin))
        up = self.ground.normal
        return self.ground.under(self._frame.to_world(points)) - float(up @ origin)

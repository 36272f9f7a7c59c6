"""The ground around a person: height and slope, gaps under soles, and better footsteps.

A foot that lands half on an edge along it rolls over that edge; people avoid it. An edge
across it does little harm: heel and ball are far apart, and the foot lies on both.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.control.gait.person import GaitPerson, SoleShape
from plantigrade.control.gait.phase import Foot
from plantigrade.control.gait.planner import FootstepSettings
from plantigrade.control.gait.swing import SwingOffsetSettings
from plantigrade.control.pendulum.frame import Terrain
from plantigrade.kinematics.state import BodyState
from plantigrade.wbc.tasks.landing import LandingSettings

PARTS = (-1.0, -0.5, 0.0, 0.5, 1.0)  # of the greatest shift of a footstep, that are tried


@dataclass(frozen=True, kw_only=True)
class GroundSettings:
    """Slope around a person, and the search for better footsteps; values were chosen."""

    max_tilt: tuple[float, float] = (0.15, 0.4)
    """Greatest tilt of a sole with the ground, sideways and along it [rad]: over an edge the ankle
    keeps it level; a footstep on such a slope costs 1."""
    shift_scale: tuple[float, float] = (
        FootstepSettings.forward_scale,
        FootstepSettings.lateral_scale,
    )
    """Shifts of a footstep ahead and sideways that cost 1 [leg lengths], as those for balance do;
    the farthest ones that are tried, with those half as far."""
    hysteresis: float = 0.3
    """Cost by which another shift must be better than the last."""
    commitment_time: float = LandingSettings.min_time_left
    """Time before touchdown from which the shift stays as it is [s]; as do gains of feet that
    land."""
    slope_distance: float = 0.3
    """Distance around the person over which height and slope of the ground are taken [leg
    lengths]."""


class Soles(NamedTuple):
    """The contact spheres of a person over the ground."""

    low: Float[Array, "n_sites 3"]
    """Lowest points [m]."""
    height: Float[Array, " n_sites"]
    """Their heights above the ground [m]."""
    normal: Float[Array, "n_sites 3"]
    """Normals of the ground there."""


class LocalGround:
    """The ground around a person.

    Args:
        slope_distance: Distance over which its slope is taken [leg lengths].

    Attributes:
        ground: The ground, which may be seen in another frame.
        normal: Its normal, but for bumps.
    """

    def __init__(self, person: GaitPerson, ground: Ground, slope_distance: float):
        self.person = person
        self.ground: Ground | Terrain = ground
        self.normal: Array = ground.normal
        self._half = slope_distance * person.leg_length

    def replace(self, ground: Terrain) -> None:
        """Take another ground."""
        self.ground, self.normal = ground, ground.normal

    @property
    def is_plane(self) -> bool:
        """Whether the ground is a plane."""
        return not (self.ground.uneven or self.ground.steps)

    def height(self, position: Float[Array, " 3"]) -> float:
        """Return its height at a position [m]."""
        (x, y, z), (ahead, left, _) = self.normal.tolist(), position.tolist()
        return (float(self.ground.under(position)) - x * ahead - y * left) / z

    def slope(self, position: Float[Array, " 3"]) -> tuple[float, Float[Array, " 2"]]:
        """Return mean height about a position [m], and rise along x and y, by distance."""
        if self.is_plane:
            return self.height(position), -self.normal[:2] / self.normal[2]
        half = self._half
        east, north = np.array([half, 0.0, 0.0]), np.array([0.0, half, 0.0])
        around = [self.height(position + way) for way in (east, -east, north, -north)]
        rise = np.array([around[0] - around[1], around[2] - around[3]]) / (2 * half)
        return float(np.mean(around)), rise

    def soles(self, body: BodyState) -> Soles:
        """Return the contact spheres over the ground."""
        centre, radius = body.position(self.person.points), self.person.radius
        if not self.ground.uneven:
            low = centre - radius * self.normal
            height = low @ self.normal - self.ground.under(low)
            return Soles(low, height, np.broadcast_to(self.normal, centre.shape))
        normals = self.ground.normal_at(centre)
        low = centre - radius * normals
        height = (low @ self.normal - self.ground.under(low)) * (normals @ self.normal)
        return Soles(low, height, normals)


class SoleOnGround:
    """One foot, and the ground under it.

    Args:
        leg: Length of the leg [m].
        shape: Shape of the sole; heights of the ground are sampled under heel, middle and ball.
        left: 1 for the left foot, -1 for the right.
        settings: Settings of sole and search.
    """

    def __init__(
        self, leg: float, shape: SoleShape, left: float, settings: GroundSettings | None = None
    ):
        self.settings = own = settings or GroundSettings()
        self.leg, self.left = leg, left
        self._normal, self._shift = np.array([0.0, 0.0, 1.0]), np.zeros(2)
        along = np.linspace(shape.heel_centre, shape.ball, 3)  # beyond, an edge bears nothing
        width = shape.half_width
        self._points = np.array([(x, y) for x in along for y in (width, -width)])
        self._length, self._width = shape.ball - shape.heel_centre, 2.0 * width
        self._scale = leg * np.array(own.shift_scale)
        parts = np.array([(x, y) for x in PARTS for y in PARTS])
        self._tried, self._cost = parts * self._scale, (parts**2).sum(axis=1)

    def heights(
        self, ground: Ground | Terrain, ankles: Float[Array, "n 2"], ahead: Float[Array, " 2"]
    ) -> Float[Array, "n 3 2"]:
        """Return heights of the ground under heel, middle and ball, left and right [m].

        Args:
            ankles: Positions of the ankle [m].
            ahead: Where the foot points, of length one.
        """
        axes = np.array([ahead, [-ahead[1], ahead[0]]])
        points = np.zeros((len(ankles), len(self._points), 3))
        points[:, :, :2] = ankles[:, None] + self._points @ axes
        normal = ground.normal
        height = (ground.under(points) - points @ normal) / normal[2]
        return height.reshape(-1, len(self._points) // 2, 2)

    def normal(
        self,
        ground: Ground | Terrain,
        foot: Foot,
        phase: float,
        ankle: Float[Array, " 2"],
        ahead: Float[Array, " 2"],
        footstep: Float[Array, " 2"] | None,
        landing: Float[Array, " 2"],
    ) -> Float[Array, " 3"]:
        """Return the normal of the sole: in stance, or on the way from there to the footstep.

        Args:
            phase: Phase of the gait [s].
            ankle: Its position, with the sole on the ground [m].
            ahead: Where the foot points, of length one.
            footstep: Where it will land; None if that is not planned [m].
            landing: Where it will point then.
        """
        if foot.in_stance:
            self._normal, self._shift = self.under(ground, ankle, ahead), np.zeros(2)
            return self._normal
        if footstep is None:
            return self._normal
        duration = max(foot.touchdown - foot.lift_off, 1e-3)
        part = min(max((phase - foot.lift_off) / duration, 0.0), 1.0)
        normal = (1.0 - part) * self._normal + part * self.under(ground, footstep, landing)
        return normal / np.linalg.norm(normal)

    def under(
        self, ground: Ground | Terrain, ankle: Float[Array, " 2"], ahead: Float[Array, " 2"]
    ) -> Float[Array, " 3"]:
        """Return the normal of a sole that lies on the ground.

        It rests on what is highest under heel and ball; sideways it follows the ground a little.

        Args:
            ankle: Position of the ankle [m].
            ahead: Where the foot points, of length one.
        """
        height = self.heights(ground, ankle[None], ahead)[0]
        top, (max_roll, max_pitch) = height.max(axis=1), self.settings.max_tilt
        pitch = float(top[2] - top[0]) / self._length
        roll = float((height[:, 0] - height[:, 1]).mean()) / self._width
        pitch, roll = min(max(pitch, -max_pitch), max_pitch), min(max(roll, -max_roll), max_roll)
        x, y = ahead.tolist()
        normal = np.array([-pitch * x + roll * y, -pitch * y - roll * x, 1.0])
        return normal / np.linalg.norm(normal)

    def shift(
        self,
        ground: Ground | Terrain,
        footstep: Float[Array, " 2"],
        other: Float[Array, " 2"],
        axes: Float[Array, "2 2"],
        time: float,
    ) -> Float[Array, " 2"]:
        """Return how far from a planned footstep the foot lands better [m].

        Args:
            footstep: As planned for balance [m].
            other: The other foot [m].
            axes: Where the foot will have ahead and left, as columns.
            time: To touchdown [s].
        """
        own = self.settings
        if time < own.commitment_time:
            return self._shift
        tried = np.vstack([self._tried, self._shift])
        height = self.heights(ground, footstep + tried, axes[:, 0])
        roll = np.abs(height[:, :, 0] - height[:, :, 1]).max(axis=1) / self._width
        top = height.max(axis=2)
        pitch = np.abs(top[:, 2] - top[:, 0]) / self._length
        cost = (roll / own.max_tilt[0]) ** 2 + (pitch / own.max_tilt[1]) ** 2
        cost[:-1] += self._cost
        cost[-1] += ((self._shift / self._scale) ** 2).sum() - own.hysteresis
        outward = self.left * axes[:, 1]
        apart = float((footstep - other) @ outward)
        inward = apart + tried @ outward < min(
            SwingOffsetSettings.min_foot_distance * self.leg, apart
        )
        cost[inward] = np.inf
        self._shift = tried[int(np.argmin(cost))]
        return self._shift

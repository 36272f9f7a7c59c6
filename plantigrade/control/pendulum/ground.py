"""The ground around a person: height, slope, and the gaps under their soles."""

from typing import NamedTuple

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.control.gait.person import Person
from plantigrade.control.pendulum.frame import Terrain
from plantigrade.kinematics.state import State


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
        person: The person.
        ground: The ground.
        slope_distance: Distance over which its slope is taken [leg lengths].

    Attributes:
        ground: The ground, which may be seen in another frame.
        normal: Its normal, but for bumps.
    """

    def __init__(self, person: Person, ground: Ground, slope_distance: float):
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

    def soles(self, body: State) -> Soles:
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

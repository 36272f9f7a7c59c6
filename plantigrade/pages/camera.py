"""Orthographic cameras for pictures of a motion, named after the walker's sides."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError

VIEWS = {
    "side": (90.0, 7.0),
    "left": (-90.0, 7.0),
    "front": (0.0, 7.0),
    "back": (180.0, 7.0),
    "quarter": (50.0, 14.0),
}
"""View → azimuth of the camera from straight ahead towards the walker's right, and elevation
[deg]."""


@dataclass(frozen=True, eq=False)
class Camera:
    """An orthographic camera."""

    #: World direction that points to the right in the picture, unit vector
    right: Float[Array, " 3"]
    up: Float[Array, " 3"]  #: World direction that points up in the picture, unit vector
    towards: Float[Array, " 3"]  #: World direction from the picture to the reader, unit vector

    @classmethod
    def around(cls, forward: Float[Array, " 3"], *, azimuth: float, elevation: float) -> "Camera":
        """Return the camera at an azimuth and elevation relative to a walker.

        Args:
            forward: Horizontal direction of travel, unit vector.
            azimuth: Azimuth of the camera, 0 ahead, 90 at the walker's right [deg].
            elevation: Angle by which the camera looks down [deg].
        """
        a, e = np.radians([azimuth, elevation])
        aside = np.array([forward[1], -forward[0], 0.0])
        level = np.cos(a) * forward + np.sin(a) * aside
        z = np.array([0.0, 0.0, 1.0])
        return cls(
            right=np.cross(z, level),
            up=np.cos(e) * z - np.sin(e) * level,
            towards=np.cos(e) * level + np.sin(e) * z,
        )

    @classmethod
    def named(cls, view: str, forward: Float[Array, " 3"]) -> "Camera":
        """Return the camera of one of :data:`VIEWS`."""
        if view not in VIEWS:
            raise ParameterError(f"view is {view!r}; allowed are {', '.join(VIEWS)}")
        azimuth, elevation = VIEWS[view]
        return cls.around(forward, azimuth=azimuth, elevation=elevation)

    def project(self, points: Float[Array, "*n 3"]) -> Float[Array, "*n 2"]:
        """Return coordinates of points in the picture, to the right and down [m]."""
        return np.stack([points @ self.right, -(points @ self.up)], axis=-1)

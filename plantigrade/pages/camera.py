"""Orthographic cameras, named after the walker's sides, and animated elements of an SVG."""

from collections.abc import Sequence
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


@dataclass(frozen=True)
class AnimationClock:
    """The repeating clock of a picture."""

    seconds: float  #: Duration of one cycle [s]

    def path(self, data: Sequence[str], attributes: str = "") -> str:
        """Return a path that takes successive shapes at equal intervals.

        Args:
            data: Path data with equal commands.
        """
        start = f'<path d="{data[0]}" {attributes}'.rstrip()
        if len(set(data)) == 1:
            return f"{start}/>"
        return f'{start}><animate attributeName="d" {self._when(data)}/></path>'

    def shifted(self, places: Sequence[str], inner: str) -> str:
        """Return elements that move between positions ``"x y"``."""
        start = f'<g transform="translate({places[0]})">{inner}'
        if len(set(places)) == 1:
            return f"{start}</g>"
        values = self._when(places)
        return f'{start}<animateTransform attributeName="transform" type="translate" {values}/></g>'

    def _when(self, values: Sequence[str]) -> str:
        return f'dur="{self.seconds:.3f}s" repeatCount="indefinite" values="{";".join(values)}"'


@dataclass(frozen=True, eq=False)
class Shot:
    """A view of something that moves: point of view, clock, and scale of the drawing."""

    centre: Float[Array, "n 3"]  #: Point at which the camera looks in each frame, world [m]
    camera: Camera  #: The camera
    clock: AnimationClock  #: Clock of the picture
    prefix: str  #: Beginning of the names of the elements
    per_metre: float  #: Drawing units per metre

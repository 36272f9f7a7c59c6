"""Animated elements of an SVG, with constant values where nothing changes."""

from collections.abc import Sequence
from dataclasses import dataclass

from plantigrade.arrays import Array, Float
from plantigrade.pages.camera import Camera


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

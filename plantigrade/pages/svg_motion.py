"""Animated elements of an SVG: values that follow a clock, and stay where they never change."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Clock:
    """The clock of a picture, which starts again when it has run out.

    Attributes:
        seconds: How long it runs [s].
    """

    seconds: float

    def path(self, data: Sequence[str], attributes: str = "") -> str:
        """Return a path that takes one shape after the other, evenly spaced in time.

        Args:
            data: Path data, of the same commands in each.
            attributes: Further attributes, as they are written.
        """
        start = f'<path d="{data[0]}" {attributes}'.rstrip()
        if len(set(data)) == 1:
            return f"{start}/>"
        return f'{start}><animate attributeName="d" {self._when(data)}/></path>'

    def shifted(self, places: Sequence[str], inner: str) -> str:
        """Return elements that move from place to place, each written ``"x y"``."""
        start = f'<g transform="translate({places[0]})">{inner}'
        if len(set(places)) == 1:
            return f"{start}</g>"
        values = self._when(places)
        return f'{start}<animateTransform attributeName="transform" type="translate" {values}/></g>'

    def _when(self, values: Sequence[str]) -> str:
        return f'dur="{self.seconds:.3f}s" repeatCount="indefinite" values="{";".join(values)}"'

"""Outlines in two flat tones: a crescent of shade is left where no light falls."""

from plantigrade.arrays import Array, Float
from plantigrade.pages.shapes import hexadecimal

RIM_TONE, SHADE_TONE = 0.62, 0.84
"""Factors of a colour: of the rim, and of shade. Chosen."""


def two_tones(
    name: str, colour: tuple[float, float, float], light: Float[Array, " 2"], *, far: float = 1.0
) -> tuple[str, str, str]:
    """Return the clip of an outline, the outline in shade, and its lit tone, moved and clipped."""
    return (
        f'<clipPath id="{name}c"><use href="#{name}"/></clipPath>',
        f'<use href="#{name}" fill="{tone(colour, SHADE_TONE * far)}"/>',
        f'<g clip-path="url(#{name}c)"><use href="#{name}" fill="{tone(colour, far)}" '
        f'transform="translate({light[0]:.0f} {light[1]:.0f})"/></g>',
    )


def tone(colour: tuple[float, float, float], factor: float) -> str:
    """Return a colour in 0-1, times a factor, as CSS writes it."""
    red, green, blue = (min(1.0, factor * part) for part in colour)
    return hexadecimal((red, green, blue))

"""A dressed person as layers of an SVG: one smooth outline for each part, in two flat tones.

Parts that belong to one limb share a rim, drawn first, so that no seam shows where they meet. Each
part is filled in its darker tone; the same outline, moved towards the light and clipped by itself,
leaves it as a crescent of shade. Sleeves and shorts have the colours of the sides.
"""

from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import theme
from plantigrade.models.mirror import mirrored_name
from plantigrade.pages.bone_layers import bone_layers
from plantigrade.pages.shapes import RIM_TONE, WHITE_SHARE, rgb, tone, two_tones, whiter
from plantigrade.pages.silhouette import spline_data
from plantigrade.pages.skin_figure import PARTS, DrawnPart, SkinFigure
from plantigrade.pages.svg_animation import Shot

GRID_STEP = 0.005  # Step of the grid on which outlines are found [m]: about a pixel
LIGHT = np.array([-0.009, -0.007])  # Offset of the lit tone: to the left and up [m]. Chosen.
RIM_WIDTH = 0.007  # Width of the rim of a limb [m], half of it outside; chosen
FAR_TONE = 0.88
"""Factor of the colour of a limb that is farther than that of the other side [1]. Chosen."""
FAR_DISTANCE = 0.08
"""How much farther it is [m]. Chosen."""
GARMENT_AHEAD = 0.05
"""Distance by which a garment counts as nearer than what it covers [m]. Chosen."""
SEEN_THROUGH = 0.34  # Opacity of the skin of a foot before its bones [1]; chosen


@dataclass(frozen=True, eq=False)
class _Drawn:
    """A part with its outlines, colour and depth."""

    part: DrawnPart
    outlines: Float[Array, "n count 2"]
    depth: float
    colour: tuple[float, float, float]


def skin_layers(
    figure: SkinFigure, shot: Shot, *, x_ray: bool = False, colour: str = ""
) -> tuple[list[str], tuple[float, float, float, float]]:
    """Return the layers of a person, the far ones first, and their extent.

    Args:
        x_ray: Whether the feet are transparent before their bones.
        colour: One colour for everything and no shade, of a shadow of a motion; none if empty.

    Returns:
        Layers, and left, top, right and bottom in drawing units.
    """
    drawn = [_drawn(figure, part, shot) for part in PARTS]
    limbs: dict[str, list[_Drawn]] = {}
    for each in drawn:
        limbs.setdefault(each.part.limb, []).append(each)
    depths = {limb: float(np.mean([p.depth for p in parts])) for limb, parts in limbs.items()}
    layers = []
    for limb, parts in limbs.items():
        depth, other = depths[limb], mirrored_name(limb)
        far = FAR_TONE if depth < depths[other] - FAR_DISTANCE else 1.0
        bones = ""
        if x_ray and limb.startswith("leg"):
            inner = replace(shot, prefix=f"{shot.prefix}{limb}b")
            bones = "".join(bone_layers(figure, limb[-1], inner))
        own = replace(shot, prefix=f"{shot.prefix}{limb}")
        layers.append((depth, _limb(parts, bones, own, far, colour)))
    ends = np.concatenate([each.outlines.reshape(-1, 2) for each in drawn]) * shot.per_metre
    extent = (*ends.min(axis=0), *ends.max(axis=0))
    return [markup for _, markup in sorted(layers, key=lambda layer: layer[0])], extent


def _drawn(figure: SkinFigure, part: DrawnPart, shot: Shot) -> _Drawn:
    outlines, depth = figure.outlines(part, shot.centre, shot.camera, GRID_STEP)
    colour = rgb(theme.SKIN[part.materials[0]])
    if figure.is_pale(part):
        colour = whiter(colour, WHITE_SHARE)
    return _Drawn(part, outlines, depth, colour)


def _limb(parts: list[_Drawn], bones: str, shot: Shot, far: float, colour: str) -> str:
    """Return the markup of parts that share a rim, the bones of a foot within it."""
    ordered = sorted(parts, key=lambda each: each.depth + GARMENT_AHEAD * each.part.garment)
    names = [f"{shot.prefix}{k}" for k in range(len(ordered))]
    defined = [
        shot.clock.path(spline_data(each.outlines, per_metre=shot.per_metre), f'id="{name}"')
        for name, each in zip(names, ordered, strict=True)
    ]
    if colour:
        fills = "".join(f'<use href="#{name}"/>' for name in names)
        return f'<defs>{"".join(defined)}</defs><g fill="{colour}">{fills}</g>'
    rims, skin, garments = [], ["", "", ""], []
    for name, each in zip(names, ordered, strict=True):
        through = f' opacity="{SEEN_THROUGH}"' if bones and each.part.is_foot else ""
        rim = tone(each.colour, RIM_TONE * far)
        rims.append(f'<use href="#{name}" stroke="{rim}"{through}/>')
        clip, shade, lit = two_tones(name, each.colour, LIGHT * shot.per_metre, far=far)
        if through:
            garments.insert(0, f"{bones}<g{through}>{clip}{shade}{lit}</g>")
        elif each.part.garment:
            garments.append(f"{clip}{shade}{lit}")
        else:  # of parts that meet, all that is lit comes last: no shade where they overlap
            skin = [both + new for both, new in zip(skin, (clip, shade, lit), strict=True)]
    return (
        f"<defs>{''.join(defined)}</defs>"
        f'<g stroke-width="{RIM_WIDTH * shot.per_metre:.0f}" fill="none" '
        f'stroke-linejoin="round">{"".join(rims)}</g>{"".join(skin)}{"".join(garments)}'
    )

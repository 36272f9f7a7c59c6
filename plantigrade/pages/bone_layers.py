"""Bones of a foot as layers of an SVG, its skin seen through, and its contact points."""

import numpy as np

from plantigrade.charts import theme
from plantigrade.pages.shapes import RIM_TONE, rgb, tone, two_tones
from plantigrade.pages.silhouette import spline_data
from plantigrade.pages.skin_figure import PARTS, SkinFigure, outlines_of
from plantigrade.pages.svg_animation import Shot
from plantigrade.skin import foot_bones
from plantigrade.spatial.conventions import rotation_matrix

GRID_STEP = 0.0012
"""Step of the grid on which outlines of bones are found [m]: about a pixel."""
SKIN_GRID_STEP = 0.002
"""Step of the grid on which the outline of the skin about them is found [m]: about two pixels."""
LIGHT = np.array([-0.0022, -0.0018])
"""Offset of the lit tone of a bone: to the left and up [m]. Chosen."""
RIM_WIDTH = 0.0014
"""Width of the rim of a bone, half of it outside [m]: about one pixel."""
SKIN_RIM_WIDTH = 0.003
"""Width of the rim of the skin, half of it outside [m]: about two pixels."""
N_OUTLINE_POINTS = 14  # Control points of a bone, which keep its head and base apart. Chosen.
SKIN_OPACITY = 0.26  # Opacity of the skin before bones [1]: both can be seen. Chosen.
CONTACT_DOT = 0.006  # Diameter of the dot at a contact point [m]. Chosen.


def bone_layers(figure: SkinFigure, side: str, shot: Shot) -> list[str]:
    """Return the bones of a foot, the far ones first; none where the foot has no bones.

    Args:
        side: ``"r"`` or ``"l"``.
    """
    layers, colour = [], rgb(theme.BONE)
    own = [bone for bone in foot_bones(figure.human) if bone.name.endswith(f"_{side}")]
    for k, bone in enumerate(own):
        turn = rotation_matrix(figure.quats[:, bone.body])
        place = figure.positions[:, bone.body] - shot.centre
        vertices = place[:, None] + bone.vertices @ np.swapaxes(turn, 1, 2)
        outlines, depth = outlines_of(
            vertices, bone.faces, shot.camera, N_OUTLINE_POINTS, GRID_STEP
        )
        name = f"{shot.prefix}{k}"
        path = shot.clock.path(spline_data(outlines, per_metre=shot.per_metre), f'id="{name}"')
        markup = (
            f'<defs>{path}</defs><use href="#{name}" fill="none" stroke="{tone(colour, RIM_TONE)}" '
            f'stroke-width="{RIM_WIDTH * shot.per_metre:.0f}"/>'
            f"{''.join(two_tones(name, colour, LIGHT * shot.per_metre))}"
        )
        layers.append((depth, markup))
    return [markup for _, markup in sorted(layers, key=lambda layer: layer[0])]


def veil(figure: SkinFigure, side: str, shot: Shot) -> str:
    """Return the skin of a foot and its shank, seen through; arguments as of bones."""
    defined, rims, fills = [], [], []
    for part in PARTS:
        if part.name not in (f"foot_{side}", f"shank_{side}"):
            continue
        outlines, _ = figure.outlines(part, shot.centre, shot.camera, SKIN_GRID_STEP)
        name = f"{shot.prefix}{part.name}"
        defined.append(
            shot.clock.path(spline_data(outlines, per_metre=shot.per_metre), f'id="{name}"')
        )
        rims.append(f'<use href="#{name}"/>')
        fills.append(f'<use href="#{name}"/>')
    colour = rgb(theme.SKIN["skin"])
    return (
        f'<defs>{"".join(defined)}</defs><g opacity="{SKIN_OPACITY}"><g fill="none" '
        f'stroke="{tone(colour, RIM_TONE)}" stroke-width="{SKIN_RIM_WIDTH * shot.per_metre:.0f}">'
        f'{"".join(rims)}</g><g fill="{theme.SKIN["skin"]}">{"".join(fills)}</g></g>'
    )


def contact_dots(figure: SkinFigure, side: str, shot: Shot) -> str:
    """Return a dot at the lowest point of each contact sphere of a foot; arguments as of bones."""
    dots = []
    for body in figure.human.skeleton.bodies:
        if not (body.contacts and body.name.endswith(f"_{side}")):
            continue
        index = figure.human.body(body.name)
        turn = rotation_matrix(figure.quats[:, index])
        for contact in body.contacts:
            local = contact.position - [0.0, 0.0, contact.radius]
            at = shot.camera.project(figure.positions[:, index] + turn @ local - shot.centre)
            data = [f"M{x} {y}l0 0" for x, y in np.round(at * shot.per_metre).astype(int).tolist()]
            dots.append(shot.clock.path(data))
    return (
        f'<g fill="none" stroke="{theme.FORCE}" stroke-linecap="round" '
        f'stroke-width="{CONTACT_DOT * shot.per_metre:.0f}">{"".join(dots)}</g>'
    )

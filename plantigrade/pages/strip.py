"""A picture strip of a motion as plain SVG, without OpenGL.

A person is drawn with skin and clothes, other bodies as solids.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import theme
from plantigrade.contact.ground import Ground
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.pages.camera import Camera
from plantigrade.pages.figure_layers import Figure, figure_layers
from plantigrade.pages.outlines import force_arrow, outlines
from plantigrade.pages.scene import poses, travel
from plantigrade.pages.shapes import hexadecimal, shapes_of
from plantigrade.pages.skin_figure import SkinFigure
from plantigrade.pages.skin_layers import skin_layers
from plantigrade.pages.svg_animation import Clock, Shot

GROUND = "#8a94a3"
PROFILE_HALF_WIDTH = 0.25  # [m] to each side, over which the outline of the ground is taken
UNITS = 1000  # drawing units of a person per metre
MAX_SEAT_DISTANCE = 0.6  # [m] between body and a seat in its picture
VIEW_TEXT = {
    "side": "from its right",
    "left": "from its left",
    "front": "from the front",
    "back": "from behind",
    "quarter": "from the front right",
}
STILL = Clock(1.0)  # [s] of a picture in which nothing moves


def instants(n_frames: int, count: int = 8) -> list[int]:
    """Return ``count`` equally spaced frame indices.

    Example:
        >>> instants(101, 5)
        [0, 25, 50, 75, 100]
    """
    count = min(count, n_frames)
    return [int(i) for i in np.round(np.linspace(0, n_frames - 1, count))]


def strip_svg(
    model: mujoco.MjModel,
    qpos: Float[Array, "n nq"],
    indices: Sequence[int],
    *,
    time: Float[Array, " n"] | None = None,
    force: Float[Array, "n k 3"] | None = None,
    point: Float[Array, "n k 3"] | None = None,
    height_px: int = 230,
    background: str | None = None,
    behind: Float[Array, "n nq"] | None = None,
    pale: Collection[str] = (),
    ground: Ground | None = None,
    view: str = "side",
    human: Human | None = None,
    x_ray: bool = False,
) -> str:
    """Return an SVG of the body and its supports at several instants.

    Everything is projected horizontally; near parts are drawn over far ones.

    Args:
        model: The body.
        qpos: Configurations.
        indices: Frames to draw, from left to right.
        time: Time of each frame [s]; written under each picture.
        force: Ground reaction at each contact, world [N], drawn as an arrow.
        point: Point of application, world [m].
        height_px: Height of the picture [px]; the drawing scales freely.
        background: CSS colour of the background; none if None.
        behind: Another motion of the same body, drawn translucent behind the first.
        pale: Bodies that are drawn paler.
        ground: Ground with slope, steps, bumps, relief and seats; level ground at height zero if
            None.
        view: One of :data:`~plantigrade.pages.camera.VIEWS`, at eye level.
        human: Person whose skin is drawn in place of the solids.
        x_ray: Whether the bones of the feet are seen through the skin.
    """
    indices = [int(i) for i in indices]
    if not indices or min(indices) < 0 or max(indices) >= len(qpos):
        raise ParameterError(f"picture instants {indices} must be frames from 0 to {len(qpos) - 1}")
    chosen = np.asarray(qpos)[indices]
    positions, quats, com = poses(model, chosen)
    along = Camera.named(view, travel(com)).right
    across = np.array([along[1], -along[0], 0.0])
    camera = Camera(along, np.array([0.0, 0.0, 1.0]), across)
    weight = max(float(model.body_mass.sum() * np.linalg.norm(model.opt.gravity)), 1e-9)

    drawing = _Drawing(model, camera, human, frozenset(pale), x_ray)
    bodies = drawing.bodies(positions, quats)
    drawn = [elements for elements, _ in bodies]  # in metres, the far ones first
    left, right, tops = np.array([extent for _, extent in bodies]).T
    if behind is not None:
        others = poses(model, np.asarray(behind)[indices])
        ghosts = drawing.bodies(*others[:2], colour=theme.REFERENCE)
        for i, (ghost, extent) in enumerate(ghosts):
            drawn[i] = ['<g opacity=".4">', *ghost, "</g>", *drawn[i]]
            left[i], right[i] = min(left[i], extent[0]), max(right[i], extent[1])
            tops[i] = max(tops[i], extent[2])
    centre = com @ along
    ground = ground or Ground()
    boards = _boards(model, camera)
    for i in range(len(indices)):
        for elements, (a, b) in boards:
            if a - MAX_SEAT_DISTANCE < centre[i] < b + MAX_SEAT_DISTANCE:
                drawn[i] = [*elements, *drawn[i]]
                left[i], right[i] = min(left[i], a), max(right[i], b)
    left, right = left - centre, right - centre
    spacing = float((right[:-1] - left[1:]).max() + 0.06) if len(indices) > 1 else 1.0
    places = np.arange(len(indices)) * spacing
    low, high = float(left[0] + places[0] - 0.1), float(right[-1] + places[-1] + 0.1)
    top = float(tops.max()) + 0.06
    bottom = 0.18 if time is not None else 0.06

    parts = []
    if background:
        parts.append(
            f'<rect x="{low:.3f}" y="{-top:.3f}" width="{high - low:.3f}" '
            f'height="{top + bottom:.3f}" fill="{background}"/>'
        )
    profiles = [_profile(ground, c, along, spacing) for c in com]
    if _level(ground):
        floor, z = 0.0, -ground.height
        parts.append(
            f'<line x1="{low:.3f}" x2="{high:.3f}" y1="{z:.3f}" y2="{z:.3f}" stroke="{GROUND}" '
            'stroke-width=".008"/>'
        )
    else:
        floor = min(0.0, *(float(heights.min()) for _, heights in profiles))
        for place, (x, z) in zip(places, profiles, strict=True):
            line = "L".join(f"{a + place:.3f} {-b:.3f}" for a, b in zip(x, z, strict=True))
            below = (
                f"L{x[-1] + place:.3f} {-floor + 0.03:.3f}L{x[0] + place:.3f} {-floor + 0.03:.3f}Z"
            )
            parts.append(f'<path d="M{line}{below}" fill="{GROUND}" opacity=".25"/>')
            parts.append(f'<path d="M{line}" fill="none" stroke="{GROUND}" stroke-width=".008"/>')
    bottom -= floor
    for i, frame in enumerate(indices):
        shift = places[i] - centre[i]
        parts.append(f'<g transform="translate({shift:.3f} 0)">{"".join(drawn[i])}')
        if force is not None and point is not None:
            parts.append(f'<g transform="scale({1 / UNITS:g})">')
            for f, p in zip(force[frame][:, None], point[frame][:, None], strict=True):
                parts.append(force_arrow(f, p, camera, STILL, weight, per_metre=UNITS))
            parts.append("</g>")
        parts.append("</g>")
        if time is not None:
            parts.append(
                f'<text x="{places[i]:.3f}" y="{0.135 - floor:.3f}" font-size=".1" '
                f'text-anchor="middle" fill="{GROUND}" font-family="system-ui, sans-serif">'
                f"{escape(f'{time[frame]:.2f} s')}</text>"
            )
    width_px = round(height_px * (high - low) / (top + bottom))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="strip" role="img" '
        f'aria-label="The body at {len(indices)} instants, seen {VIEW_TEXT[view]}" '
        f'width="{width_px}" height="{height_px}" '
        f'viewBox="{low:.3f} {-top:.3f} {high - low:.3f} {top + bottom:.3f}">'
        f"{''.join(parts)}</svg>"
    )


def _level(ground: Ground) -> bool:
    """Return whether a ground is one level plane."""
    return not (ground.slope or ground.steps or ground.bumps or ground.field)


def _profile(
    ground: Ground, com: Float[Array, " 3"], along: Float[Array, " 3"], width: float
) -> tuple[Float[Array, " n"], Float[Array, " n"]]:
    """Return the outline of the ground under one picture, projected horizontally.

    Returns:
        Positions relative to the centre of mass and heights, world [m], as the maximum over the
        width of a person.
    """
    ahead = np.linspace(-width / 2, width / 2, 241)
    aside = np.linspace(-PROFILE_HALF_WIDTH, PROFILE_HALF_WIDTH, 13)
    across = np.array([-along[1], along[0], 0.0])
    points = com * [1, 1, 0] + ahead[:, None, None] * along + aside[:, None] * across
    up = ground.normal
    for _ in range(3):  # on a slope the position along it depends on the height
        points[..., 2] = (ground.under(points) - points[..., :2] @ up[:2]) / up[2]
    return ahead, points[..., 2].max(axis=1)


def _boards(model: mujoco.MjModel, camera: Camera):
    """Return the elements of each seat with legs, and its extent along the path."""
    found, still = [], (np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]]))
    for shape in shapes_of(model):
        if not shape.name.startswith("seat_"):
            continue
        points = outlines(shape, *still, camera)[0]
        (a, _), (b, low) = points.min(axis=0), points.max(axis=0)
        fill = hexadecimal(shape.colour or (0.7, 0.6, 0.45))
        legs = "".join(f"M{x:.3f} {low:.3f}V0" for x in (a + 0.03, b - 0.03))
        outline = "L".join(f"{x:.3f} {y:.3f}" for x, y in points)
        board = (
            f'<path d="{legs}" fill="none" stroke="{fill}" stroke-width=".03"/>'
            f'<path d="M{outline}Z" fill="{fill}" stroke="#8a6d4a" stroke-width=".008"/>'
        )
        found.append(([board], (a, b)))
    return found


@dataclass(frozen=True, eq=False)
class _Drawing:
    """Drawing of a body, seen along a horizontal line."""

    model: mujoco.MjModel
    camera: Camera
    human: Human | None
    pale: frozenset[str]
    x_ray: bool

    def bodies(
        self, positions: Float[Array, "n nbody 3"], quats: Float[Array, "n nbody 4"], colour=""
    ) -> list[tuple[list[str], tuple[float, float, float]]]:
        """Return elements and extent (left, right, top) of every picture; one colour if given."""
        skin = self.human and SkinFigure.of(self.human, positions, quats, self.pale)
        figure = Figure(self.model, positions, quats, self.pale)
        found = []
        for i in range(len(positions)):
            one, prefix = slice(i, i + 1), f"b{i}" + ("g" if colour else "_")
            shot = Shot(np.zeros((1, 3)), self.camera, STILL, prefix, UNITS)
            if skin:
                drawn = skin_layers(skin.frames(one), shot, x_ray=self.x_ray, colour=colour)
            else:
                drawn = figure_layers(figure.frames(one), shot, colour=colour)
            layers, (left, top, right, _) = drawn
            elements = [f'<g transform="scale({1 / UNITS:g})">', *layers, "</g>"]
            found.append((elements, (left / UNITS, right / UNITS, -top / UNITS)))
        return found

"""A picture strip of a motion as plain SVG, without OpenGL.

A person is drawn with skin and clothes, other bodies as solids.
"""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from xml.sax.saxutils import escape

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import theme
from plantigrade.contact.ground import Ground
from plantigrade.errors import ParameterError
from plantigrade.models import Human
from plantigrade.pages.animated_objects import object_layers
from plantigrade.pages.camera import Camera
from plantigrade.pages.figure_layers import BodyFigure, figure_layers
from plantigrade.pages.outlines import force_arrow, outlines
from plantigrade.pages.scene import height_below, poses, travel
from plantigrade.pages.shapes import hexadecimal, shapes_of
from plantigrade.pages.skin_figure import SkinFigure
from plantigrade.pages.skin_layers import skin_layers
from plantigrade.pages.svg_animation import AnimationClock, Shot
from plantigrade.record.scene_objects import PlacedObject

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
STILL_CLOCK = AnimationClock(1.0)  # [s] of a picture in which nothing moves


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
    objects: Sequence[PlacedObject] = (),
) -> str:
    """Return an SVG of the body, its supports and objects at several instants, seen horizontally.

    Args:
        indices: Frames to draw, from left to right.
        time: Time of each frame [s]; written under each picture.
        force: Ground reaction at each contact, world [N], drawn as an arrow.
        point: Point of application, world [m].
        height_px: Height of the picture [px]; the drawing scales freely.
        background: CSS colour of the background; none if None.
        behind: Another motion of the same body, drawn translucent behind the first.
        pale: Bodies that are drawn paler.
        ground: Ground with slope, steps, bumps, relief and seats; by default level at zero.
        view: One of :data:`~plantigrade.pages.camera.VIEWS`, at eye level.
        human: Person whose skin is drawn in place of the solids.
        x_ray: Whether the bones of the feet are seen through the skin.
        objects: Objects beside the body, in every frame.
    """
    indices = _frames(indices, len(qpos))
    com = poses(model, np.asarray(qpos)[indices])[2]
    along = Camera.named(view, travel(com)).right
    camera = Camera(along, np.array([0.0, 0.0, 1.0]), np.array([along[1], -along[0], 0.0]))
    drawing = _Drawing(model, camera, human, frozenset(pale), x_ray)
    pictures = drawing.of(np.asarray(qpos)[indices])
    if behind is not None:
        _put_ghosts(pictures, drawing.of(np.asarray(behind)[indices], colour=theme.REFERENCE))
    centre = com @ along
    _put_objects(pictures, objects, indices, com, camera)
    _put_boards(pictures, centre, _boards(model, camera))
    places, spacing, (low, high) = _places(pictures, centre)
    top = max(p.top for p in pictures) + 0.06
    floor, parts = _ground(ground or Ground(), com, along, places, spacing, (low, high))
    weight = max(float(model.body_mass.sum() * np.linalg.norm(model.opt.gravity)), 1e-9)
    for place, middle, frame, picture in zip(places, centre, indices, pictures, strict=True):
        arrows = _arrows(force, point, frame, camera, weight)
        parts += picture.moved(place - middle, arrows)
        if time is not None:
            parts.append(_time_text(f"{time[frame]:.2f} s", place, floor))
    height = top + (0.18 if time is not None else 0.06) - floor
    size = f'width="{high - low:.3f}" height="{height + floor:.3f}"'
    below = [f'<rect x="{low:.3f}" y="{-top:.3f}" {size} fill="{background}"/>'] * bool(background)
    seen = f"The body at {len(indices)} instants, seen {VIEW_TEXT[view]}"
    return _svg([*below, *parts], seen, (low, -top, high - low, height), height_px)


def _frames(indices: Sequence[int], count: int) -> list[int]:
    """Return the frames to draw, or refuse those that are not there."""
    indices = [int(i) for i in indices]
    if not indices or min(indices) < 0 or max(indices) >= count:
        raise ParameterError(f"picture instants {indices} must be frames from 0 to {count - 1}")
    return indices


def _svg(
    parts: Sequence[str], label: str, box: tuple[float, float, float, float], height_px: int
) -> str:
    """Return the drawing of elements in a box: left, top, width and height [m]."""
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="strip" role="img" aria-label="{label}" '
        f'width="{round(height_px * box[2] / box[3])}" height="{height_px}" '
        f'viewBox="{" ".join(f"{x:.3f}" for x in box)}">{"".join(parts)}</svg>'
    )


def _places(
    pictures: Sequence["_Picture"], centre: Float[Array, " n"]
) -> tuple[Float[Array, " n"], float, tuple[float, float]]:
    """Return the places of the pictures side by side, their spacing, and the strip's ends [m]."""
    left = np.array([p.left for p in pictures]) - centre
    right = np.array([p.right for p in pictures]) - centre
    spacing = float((right[:-1] - left[1:]).max() + 0.06) if len(pictures) > 1 else 1.0
    places = np.arange(len(pictures)) * spacing
    return places, spacing, (float(left[0] - 0.1), float(right[-1] + places[-1] + 0.1))


def _put_ghosts(pictures: list["_Picture"], ghosts: list["_Picture"]) -> None:
    """Put the pictures of another motion behind those of a body, translucent."""
    for picture, ghost in zip(pictures, ghosts, strict=True):
        picture.put_behind(ghost, opacity=0.4)


def _put_boards(pictures: list["_Picture"], centre: Array, boards: list["_Picture"]) -> None:
    """Put seats behind the bodies that are near them."""
    for picture, middle in zip(pictures, centre, strict=True):
        for board in boards:
            if board.left - MAX_SEAT_DISTANCE < middle < board.right + MAX_SEAT_DISTANCE:
                picture.put_behind(board)


def _arrows(
    force: Float[Array, "n k 3"] | None,
    point: Float[Array, "n k 3"] | None,
    frame: int,
    camera: Camera,
    weight: float,
) -> list[str]:
    if force is None or point is None:
        return []
    arrows = (
        force_arrow(f[None], p[None], camera, STILL_CLOCK, weight, per_metre=UNITS)
        for f, p in zip(force[frame], point[frame], strict=True)
    )
    return [f'<g transform="scale({1 / UNITS:g})">', *arrows, "</g>"]


def _time_text(text: str, place: float, floor: float) -> str:
    return (
        f'<text x="{place:.3f}" y="{0.135 - floor:.3f}" font-size=".1" '
        f'text-anchor="middle" fill="{GROUND}" font-family="system-ui, sans-serif">'
        f"{escape(text)}</text>"
    )


def _ground(
    ground: Ground,
    com: Float[Array, "n 3"],
    along: Float[Array, " 3"],
    places: Float[Array, " n"],
    spacing: float,
    ends: tuple[float, float],
) -> tuple[float, list[str]]:
    """Return the lowest height of the ground [m], and its elements under every picture."""
    stroke = f'stroke="{GROUND}" stroke-width=".008"'
    if not (ground.slope or ground.steps or ground.bumps or ground.field):
        z = -ground.height
        line = f'<line x1="{ends[0]:.3f}" x2="{ends[1]:.3f}" y1="{z:.3f}" y2="{z:.3f}" {stroke}/>'
        return 0.0, [line]
    ahead = np.linspace(-spacing / 2, spacing / 2, 241)
    aside = np.linspace(-PROFILE_HALF_WIDTH, PROFILE_HALF_WIDTH, 13)
    across = np.array([-along[1], along[0], 0.0])
    offsets = ahead[:, None, None] * along + aside[:, None] * across
    points = com[:, None, None] + offsets
    heights = height_below(ground, points.reshape(-1, 3)).reshape(points.shape[:3]).max(axis=2)
    floor, parts = min(0.0, float(heights.min())), []
    for x, z in zip(places[:, None] + ahead, heights, strict=True):
        line = "L".join(f"{a:.3f} {-b:.3f}" for a, b in zip(x, z, strict=True))
        below = f"L{x[-1]:.3f} {-floor + 0.03:.3f}L{x[0]:.3f} {-floor + 0.03:.3f}Z"
        parts.append(f'<path d="M{line}{below}" fill="{GROUND}" opacity=".25"/>')
        parts.append(f'<path d="M{line}" fill="none" {stroke}/>')
    return floor, parts


@dataclass
class _Picture:
    """Elements in metres, the far ones first, and their extent."""

    elements: list[str]
    left: float
    right: float
    top: float

    def moved(self, by: float, arrows: Sequence[str]) -> list[str]:
        """Return the elements, arrows in front of them, moved to the right by a distance [m]."""
        return [f'<g transform="translate({by:.3f} 0)">', *self.elements, *arrows, "</g>"]

    def put_behind(self, other: "_Picture", opacity: float = 1.0) -> None:
        """Draw another picture behind this one."""
        group = f'<g opacity="{opacity:g}">'.replace("0.", ".")
        faint = [group, *other.elements, "</g>"] if opacity < 1.0 else other.elements
        self.elements = [*faint, *self.elements]
        self.left, self.right = min(self.left, other.left), max(self.right, other.right)
        self.top = max(self.top, other.top)


def _boards(model: mujoco.MjModel, camera: Camera) -> list[_Picture]:
    """Return the seats with their legs."""
    found, still = [], (np.zeros((1, 3)), np.array([[1.0, 0.0, 0.0, 0.0]]))
    for shape in shapes_of(model):
        if not shape.name.startswith("seat_"):
            continue
        points = outlines(shape, *still, camera)[0]
        (a, top), (b, low) = points.min(axis=0), points.max(axis=0)
        fill = hexadecimal(shape.colour or (0.7, 0.6, 0.45))
        legs = "".join(f"M{x:.3f} {low:.3f}V0" for x in (a + 0.03, b - 0.03))
        outline = "L".join(f"{x:.3f} {y:.3f}" for x, y in points)
        board = (
            f'<path d="{legs}" fill="none" stroke="{fill}" stroke-width=".03"/>'
            f'<path d="M{outline}Z" fill="{fill}" stroke="#8a6d4a" stroke-width=".008"/>'
        )
        found.append(_Picture([board], float(a), float(b), -float(top)))
    return found


def _put_objects(
    pictures: Sequence[_Picture],
    objects: Sequence[PlacedObject],
    frames: Sequence[int],
    centres: Float[Array, "n 3"],
    camera: Camera,
) -> None:
    """Put the objects that are there in each frame behind or before the body."""
    for picture, frame, centre in zip(pictures, frames, centres, strict=True):
        here = [replace(each, pose=each.pose[[frame]]) for each in objects]
        here = [each for each in here if np.isfinite(each.pose).all()]
        behind, before, seen = object_layers(
            here, Shot(centre[None], camera, STILL_CLOCK, "t", UNITS)
        )
        x, y = camera.project(centre[None])[0]
        (left, top), (right, _) = seen.min(axis=0) / UNITS, seen.max(axis=0) / UNITS
        move = f'<g transform="translate({x:.3f} {y:.3f}) scale({1 / UNITS:g})">'
        extent = x + float(left), x + float(right), -y - float(top)
        if behind:
            picture.put_behind(_Picture([move, *behind, "</g>"], *extent))
        if before:
            picture.put_behind(_Picture([], *extent))  # for the extent
            picture.elements += [move, *before, "</g>"]


@dataclass(frozen=True, eq=False)
class _Drawing:
    """Drawing of a body, seen along a horizontal line."""

    model: mujoco.MjModel
    camera: Camera
    human: Human | None
    pale: frozenset[str]
    x_ray: bool

    def of(self, qpos: Float[Array, "n nq"], colour: str = "") -> list[_Picture]:
        """Return the pictures of the body; of one colour if given."""
        positions, quats, _ = poses(self.model, qpos)
        skin = self.human and SkinFigure.of(self.human, positions, quats, self.pale)
        figure = BodyFigure(self.model, positions, quats, self.pale)
        found = []
        for i in range(len(positions)):
            one, prefix = slice(i, i + 1), f"b{i}" + ("g" if colour else "_")
            shot = Shot(np.zeros((1, 3)), self.camera, STILL_CLOCK, prefix, UNITS)
            if skin:
                drawn = skin_layers(skin.frames(one), shot, x_ray=self.x_ray, colour=colour)
            else:
                drawn = figure_layers(figure.frames(one), shot, colour=colour)
            layers, (left, top, right, _) = drawn
            elements = [f'<g transform="scale({1 / UNITS:g})">', *layers, "</g>"]
            found.append(_Picture(elements, left / UNITS, right / UNITS, -top / UNITS))
        return found

"""Ground of an animation: a strip that passes under the body, and seats."""

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.contact.ground import Ground
from plantigrade.pages.shapes import convex_hull, mesh_of, shapes_of
from plantigrade.pages.svg_animation import Shot
from plantigrade.spatial.conventions import rotation_matrix

HALF_WIDTHS = (
    0.42,
    1.2,
)  # [m] half widths of the strip of ground, around a magnified foot and a body
MARK_SPACING = 0.25  # [m] approximate distance between marks
PROFILE_SPACING = 0.02  # [m] between points of the profile of uneven ground
TOP, EDGE, LINE, SIDE_FACE = "#e6eaef", "#98a3b3", "#c3cbd6", "#f0f2f5"
WOOD, WOOD_EDGE = "#c9ab80", "#8f744b"


def stage(
    ground: Ground,
    model: mujoco.MjModel,
    com: Float[Array, "m 3"],
    forward: Float[Array, " 3"],
    shot: Shot,
    *,
    loop: Float[Array, " 3"] | None,
    box: tuple[int, int, int, int],
    fine: bool = False,
) -> str:
    """Return the ground with transverse marks, and seats, as they pass the camera.

    Args:
        com: Path of the centre of mass, world [m].
        forward: Horizontal direction of travel, unit vector.
        loop: How far a stride carries the body [m]: then marks divide it evenly, so that the end
            of the loop is its beginning.
        box: Visible area (left, top, right, bottom), around the camera's centre.
        fine: Whether marks are closer.
    """
    centre, camera, per_metre = shot.centre, shot.camera, shot.per_metre
    middle = com.mean(axis=0)
    origin = middle - forward * float(middle @ forward)
    across = np.array([forward[1], -forward[0], 0.0])
    reach = max(abs(v) for v in box) / per_metre + 0.5
    along = centre @ forward
    ends = along.min() - reach, along.max() + reach
    stride = 0.0 if loop is None else float(loop @ forward)
    marks = _marks(ends, MARK_SPACING / 2 if fine else MARK_SPACING, stride)

    aside = abs(float(camera.right @ forward)) > 0.5  # seen from a side
    wide = HALF_WIDTHS[fine or not aside]

    def surface(s: np.ndarray, to_side: float) -> np.ndarray:
        level = origin * [1, 1, 0] + np.outer(s, forward) + to_side * across
        n = ground.normal
        height = (ground.under(level) - level @ n) / n[2]
        return level + np.outer(height, [0.0, 0.0, 1.0])

    plain = not (ground.steps or ground.bumps or ground.field)
    s = np.array(ends) if plain else np.arange(ends[0], ends[1] + PROFILE_SPACING, PROFILE_SPACING)
    near, far = (surface(s, side) for side in (wide, -wide))
    if not plain:
        near, far = _corners(near), _corners(far)
    if camera.towards @ across < 0:
        near, far = far, near

    lines = [np.concatenate([surface(m[None], wide), surface(m[None], -wide)]) for m in marks]
    width = f'stroke-width="{(0.002 if fine else 0.005) * per_metre:g}"'
    parts = _strip(near, far, lines, shot, width, aside)
    if not fine:
        parts += _seats(ground, model, camera, per_metre, surface, origin, forward)
    whole = np.round(-camera.project(centre) * per_metre).astype(int)
    return shot.clock.shifted([f"{x} {y}" for x, y in whole], "".join(parts))


def _strip(
    near: np.ndarray, far: np.ndarray, lines: list[np.ndarray], shot: Shot, width: str, aside: bool
) -> list[str]:
    """Return the strip between a near and a far edge, with lines across it, and its side."""

    def data(points: np.ndarray, closed: bool) -> str:
        whole = np.round(shot.camera.project(points) * shot.per_metre).astype(int)
        return "M" + "L".join(f"{x} {y}" for x, y in whole) + ("z" if closed else "")

    top = data(np.concatenate([near, far[::-1]]), closed=True)
    deep = near - [0.0, 0.0, 3.0]
    face = data(np.concatenate([near, deep[::-1]]), closed=True)
    across = "".join(data(line, closed=False) for line in lines)
    return [
        f'<path d="{face}" fill="{SIDE_FACE}"/>' if aside else "",
        f'<path d="{top}" fill="{TOP}"/>',
        f'<path d="{across}" stroke="{LINE}" {width}/>',
        f'<path d="{data(near, False)}" fill="none" stroke="{EDGE}" {width}/>',
    ]


def _marks(ends: tuple[float, float], spacing: float, stride: float) -> np.ndarray:
    """Return the places of marks along the way [m], which repeat with the stride of a loop."""
    if stride > 0.1:
        spacing = stride / max(round(stride / spacing), 1)
    return np.arange(np.ceil(ends[0] / spacing), np.floor(ends[1] / spacing) + 1) * spacing


def _corners(points: Float[Array, "n 3"]) -> Float[Array, "k 3"]:
    """Return the corners and ends of a profile."""
    bend = np.abs(np.diff(points[:, 2], 2)) > 1e-6
    return points[np.concatenate([[True], bend, [True]])]


def _seats(ground, model, camera, per_metre, surface, origin, forward) -> list[str]:
    """Return boards with legs."""
    if not ground.seats:
        return []
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    parts = []
    for shape in shapes_of(model):
        if shape.body or shape.kind != "box" or shape.size[0] > 2.0:
            continue
        corners = mesh_of(shape)[0] @ rotation_matrix(shape.quat).T + shape.position
        hull = convex_hull(camera.project(corners))
        for corner in corners[corners[:, 2] < shape.position[2]]:
            foot = corner.copy()
            foot[2] = surface(np.array([(corner - origin) @ forward]), 0.0)[0, 2]
            (x1, y1), (x2, y2) = np.round(camera.project(np.stack([corner, foot])) * per_metre)
            parts.append(
                f'<path d="M{x1:g} {y1:g}L{x2:g} {y2:g}" stroke="{WOOD_EDGE}" '
                f'stroke-width="{0.025 * per_metre:g}"/>'
            )
        outline = "L".join(f"{x:g} {y:g}" for x, y in np.round(hull * per_metre))
        parts.append(
            f'<path d="M{outline}z" fill="{WOOD}" stroke="{WOOD_EDGE}" '
            f'stroke-width="{0.006 * per_metre:g}"/>'
        )
    return parts

"""A picture strip of a motion as plain SVG, with no OpenGL: capsules are thick round strokes."""

from collections.abc import Sequence
from xml.sax.saxutils import escape

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import theme
from plantigrade.constants import GRAVITY
from plantigrade.errors import ParameterError
from plantigrade.report.scene import poses
from plantigrade.report.shapes import Shape, convex_hull, shapes_of, surface_points

TINTS = {"r": (theme.RIGHT, "#5b9bc8"), "l": (theme.LEFT, "#e08a55"), None: ("#6b7280", "#b9b3aa")}


def instants(n_frames: int, count: int = 8) -> list[int]:
    """Return ``count`` frame indices spread evenly over ``n_frames`` frames.

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
    spacing: float | None = None,
    height_px: int = 230,
    background: str | None = None,
    behind: Float[Array, "n nq"] | None = None,
) -> str:
    """Return an SVG of the body at several instants, seen from its right.

    Every geom is projected along the horizontal that is square to the direction of travel; near
    ones are drawn over far ones. A capsule or sphere is exact, an ellipsoid, cylinder or box is
    drawn as the outline of its projection.

    Args:
        model: The body.
        qpos: Configurations.
        indices: Which frames to draw, in this order from left to right.
        time: Time of each frame [s]; written under each picture.
        force: Ground reaction at each contact, world [N], drawn as an arrow.
        point: Where it acts, world [m].
        spacing: Distance between neighbouring pictures [m]; where the body walks further than
            that, pictures stand where it was. Chosen from the widths where None.
        height_px: Height of the picture [px]; the drawing scales freely.
        background: CSS colour behind it; none where None.
        behind: Another motion of the same body, drawn translucent behind the first.

    Raises:
        ParameterError: If there is no index, or one lies outside the motion.
    """
    indices = [int(i) for i in indices]
    if not indices or min(indices) < 0 or max(indices) >= len(qpos):
        raise ParameterError(f"picture instants {indices} must be frames from 0 to {len(qpos) - 1}")
    chosen = np.asarray(qpos)[indices]
    positions, quats, com = poses(model, chosen)
    shapes = [shape for shape in shapes_of(model) if shape.body]
    forward = _heading(com)
    across = np.array([forward[1], -forward[0], 0.0])  # to the right: towards the reader
    weight = max(float(model.body_mass.sum()) * GRAVITY, 1e-9)

    drawn = []  # per instant: elements in metres, the far ones first
    extents = []
    for i in range(len(indices)):
        elements, extent = _figure(shapes, positions[i], quats[i], forward, across)
        drawn.append(elements)
        extents.append(extent)
    if behind is not None:
        others = poses(model, np.asarray(behind)[indices])
        for i in range(len(indices)):
            ghost, extent = _figure(
                shapes, others[0][i], others[1][i], forward, across, (theme.REFERENCE,) * 2
            )
            drawn[i] = ['<g opacity=".4">', *ghost, "</g>", *drawn[i]]
            low, high, top = zip(extents[i], extent, strict=True)
            extents[i] = (min(low), max(high), max(top))
    centre = com @ forward
    left = np.array([e[0] for e in extents]) - centre
    right = np.array([e[1] for e in extents]) - centre
    if spacing is None:
        gaps = right[:-1] - left[1:] if len(indices) > 1 else np.zeros(0)
        spacing = float(gaps.max() + 0.06) if gaps.size else 1.0
    places = np.arange(len(indices)) * spacing
    low, high = float(left[0] + places[0] - 0.1), float(right[-1] + places[-1] + 0.1)
    top = max(e[2] for e in extents) + 0.06
    bottom = 0.18 if time is not None else 0.06

    parts = []
    if background:
        parts.append(
            f'<rect x="{low:.3f}" y="{-top:.3f}" width="{high - low:.3f}" '
            f'height="{top + bottom:.3f}" fill="{background}"/>'
        )
    parts.append(
        f'<line x1="{low:.3f}" x2="{high:.3f}" y1="0" y2="0" stroke="#8a94a3" stroke-width=".008"/>'
    )
    for i, frame in enumerate(indices):
        shift = places[i] - centre[i]
        parts.append(f'<g transform="translate({shift:.3f} 0)">{"".join(drawn[i])}')
        if force is not None and point is not None:
            parts += _arrows(force[frame], point[frame], forward, weight)
        parts.append("</g>")
        if time is not None:
            parts.append(
                f'<text x="{places[i]:.3f}" y=".135" font-size=".1" text-anchor="middle" '
                f'fill="#8a94a3" font-family="system-ui, sans-serif">'
                f"{escape(f'{time[frame]:.2f} s')}</text>"
            )
    width_px = round(height_px * (high - low) / (top + bottom))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="strip" role="img" '
        f'aria-label="The body at {len(indices)} instants, seen from its right" '
        f'width="{width_px}" height="{height_px}" '
        f'viewBox="{low:.3f} {-top:.3f} {high - low:.3f} {top + bottom:.3f}">'
        f"{''.join(parts)}</svg>"
    )


def _heading(com) -> np.ndarray:
    """Return the horizontal unit vector of travel; world forward where the body stays."""
    way = (com[-1] - com[0]) * [1, 1, 0]
    length = np.linalg.norm(way)
    return way / length if length > 0.3 else np.array([1.0, 0.0, 0.0])


def _figure(shapes, positions, quats, forward, across, tint=None):
    """Return the elements of one picture, far ones first, and its extent (left, right, top)."""
    marks = [
        _outline(shape, positions[shape.body], quats[shape.body], forward, across, tint)
        for shape in shapes
    ]
    spans = np.array([span for _, _, span in marks])
    elements = [element for _, element, _ in sorted(marks, key=lambda mark: mark[0])]
    return elements, (spans[:, 0].min(), spans[:, 1].max(), spans[:, 2].max())


def _outline(shape: Shape, body_position, body_quat, forward, across, tint=None):
    """Return depth, SVG element (metres, y down) and extent (left, right, top) of one geom."""
    rotation = np.empty(9)
    mujoco.mju_quat2Mat(rotation, np.asarray(body_quat, dtype=float))
    body = rotation.reshape(3, 3).copy()
    mujoco.mju_quat2Mat(rotation, shape.quat)
    frame = body @ rotation.reshape(3, 3)
    origin = body_position + body @ shape.position

    def flat(points):
        points = np.atleast_2d(points)
        return np.stack([points @ forward, points[:, 2]], axis=1)

    depth = float(origin @ across)
    edge, fill = tint or TINTS[shape.side]
    if shape.colour is not None and tint is None:
        red, green, blue = (round(255 * c) for c in shape.colour)
        fill = f"#{red:02x}{green:02x}{blue:02x}"
    if shape.kind in ("capsule", "sphere"):
        radius = float(shape.size[0])
        half = float(shape.size[1]) if shape.kind == "capsule" else 0.0
        ends = flat(np.array([origin - frame[:, 2] * half, origin + frame[:, 2] * half]))
        (x1, z1), (x2, z2) = ends
        if abs(x1 - x2) + abs(z1 - z2) < 1e-4:
            x2 += 1e-4  # a stroke without length has no ends in some readers
        place = f'x1="{x1:.3f}" y1="{-z1:.3f}" x2="{x2:.3f}" y2="{-z2:.3f}"'
        line = f'<line {place} stroke-linecap="round" stroke='
        rim = min(0.006, radius / 4)
        element = (
            f'{line}"{edge}" stroke-width="{2 * radius:.3f}"/>'
            f'{line}"{fill}" stroke-width="{2 * (radius - rim):.3f}"/>'
        )
        x, z = ends[:, 0], ends[:, 1]
        span = (x.min() - radius, x.max() + radius, z.max() + radius)
        return depth, element, span
    outline = convex_hull(flat(origin + surface_points(shape) @ frame.T))
    path = "M" + "L".join(f"{x:.3f} {-z:.3f}" for x, z in outline) + "Z"
    element = (
        f'<path d="{path}" fill="{fill}" stroke="{edge}" stroke-width=".008" '
        'stroke-linejoin="round"/>'
    )
    return depth, element, (outline[:, 0].min(), outline[:, 0].max(), outline[:, 1].max())


def _arrows(force, point, forward, weight):
    """Yield ground reactions as arrows; one body weight is 0.6 m long."""
    for f, p in zip(np.nan_to_num(force), point, strict=True):
        length = 0.6 * float(np.linalg.norm(f)) / weight
        if length < 0.03 or not np.isfinite(p).all():
            continue
        x, z = float(p @ forward), float(p[2])
        dx, dz = 0.6 * float(f @ forward) / weight, 0.6 * float(f[2]) / weight
        tip_x, tip_z = x + dx, z + dz
        ux, uz = dx / length, dz / length
        back_x, back_z = tip_x - 0.07 * ux, tip_z - 0.07 * uz
        yield (
            f'<line x1="{x:.3f}" y1="{-z:.3f}" x2="{back_x:.3f}" y2="{-back_z:.3f}" '
            f'stroke="{theme.FORCE}" stroke-width=".018"/>'
            f'<path d="M{tip_x:.3f} {-tip_z:.3f}'
            f"L{back_x - 0.028 * uz:.3f} {-(back_z + 0.028 * ux):.3f}"
            f'L{back_x + 0.028 * uz:.3f} {-(back_z - 0.028 * ux):.3f}Z" fill="{theme.FORCE}"/>'
        )

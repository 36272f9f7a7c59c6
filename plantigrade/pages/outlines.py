"""Outlines of moving geoms as SVG path data, one string per frame with equal commands.

Path data that differ in numbers only can be animated, because a browser interpolates them. A
capsule or sphere is exactly a thick stroke between its ends; other geoms are drawn as the polygon
of their extreme points in fixed directions of the picture.
"""

import numpy as np

from plantigrade.arrays import Array, Float, Int
from plantigrade.charts import theme
from plantigrade.motion.filters import bridged_gaps
from plantigrade.pages.camera import Camera
from plantigrade.pages.shapes import Shape, surface_points
from plantigrade.pages.svg_animation import AnimationClock
from plantigrade.spatial.conventions import rotation_matrix

ARROW_PER_BODY_WEIGHT = 0.6  # [m] length of the arrow of one body weight
N_ROUND_CORNERS = 20  # of the polygon of an ellipsoid
N_CORNERS = 12  # of the polygon of other shapes


def outlines(
    shape: Shape, positions: Float[Array, "n 3"], quats: Float[Array, "n 4"], camera: Camera
) -> Float[Array, "n m 2"]:
    """Return the outline of a geom in every frame.

    Args:
        positions: World position of its body in each frame, relative to the camera [m].
        quats: World rotation of its body, ``wxyz``.

    Returns:
        The two ends of a thick stroke (``m`` = 2; its width is twice the first size), or the
        corners of a polygon, to the right and down [m].
    """
    turn = rotation_matrix(quats)
    centre = positions + turn @ shape.position
    axes = turn @ rotation_matrix(shape.quat)
    if is_stroke(shape):
        half = shape.size[1] if shape.kind == "capsule" else 0.0
        ends = centre[:, None] + np.array([-half, half])[:, None] * axes[:, None, :, 2]
        return camera.project(ends)
    count = N_ROUND_CORNERS if shape.kind == "ellipsoid" else N_CORNERS
    angle = 2 * np.pi * np.arange(count) / count
    ways = np.outer(np.cos(angle), camera.right) + np.outer(np.sin(angle), camera.up)
    if shape.kind == "ellipsoid":
        local = ways @ axes * shape.size  # (n, count, 3)
        reach = local * shape.size / np.linalg.norm(local, axis=2, keepdims=True)
        return camera.project(centre[:, None] + reach @ axes.transpose(0, 2, 1))
    points = centre[:, None] + surface_points(shape) @ axes.transpose(0, 2, 1)
    farthest = np.argmax(points @ ways.T, axis=1)
    return camera.project(np.take_along_axis(points, farthest[..., None], axis=1))


def is_stroke(shape: Shape) -> bool:
    """Return whether a geom is drawn as a thick stroke."""
    return shape.kind in ("capsule", "sphere")


def path_data(points: Float[Array, "n m 2"], *, per_metre: float, closed: bool) -> list[str]:
    """Return points as path data, one string per frame, in integers relative to the last point."""
    whole = np.round(points * per_metre).astype(int)
    steps = np.diff(whole, axis=1)
    end = "z" if closed else ""
    return [
        f"M{pair(first)}" + "".join(f"l{pair(step)}" for step in rest) + end
        for first, rest in zip(whole[:, 0], steps, strict=True)
    ]


def force_arrow(
    force: Float[Array, "n 3"],
    point: Float[Array, "n 3"],
    camera: Camera,
    clock: AnimationClock,
    weight: float,
    *,
    per_metre: float,
    length: float = ARROW_PER_BODY_WEIGHT,
    width: float = 0.05,
) -> str:
    """Return a force as an animated arrow; nothing if there never is one.

    Args:
        force: Force, world [N].
        point: Point of application, relative to the camera [m]; NaN without force.
        weight: Body weight [N].
        length: Length of the arrow of one body weight [m].
        width: Width of the head [m]; it shrinks with a short arrow.
    """
    known = np.asarray(np.isfinite(np.concatenate([point, force], axis=1)).all(axis=1))
    if not known.any():
        return ""
    start = camera.project(bridged_gaps(point, known))
    shaft = camera.project(
        np.where(np.isfinite(force) & np.isfinite(point), force, 0.0) * length / weight
    )
    size = np.linalg.norm(shaft, axis=1, keepdims=True)
    if size.max() < width / 4:
        return ""
    along = shaft / np.maximum(size, 1e-9)
    across = along[:, ::-1] * [-1.0, 1.0]
    head = np.minimum(width, size * 0.6)
    tip, neck = start + shaft, start + shaft - 1.6 * head * along
    corners = np.stack([tip, neck + 0.6 * head * across, neck - 0.6 * head * across], axis=1)
    line = np.stack([start, np.where(size > 1.6 * head, neck, start)], axis=1)
    stroke = f'fill="none" stroke="{theme.FORCE}" stroke-width="{0.36 * width * per_metre:g}"'
    return clock.path(path_data(line, per_metre=per_metre, closed=False), stroke) + clock.path(
        path_data(corners, per_metre=per_metre, closed=True), f'fill="{theme.FORCE}"'
    )


def pair(values: Int[Array, " 2"]) -> str:
    """Return two numbers in the shortest form of path data."""
    x, y = int(values[0]), int(values[1])
    return f"{x}{y}" if y < 0 else f"{x} {y}"

"""Objects of a picture beside the person: boxes and bars, by their outlines."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion.filters import interpolate
from plantigrade.pages.animated_ground import WOOD, WOOD_EDGE
from plantigrade.pages.svg_animation import Shot
from plantigrade.record import Record
from plantigrade.record.scene_objects import PlacedObject, scene_objects_of
from plantigrade.spatial.conventions import rotation_matrix

DIRECTIONS = 24  # [1] points of an outline: the furthest ones of the object in that many directions
MAX_DISTANCE = 1.5  # [m] from the body, beyond which an object does not widen the picture
MIN_DEPTH = 0.15  # [m] from the body towards the viewer, beyond which an object hides it
AWAY = -1e4  # [m] where an absent object is put


def objects_at(record: Record, time: Float[Array, " n"]) -> tuple[PlacedObject, ...]:
    """Return the objects of a record at some instants, on the clock of its motion [s]."""
    own = record.motion.time
    return tuple(replace(p, pose=interpolate(time, own, p.pose)) for p in scene_objects_of(record))


def object_layers(
    objects: Sequence[PlacedObject], shot: Shot
) -> tuple[list[str], list[str], Float[Array, "k 2"]]:
    """Return outlines of objects behind and before the body, and what the picture must hold.

    Args:
        objects: Objects at the instants that are drawn.
        shot: View of the body; points are from its centre, in drawing units.
    """
    behind, before, seen = [], [], [np.zeros((1, 2))]
    for each in objects:
        outline = _outline(each, each.pose, shot)
        near = np.linalg.norm(each.pose[:, :3] - shot.centre, axis=1) < MAX_DISTANCE
        seen.append(outline[near].reshape(-1, 2))
        whole = np.round(np.where(np.isfinite(outline), outline, AWAY * shot.per_metre)).astype(int)
        data = ["M" + "L".join(f"{x} {y}" for x, y in frame) + "z" for frame in whole]
        look = f'fill="{WOOD}" stroke="{WOOD_EDGE}" stroke-width="{0.006 * shot.per_metre:g}"'
        depth = (each.pose[:, :3] - shot.centre) @ shot.camera.towards
        nearer = np.isfinite(depth).any() and np.nanmean(depth) > MIN_DEPTH
        (before if nearer else behind).append(shot.clock.path(data, look))
    return behind, before, np.concatenate(seen)


def _outline(
    each: PlacedObject, pose: Float[Array, "n 7"], shot: Shot
) -> Float[Array, "n n_directions 2"]:
    """Return the outline of an object in every frame, in drawing units."""
    size, turn = np.array(each.scene_object.size), rotation_matrix(pose[:, 3:7])
    radius = 0.0
    if each.scene_object.kind == "box":
        signs = np.stack(np.meshgrid(*[(-1.0, 1.0)] * 3), axis=-1).reshape(-1, 3)
        corners = signs * size
    else:
        corners, radius = np.outer((-1.0, 1.0), (0.0, 0.0, size[1])), float(size[0])
    points = np.einsum("nij,kj->nki", turn, corners) + (pose[:, :3] - shot.centre)[:, None]
    flat = shot.camera.project(points.reshape(-1, 3)).reshape(*points.shape[:2], 2)
    angle = np.linspace(0.0, 2 * np.pi, DIRECTIONS, endpoint=False)
    ways = np.column_stack([np.cos(angle), np.sin(angle)])
    furthest = np.argmax(flat @ ways.T, axis=1)  # frames, directions
    chosen = np.take_along_axis(flat, furthest[:, :, None], axis=1)
    return (chosen + radius * ways) * shot.per_metre

"""A moving body as layers of an SVG: the limbs as silhouettes, the bones of a foot one by one."""

from collections import defaultdict
from collections.abc import Collection
from dataclasses import dataclass, replace
from functools import cached_property

import mujoco
import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.charts import theme
from plantigrade.pages.outlines import is_stroke, outlines, path_data
from plantigrade.pages.shapes import (
    WHITE_SHARE,
    Shape,
    foot_bodies,
    hexadecimal,
    rgb,
    shapes_of,
    whiter,
)
from plantigrade.pages.svg_animation import Shot
from plantigrade.spatial.conventions import rotation_matrix

RIM_WIDTH = 0.012  # [m] of the outline of a limb
FINE_RIM_WIDTH = 0.004  # [m] of the outline of a bone
SEGMENT_PALE = (0.0, 0.5, 0.22, 0.62, 0.35, 0.12)  # share of white of foot segments
TINTS = {"r": (theme.RIGHT, "#5b9bc8"), "l": (theme.LEFT, "#e08a55"), None: ("#6b7280", "#b9b3aa")}


@dataclass(frozen=True, eq=False)
class BodyFigure:
    """A body in motion."""

    model: mujoco.MjModel  #: The body and its ground
    positions: Float[Array, "n nbody 3"]  #: World position of each body in each frame [m]
    quats: Float[Array, "n nbody 4"]  #: World rotation of each body, ``wxyz``
    pale: Collection[str] = ()  #: Bodies that are drawn paler

    def frames(self, part: slice) -> "BodyFigure":
        """Return some of its frames."""
        return replace(self, positions=self.positions[part], quats=self.quats[part])

    @cached_property
    def shapes(self) -> tuple[Shape, ...]:
        """The visual geoms of the body."""
        return tuple(shape for shape in shapes_of(self.model, self.pale) if shape.body)

    def bones(self, side: str) -> tuple[Shape, ...]:
        """Return the geoms of a foot."""
        inside = foot_bodies(self.model, side)
        return tuple(shape for shape in self.shapes if inside[shape.body])

    def has_foot(self, side: str) -> bool:
        """Return whether a foot is known."""
        return bool(self.bones(side))

    def foot_centre(self, side: str) -> Float[Array, "n 3"]:
        """Return the centre of a foot's geoms in each frame [m]."""
        places = [
            self.positions[:, s.body] + rotation_matrix(self.quats[:, s.body]) @ s.position
            for s in self.bones(side)
        ]
        stacked = np.stack(places)
        return (stacked.min(axis=0) + stacked.max(axis=0)) / 2


def figure_layers(
    figure: BodyFigure, shot: Shot, *, colour: str = ""
) -> tuple[list[str], tuple[float, float, float, float]]:
    """Return the layers of a body, the far ones first, and their extent (left, top, right, bottom).

    All geoms of a limb share one outline; those of a foot have one each. A ``colour`` is that of
    everything, of a shadow of a motion.
    """
    feet = foot_bodies(figure.model, "r") | foot_bodies(figure.model, "l")
    groups: dict[object, list[Shape]] = defaultdict(list)
    for k, shape in enumerate(figure.shapes):
        groups[("bone", k) if feet[shape.body] else _limb(figure.model, shape)].append(shape)
    return _layers(list(groups.values()), figure, shot, RIM_WIDTH, colour)


def foot_layers(figure: BodyFigure, side: str, shot: Shot) -> tuple[list[str], int]:
    """Return the layers of a foot with the shank above it, and the number of its bones."""
    bones = figure.bones(side)
    roots = {int(figure.model.body_parentid[bone.body]) for bone in bones}
    shank = roots - {bone.body for bone in bones}
    layers, _ = _layers([[bone] for bone in bones], figure, shot, FINE_RIM_WIDTH)
    above = [shape for shape in figure.shapes if shape.body in shank]
    leg, _ = _layers([above], figure, replace(shot, prefix=f"{shot.prefix}k"), FINE_RIM_WIDTH)
    faint = f'<g opacity=".3">{"".join(leg)}</g>' if above else ""
    return [faint, *layers], len(bones) if len(bones) > 4 else 0


def _limb(model: mujoco.MjModel, shape: Shape) -> object:
    """Return the first body of a limb, at which it leaves the trunk; None for the trunk."""
    if shape.side is None:
        return None
    body = shape.body
    while True:
        parent = int(model.body_parentid[body])
        if parent == 0 or not model.body(parent).name.endswith(f"_{shape.side}"):
            return body
        body = parent


def _layers(groups, figure, shot, rim, colour=""):
    per_metre = shot.per_metre
    layers, spans = [], []
    segments: dict[int, int] = {}
    feet = foot_bodies(figure.model, "r") | foot_bodies(figure.model, "l")
    count = 0
    for shapes in groups:
        outer, inner, defined, depths = [], [], [], []
        for shape in shapes:
            place = figure.positions[:, shape.body] - shot.centre
            points = outlines(shape, place, figure.quats[:, shape.body], shot.camera)
            name = f"{shot.prefix}{count}"
            count += 1
            stroke = is_stroke(shape)
            width = 2 * shape.size[0] if stroke else 0.0
            data = path_data(points, per_metre=per_metre, closed=not stroke)
            defined.append(shot.clock.path(data, f'id="{name}"'))
            edge, fill = TINTS[shape.side]
            if shape.colour is not None:
                fill = hexadecimal(shape.colour)
            if feet[shape.body]:
                kind = segments.setdefault(shape.body, len(segments))
                fill = hexadecimal(whiter(rgb(fill), SEGMENT_PALE[kind % len(SEGMENT_PALE)]))
            if shape.pale:
                edge, fill = (hexadecimal(whiter(rgb(each), WHITE_SHARE)) for each in (edge, fill))
            if colour:
                edge = fill = colour
            thin = min(rim, width / 4) if stroke else rim
            use = f'<use href="#{name}"'
            if stroke:
                outer.append(f'{use} stroke="{edge}" stroke-width="{width * per_metre:.0f}"/>')
                inner.append(
                    f'{use} stroke="{fill}" stroke-width="{(width - thin) * per_metre:.0f}"/>'
                )
            else:
                outer.append(f'{use} stroke="{edge}" stroke-width="{thin * per_metre:.0f}"/>')
                inner.append(f'{use} fill="{fill}"/>')
            depth = place + rotation_matrix(figure.quats[:, shape.body]) @ shape.position
            depths.append(float((depth @ shot.camera.towards).mean()))
            reach = width / 2
            spans.append((*(points.min(axis=(0, 1)) - reach), *(points.max(axis=(0, 1)) + reach)))
        markup = (
            f'<defs>{"".join(defined)}</defs><g fill="none" stroke-linecap="round" '
            f'stroke-linejoin="round">{"".join(outer)}{"".join(inner)}</g>'
        )
        layers.append((float(np.mean(depths)), markup))
    left, top, right, bottom = np.transpose(spans) * per_metre
    ordered = [markup for _, markup in sorted(layers, key=lambda layer: layer[0])]
    return ordered, (left.min(), top.min(), right.max(), bottom.max())

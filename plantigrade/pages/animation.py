"""Animated picture of a motion: one SVG that plays wherever a page shows images.

The file holds no script and asks for nothing, so that it also moves in a README. Every outline is
one path whose data are animated (SMIL), far ones first: parts of the dressed skin, or the solids
where there is no skin. Beside the body stands its foot enlarged, its bones seen through the skin,
with the force at each place that touches the ground.
Systems set to reduced motion show one instant.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from markupsafe import Markup

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.motion.filters import interpolate
from plantigrade.motion.motion import resampled
from plantigrade.pages.animated_ground import stage
from plantigrade.pages.animated_objects import object_layers, objects_at
from plantigrade.pages.bone_layers import bone_layers, contact_dots, veil
from plantigrade.pages.camera import Camera
from plantigrade.pages.figure_layers import BodyFigure, figure_layers, foot_layers
from plantigrade.pages.outlines import force_arrow
from plantigrade.pages.playback import FRAME_RATE, Playback, playback
from plantigrade.pages.scene import check, poses, scene_model, side_forces, travel
from plantigrade.pages.section import svg_of
from plantigrade.pages.skin_figure import SkinFigure, skin_of
from plantigrade.pages.skin_layers import skin_layers
from plantigrade.pages.svg_animation import AnimationClock, Shot
from plantigrade.record import Record

UNITS = 1000  # drawing units per metre
MARGIN = 110  # drawing units around the body
MIN_VIEW_WIDTH = 800  # minimum half width of the view, in drawing units
INSET_SIZE = (1560, 1160)  # width and height of the enlarged foot
FOOT_SCALE = 4.5  # magnification of the foot
SITE_ARROW_PER_BODY_WEIGHT = 0.22  # [m] length of the arrow of one body weight at a site
HEIGHTS = (100, 2000)  # of a picture [px]
FEET = {"right": "r", "left": "l", "none": ""}


@dataclass(frozen=True)
class MovingPicture:
    """An animated picture and what it shows."""

    svg: str  #: The file
    frames: int  #: Number of instants
    seconds: float  #: Duration of one cycle [s]
    loop: bool  #: Whether it is a loop, of one stride of a steady gait


def moving_picture(
    record: Record,
    *,
    forces: Record | None = None,
    view: str = "side",
    foot: str = "right",
    start: float | None = None,
    stop: float | None = None,
    rate: float = FRAME_RATE,
    speed: float = 1.0,
    height_px: int = 420,
    title: str = "",
    solids: bool = False,
    x_ray: bool = False,
) -> MovingPicture:
    """Return a motion as an animated SVG.

    Args:
        forces: The record whose ground reactions are drawn; by default ``record``.
        view: One of :data:`plantigrade.pages.camera.VIEWS`.
        foot: Foot that is shown magnified: ``"right"``, ``"left"`` or ``"none"``.
        start: First instant, on the clock of the motion [s]; with neither ``start`` nor ``stop``,
            one stride of a gait that repeats, else the first ten seconds.
        stop: Last instant [s].
        rate: Frames per second of the motion.
        speed: Playback speed; 1 is real time.
        height_px: Height of the picture [px]; the drawing scales freely.
        solids: Whether the solids that physics sees are drawn in place of the skin.
        x_ray: Whether the bones of the feet are seen through the skin of the body, too.
    """
    check(record)
    _refuse(foot, speed, height_px)
    plays = playback(record, start=start, stop=stop, rate=rate)
    clock = AnimationClock(plays.seconds / speed)
    drawn = _Instants.of(record, forces or record, plays, solids)
    still = drawn.only(0)
    how: dict[str, Any] = {"view": view, "side": FEET[foot], "clock": clock, "x_ray": x_ray}
    box, moving = _scene(record, drawn, prefix="", **how)
    _, resting = _scene(record, still, prefix="s", box=box, **how)
    left, top, right, bottom = box
    width, height = right - left, bottom - top
    svg = svg_of(
        "animation.svg",
        words=title or "Animated body",
        title=title,
        **{"left": left, "top": top, "width": width, "height": height},
        **{"width_px": round(height_px * width / height), "height_px": height_px},
        **{"moving": Markup(moving), "resting": Markup(resting)},
    )
    return MovingPicture(f"{svg}\n", len(plays.time), plays.seconds / speed, plays.loop is not None)


def _refuse(foot: str, speed: float, height_px: int) -> None:
    if foot not in FEET:
        raise ParameterError(f"foot is {foot!r}; allowed are {', '.join(FEET)}")
    if not (np.isfinite(speed) and 0.05 <= speed <= 10.0):
        raise ParameterError(f"speed={speed} must be from 0.05 to 10 times true speed")
    if not HEIGHTS[0] <= height_px <= HEIGHTS[1]:
        low, high = HEIGHTS
        raise ParameterError(f"height_px={height_px} must be from {low} to {high} pixels")


@dataclass(frozen=True, eq=False)
class _Instants:
    """Everything that moves, at the drawn instants."""

    figure: BodyFigure
    skin: SkinFigure | None
    centre: Float[Array, "n 3"]
    com: Float[Array, "m 3"]  # of the whole motion, for the direction of travel
    plays: Playback
    total: Float[Array, "n 3 3"] | None
    cop: Float[Array, "n 3 3"] | None
    force: Float[Array, "n k 3"] | None
    point: Float[Array, "n k 3"] | None
    sides: tuple[str, ...]
    weight: float

    @classmethod
    def of(cls, record: Record, source: Record, plays: Playback, solids: bool) -> "_Instants":
        model = scene_model(record)
        positions, quats, com = poses(model, resampled(record.motion, plays.time).qpos)
        total, cop = side_forces(source)

        def here(values):
            return None if values is None else interpolate(plays.time, source.motion.time, values)

        return cls(
            BodyFigure(model, positions, quats),
            None if solids else skin_of(record, positions, quats),
            plays.centre,
            com,
            plays,
            here(None if total is None else np.nan_to_num(total)),
            here(cop),
            here(None if source.contact_force is None else np.nan_to_num(source.contact_force)),
            here(source.contact_point),
            tuple(site.side for site in source.sites),
            record.weight,
        )

    def only(self, k: int) -> "_Instants":
        """Return one instant."""
        one = slice(k, k + 1)
        known = {name: getattr(self, name) for name in ("total", "cop", "force", "point")}
        return replace(
            self,
            figure=self.figure.frames(one),
            skin=self.skin and self.skin.frames(one),
            centre=self.centre[one],
            **{name: x if x is None else x[one] for name, x in known.items()},
        )


Box = tuple[int, int, int, int]


def _scene(
    record: Record,
    drawn: _Instants,
    *,
    view: str,
    side: str,
    clock: AnimationClock,
    prefix: str,
    x_ray: bool,
    box: Box | None = None,
) -> tuple[Box, str]:
    """Return the extent of the picture and its elements: ground, body, forces, enlarged foot."""
    forward = travel(drawn.com)
    camera = Camera.named(view, forward)
    shot = Shot(drawn.centre, camera, clock, prefix, UNITS)
    if drawn.skin is None:
        layers, extent = figure_layers(drawn.figure, shot)
    else:
        layers, extent = skin_layers(drawn.skin, shot, x_ray=x_ray)
    behind, before, held = object_layers(
        objects_at(record, drawn.plays.time[: len(drawn.centre)]), shot
    )
    low, high = held.min(axis=0), held.max(axis=0)
    extent = (*np.minimum(extent[:2], low), *np.maximum(extent[2:], high))
    if side and not drawn.figure.has_foot(side):
        side = ""
    if box is None:
        left, top, right, bottom = (int(round(v)) for v in extent)
        left, right = min(left, -MIN_VIEW_WIDTH), max(right, MIN_VIEW_WIDTH)
        box = (
            left - MARGIN,
            top - MARGIN - 90,
            right + MARGIN,
            max(bottom, top + INSET_SIZE[1]) + MARGIN,
        )
        if side:
            box = (box[0], box[1], box[2] + INSET_SIZE[0] + MARGIN, box[3])
    ground = stage(
        record.ground, drawn.figure.model, drawn.com, forward, shot, loop=drawn.plays.loop, box=box
    )
    parts = [ground, *behind, *layers, *before]
    if drawn.total is not None and drawn.cop is not None:
        for k in range(3):
            at = drawn.cop[:, k] - drawn.centre
            total = drawn.total[:, k]
            parts.append(force_arrow(total, at, camera, clock, drawn.weight, per_metre=UNITS))
    if side:
        parts.append(_enlarged(record, drawn, forward, side, clock, prefix, box))
    return box, "".join(parts)


def _enlarged(record, drawn, forward, side, clock, prefix, box: Box) -> str:
    """Return the panel with the enlarged foot, which its camera follows."""
    azimuth = 62.0 if side == "r" else -62.0
    camera = Camera.around(forward, azimuth=azimuth, elevation=24.0)
    width, height = INSET_SIZE
    x, y = box[2] - MARGIN - width, box[3] - MARGIN - height
    follow = drawn.figure.foot_centre(side)
    low = record.ground.under(follow) if not record.ground.slope else follow[:, 2]
    rise = follow[:, 2] - low  # the foot rises within the panel
    rise = np.maximum(0.6 * rise + 0.02, rise - 0.06)
    follow = np.column_stack([follow[:, :2], low + rise])
    per_metre = UNITS * 2  # finer than the body, because it is magnified
    shot = Shot(follow, camera, clock, f"{prefix}z", per_metre)
    layers = [] if drawn.skin is None else bone_layers(drawn.skin, side, shot)
    bones = len(layers)
    if not layers:
        layers, bones = foot_layers(drawn.figure, side, shot)
    if drawn.skin is not None:
        layers = [*layers, veil(drawn.skin, side, shot), contact_dots(drawn.skin, side, shot)]
    half = np.array([width, height]) / (2 * FOOT_SCALE * UNITS) * per_metre
    inner = (int(-half[0]), int(-half[1]), int(half[0]), int(half[1]))
    ground = stage(
        record.ground,
        drawn.figure.model,
        drawn.com,
        forward,
        shot,
        loop=drawn.plays.loop,
        box=inner,
        fine=True,
    )
    parts = [ground, *layers]
    if drawn.force is not None and drawn.point is not None:
        for k, name in enumerate(drawn.sides):
            if name == side:
                at = drawn.point[:, k] - follow
                parts.append(
                    force_arrow(
                        drawn.force[:, k], at, camera, clock, drawn.weight,
                        per_metre=per_metre, length=SITE_ARROW_PER_BODY_WEIGHT, width=0.014,
                    )
                )  # fmt: skip
    name = f"{prefix}panel"
    scale = FOOT_SCALE * UNITS / per_metre
    label = f"{'right' if side == 'r' else 'left'} foot, {FOOT_SCALE:g} times larger"
    if bones:
        label += f": {bones} bones"
    return svg_of(
        "animation_foot.svg",
        name=name,
        **{"x": x, "y": y, "width": width, "height": height},
        middle=f"{x + width / 2:g} {y + height / 2:g}",
        scale=f"{scale:g}",
        drawing=Markup("".join(parts)),
        label=label,
    )

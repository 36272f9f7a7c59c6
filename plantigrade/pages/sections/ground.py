"""Ground reaction over time, and the centre of pressure on footprints."""

import mujoco
import numpy as np

from plantigrade.analyze.curves import nothing_measured
from plantigrade.arrays import Array, Float
from plantigrade.charts import Figure, Outline, Series, line_plot, path_plot
from plantigrade.charts.labels import MIN_SPANS
from plantigrade.charts.theme import STROKES
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.contact.site import PUSH_PART, TOUCH_PART, ContactSite
from plantigrade.motion.filters import runs
from plantigrade.pages.camera import Camera
from plantigrade.pages.outlines import is_stroke, outlines
from plantigrade.pages.scene import poses
from plantigrade.pages.section import ReportedRun, Section
from plantigrade.pages.sections.pushes import push_shades
from plantigrade.pages.shapes import Shape, foot_bodies, shapes_of
from plantigrade.record import Record

MAX_PRINTS = 16  # footprints that are drawn; more hide each other
TITLE = "Ground reaction and centre of pressure"
NAMES = {"r": "right", "l": "left", "": "side unknown"}
AXES = {2: "vertical", 0: "forward", 1: "sideways (left positive)"}
"""Axis of a force → its name, in the order of the plots."""


def ground_section(subject: ReportedRun) -> list[Section]:
    """Return ground reaction over time and the centre of pressure on footprints."""
    record, (total, cop) = subject.forces, subject.side_forces
    if total is None or not np.any(total):
        return [Section(TITLE, missing="no ground reaction was measured or computed.")]
    shades = push_shades(subject)
    figures = [Figure(_over_time(record, total, axis, shades)) for axis in AXES]
    text = (
        f"Ground reaction on each foot, divided by body weight (BW, {record.weight:.0f} N). "
        "Forward is negative while the foot brakes and positive while it pushes off."
    )
    if nothing_measured(record):
        text += " All forces are estimated from the motion; none were measured."
    elif "forces.measured" in record.signals:
        text += " Where no plate measured it, the force is estimated from the motion."
    prints = foot_prints(record, total)
    if cop is not None and np.isfinite(cop).any() and prints:
        figures += [_above(cop, prints), *_foot_figures(record, total, cop)]
    return [Section(TITLE, figures, text=text, folded=True)]


def loaded_frames(vertical: Float[Array, " n"], weight: float) -> list[tuple[int, int]]:
    """Return start and stop frames of each contact with at least a tenth of body weight."""
    return [(s.start, s.stop) for s in runs(vertical > 0.1 * weight) if s.stop - s.start > 3]


def foot_prints(record: Record, total: Float[Array, "n 3 3"]) -> list[Outline]:
    """Return the bones of each foot in midstance, from above."""
    model, outlines = record.human.model, []
    for row, side in enumerate(SIDES):
        shapes = _foot_shapes(model, side)
        stances = loaded_frames(total[:, row, 2], record.weight)[: MAX_PRINTS // 2]
        frames = [(start + stop) // 2 for start, stop in stances]
        if not frames or not shapes:
            continue
        positions, quats, _ = poses(model, record.motion.qpos[frames])
        for i in range(len(frames)):
            outlines += [_print(shape, positions[i], quats[i], STROKES[side]) for shape in shapes]
    return outlines


def _over_time(record: Record, total: Array, axis: int, shades: list) -> str:
    series = []
    others = " and ".join(_said(site) for site in record.sites if not site.side)
    for row, (side, name) in enumerate({**NAMES, "": others or NAMES[""]}.items()):
        loaded = np.any(total[:, row], axis=1)
        if loaded.any():
            values = np.where(loaded, total[:, row, axis], np.nan) / record.weight
            series.append(Series(record.motion.time, values, name, STROKES[side]))
    return line_plot(
        series,
        title=AXES[axis].capitalize(),
        y_label="[BW]",
        zero=True,
        least=MIN_SPANS["BW"],
        shades=shades,
    )


def _said(site: ContactSite) -> str:
    """Return the label of a site that is not on a foot."""
    if site.part == PUSH_PART:
        return f"push on the {site.body}"
    return f"{site.body} on the ground" if site.part == TOUCH_PART else site.name


def _above(cop: Array, outlines: list[Outline]) -> Figure:
    """Return the paths of the centre of pressure on footprints."""
    series = [
        Series(cop[:, row, 0], cop[:, row, 1], name, STROKES[side], 2.2)
        for row, (side, name) in enumerate(NAMES.items())
        if np.isfinite(cop[:, row]).any()
    ]
    drawing = path_plot(
        series,
        outlines=outlines,
        title="Centre of pressure over the foot prints",
        y_label="left [m]",
    )
    caption = (
        "From above. The centre of pressure moves from the heel to the toes in each step; pale "
        "shapes are the bones of the foot in midstance."
    )
    return Figure(drawing, caption, wide=True)


def _foot_figures(record: Record, total: Array, cop: Array) -> list[Figure]:
    """Return the centre of pressure of every stance in the frame of its foot."""
    model, figures = record.human.model, []
    for row, side in enumerate(SIDES):
        shapes = _foot_shapes(model, side)
        stances = loaded_frames(total[:, row, 2], record.weight)
        if not shapes or not stances:
            continue
        ankle = int(np.flatnonzero(foot_bodies(model, side))[0])
        series, outlines = [], []
        for start, stop in stances:
            middle = (start + stop) // 2
            positions, quats, _ = poses(model, record.motion.qpos[middle : middle + 1])
            prints = [_print(s, positions[0], quats[0], STROKES[side]) for s in shapes]
            origin = positions[0, ankle, :2]
            turn = _foot_axes(np.concatenate([o.points for o in prints]) - origin)
            outlines = outlines or [
                Outline(100 * (o.points - origin) @ turn.T, o.colour, 100 * o.width) for o in prints
            ]
            path = 100 * (cop[start:stop, row, :2] - origin) @ turn.T
            series.append(Series(path[:, 0], path[:, 1], "", STROKES[side], 1.6, 0.8))
        drawing = path_plot(
            series,
            outlines=outlines,
            title=f"{SIDE_NAMES[side].capitalize()} foot, stances: {len(series)}",
            x_label="to the right of the ankle [cm]",
            y_label="ahead of the ankle [cm]",
            width=520,
            max_height=380,
        )
        caption = "Centre of pressure of every stance, in the frame of the foot at mid-stance."
        figures.append(Figure(drawing, "" if figures else caption))
    return figures


def _foot_axes(tips: Array) -> Array:
    """Return the axes to the right and along a foot, from its outline about the ankle."""
    reach = np.linalg.norm(tips, axis=1)
    ahead = tips[reach > 0.8 * reach.max()].mean(axis=0)
    forward = ahead / max(np.linalg.norm(ahead), 1e-9)
    return np.array([[forward[1], -forward[0]], forward])


def _foot_shapes(model: mujoco.MjModel, side: str) -> list[Shape]:
    inside = foot_bodies(model, side)
    return [shape for shape in shapes_of(model) if inside[shape.body]]


def _print(shape: Shape, positions: Array, quats: Array, colour: str) -> Outline:
    """Return a bone from above."""
    body, camera = shape.body, Camera(*np.eye(3))  # from above
    points = outlines(shape, positions[body][None], quats[body][None], camera)[0]
    width = 2 * float(shape.size[0]) if is_stroke(shape) else 0.0
    return Outline(points * [1.0, -1.0], colour, width)

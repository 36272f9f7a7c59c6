"""Paths of the centre of mass and the feet."""

import numpy as np

from plantigrade.arrays import Array
from plantigrade.charts import Figure, Series, line_plot, path_plot
from plantigrade.charts.theme import STROKE_MIDDLE, STROKES
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.pages.scene import poses
from plantigrade.pages.section import ReportedRun, Section
from plantigrade.pages.sections.pushes import push_shades
from plantigrade.pages.shapes import foot_bodies


def path_section(subject: ReportedRun) -> list[Section]:
    """Return the paths of the centre of mass and of the feet from above and from the side."""
    record = subject.record
    model, time = record.human.model, record.motion.time
    positions, _, com = poses(model, record.motion.qpos)
    feet = []
    for side in SIDES:
        bodies = np.flatnonzero(foot_bodies(model, side))
        if len(bodies):
            feet.append((f"{SIDE_NAMES[side]} foot", STROKES[side], positions[:, bodies[0]]))
    sway = "In walking, the centre of mass moves towards the stance foot."
    scale = "Drawn to scale. The origin of each foot is its ankle."
    above = path_plot(_paths(feet, com, 1), title="From above", y_label="left [m]")
    right = path_plot(
        _paths(feet, com, 2), title="From the right", y_label="height [m]", ground=True
    )
    shades = push_shades(subject)
    height = 1000 * (com[:, 2] - com[:, 2].mean())
    figures = [
        Figure(above, sway if record.motion.events else "", wide=True),
        Figure(right, scale, wide=True),
        _over_time(time, height, "Centre of mass, height", "above its mean [mm]", shades),
    ]
    if len(time) > 2:
        speed = np.linalg.norm(np.gradient(com[:, :2], time, axis=0), axis=1)
        title = "Centre of mass, horizontal speed"
        figures.append(_over_time(time, speed, title, "[m/s]", shades))
    return [Section("Paths of the centre of mass and the feet", figures, folded=True)]


def _paths(feet: list, com: Array, axis: int) -> list[Series]:
    paths = [Series(p[:, 0], p[:, axis], name, colour, 1.4) for name, colour, p in feet]
    return [*paths, Series(com[:, 0], com[:, axis], "centre of mass", STROKE_MIDDLE, 2.2)]


def _over_time(time: Array, values: Array, title: str, label: str, shades: list) -> Figure:
    series = [Series(time, values, "", STROKE_MIDDLE, 2.0)]
    return Figure(line_plot(series, title=title, y_label=label, width=520, shades=shades))

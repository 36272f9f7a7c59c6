"""Planned contact: forces by foot segment, centre of pressure and support, contact plan."""

import numpy as np

from plantigrade.analyze.pressure import distance_outside_hull
from plantigrade.arrays import Array
from plantigrade.charts import Figure, Outline, Series, line_plot, path_plot, timeline_plot
from plantigrade.charts.labels import MIN_SPANS
from plantigrade.charts.theme import PALETTE, STROKE_FORCE, STROKE_MIDDLE, STROKES
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.kinematics.sole_paths import SitePoints
from plantigrade.kinematics.state import sweep
from plantigrade.pages.section import ReportedRun, Section, needs
from plantigrade.pages.sections.tasks import active_bars
from plantigrade.pages.shapes import convex_hull
from plantigrade.pages.text import place_text
from plantigrade.record import Record
from plantigrade.record.moving_ground import GroundPath
from plantigrade.side_names import without_side

MAX_HULLS = 60  # support polygons that are drawn; more hide each other
MIN_LOAD = 0.02  # [body weights] on the feet; below it the centre of pressure is undefined


@needs(planned=True)
def segment_section(subject: ReportedRun) -> Section:
    """Return the vertical force on every segment of each foot, and on other supports."""
    title, record = "Contact forces by segment", subject.record
    time, figures = record.motion.time, []
    assert record.contact_force is not None  # required by the decorator
    vertical = np.nan_to_num(record.contact_force[..., 2]) / record.weight
    for side in (*SIDES, ""):
        groups: dict[str, list[int]] = {}
        for i, site in enumerate(record.sites):
            if site.side == side:
                groups.setdefault(without_side(site.body).replace("_", " "), []).append(i)
        total = vertical[:, sum(groups.values(), [])].sum(axis=1)
        if not np.any(total):
            continue
        series = [
            Series(time, vertical[:, own].sum(axis=1), name, PALETTE[1 + k % (len(PALETTE) - 1)])
            for k, (name, own) in enumerate(groups.items())
        ]
        if len(groups) > 1:
            series.insert(0, Series(time, total, "sum", STROKES[side], 2.0, 0.6, "5 3"))
        drawing = line_plot(
            series,
            title=f"{SIDE_NAMES[side].capitalize()} foot" if side else "Other supports",
            y_label="vertical [BW]",
            width=520,
            height=250,
            zero=True,
            least=MIN_SPANS["BW"],
        )
        figures.append(Figure(drawing))
    if not figures:
        return Section(title, missing="no contact carries load.")
    text = "Ground reaction on each segment of the foot, in body weights."
    return Section(title, figures, text=text, folded=True)


@needs(planned=True)
def pressure_section(subject: ReportedRun) -> Section:
    """Return the centre of pressure in the support polygons, and its distance to the edge."""
    title, record = "Centre of pressure and support", subject.record
    centre = centre_of_pressure(record)
    known = np.isfinite(centre).all(axis=1)
    if not known.any():
        return Section(title, missing="the feet carry no load.")
    point = site_points(record)
    com = np.array([state.com for state in sweep(record.human, record.motion)])
    if (moved := GroundPath.of(record)) is not None:  # as seen from the ground
        point = moved.inward(point)
        centre, com = (moved.inward(path[:, None])[:, 0] for path in (centre, com))
    series = [
        Series(com[:, 0], com[:, 1], "centre of mass", STROKE_MIDDLE, 1.4, 1.0, "5 3"),
        Series(centre[:, 0], centre[:, 1], "centre of pressure", STROKE_FORCE, 2.2),
    ]
    outlines = _supports(record, point)
    above = path_plot(series, outlines=outlines, title="From above", y_label="left [m]")
    inside = inside_support(record, point, centre)
    margin = line_plot(
        [Series(record.motion.time, 1000.0 * inside, "", STROKE_MIDDLE, 1.8)],
        title="Distance to the edge of the support",
        y_label="inside [mm]",
        width=1060,
        height=230,
        zero=True,
        least=20.0,
    )
    hulls = (
        "Pale shapes: support polygons of each foot, one for every change of contact. The centre "
        "of pressure of both feet lies in the support polygon of all contacts, in double support "
        "between the feet."
    )
    edge = (
        "Positive inside the support polygon of all contacts. With contact along an edge of the "
        "foot only, as at heel strike, the polygon has no interior."
    )
    figures = [Figure(above, hulls, wide=True), Figure(margin, edge, wide=True)]
    return Section(title, figures, folded=True)


@needs(planned=True)
def contact_section(subject: ReportedRun) -> Section:
    """Return the planned contact times of all sites."""
    record, title = subject.record, "Contact plan"
    time, planned = record.motion.time, _planned(record)
    rows = []
    for side in (*SIDES, ""):
        for i, site in enumerate(record.sites):
            if site.side == side:
                bars = active_bars(planned[:, i], time, STROKES[side], 0.6)
                rows.append((place_text(site.name, side), bars))
    if not any(bars for _, bars in rows):
        return Section(title, missing="no contact is planned.")
    figure = Figure(timeline_plot(rows), wide=True)
    return Section(title, [figure], text="Planned contact times of each site.", folded=True)


def centre_of_pressure(record: Record) -> Array:
    """Return the centre of pressure of both feet, world [m]; NaN with hardly any load."""
    feet = [record.foot(side) for side in SIDES]
    load = np.stack([foot.force @ record.ground.normal for foot in feet], axis=1)
    place = np.stack([np.nan_to_num(foot.centre_of_pressure) for foot in feet], axis=1)
    whole = load.sum(axis=1)[:, None]
    moved = (load[..., None] * place).sum(axis=1)
    loaded = whole > MIN_LOAD * record.weight
    return np.divide(moved, whole, out=np.full_like(moved, np.nan), where=loaded)


def site_points(record: Record) -> Array:
    """Return the lowest point of every site, world [m]."""
    radius = np.array([site.radius for site in record.sites])
    centres = SitePoints(record.human, record.sites).path(record.motion.qpos)
    return centres - radius[:, None] * record.ground.normal


def inside_support(record: Record, point: Array, centre: Array) -> Array:
    """Return the distance of centres of pressure inside the support polygon [m]."""
    feet = np.array([site.side != "" for site in record.sites])
    return -distance_outside_hull(centre[:, :2], point[..., :2], _planned(record) & feet)


def _supports(record: Record, point: Array) -> list[Outline]:
    """Return support polygons of each foot, one for each change of contact."""
    found = []
    for side in SIDES:
        standing = _planned(record) & np.array([site.side == side for site in record.sites])
        change = np.flatnonzero(np.any(standing[1:] != standing[:-1], axis=1)) + 1
        for a, b in zip([0, *change], [*change, len(standing)], strict=True):
            middle = (a + b) // 2
            if standing[middle].sum() > 2:
                hull = convex_hull(point[middle, standing[middle], :2])
                if len(hull) > 2:
                    found.append(Outline(hull, STROKES[side]))
    return found[:MAX_HULLS]


def _planned(record: Record) -> Array:
    assert record.contact_planned is not None  # required by the decorator
    return record.contact_planned

"""Curves of angles, forces, moments and powers over the gait cycle."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from plantigrade.analyze import norms
from plantigrade.analyze.curves import LOADED_JOINTS, known_above, nothing_measured
from plantigrade.analyze.gait_profile import ANGLES
from plantigrade.analyze.statistics import mean_sd
from plantigrade.arrays import Array, Float
from plantigrade.charts import Figure, Panel, Ribbon, Series, line_plot, panel_plot, panels_of
from plantigrade.charts.labels import MIN_SPANS, axis_label, title_of
from plantigrade.charts.theme import DOTTED, STROKE_MIDDLE, STROKES
from plantigrade.constants import SIDE_NAMES
from plantigrade.motion.views import curves_of
from plantigrade.pages.section import ReportedRun, Section, needs
from plantigrade.pages.sections.pushes import LEGEND, push_shades
from plantigrade.record.signals import SIGNALS
from plantigrade.side_names import side_of, without_side

OTHER_ANGLES = (
    *("hip_adduction_thigh", "hip_rotation_thigh", "ankle_dorsiflexion"),
    *("knee_adduction_markers", "knee_rotation_markers"),
    *("lumbar_extension", "lumbar_bending", "lumbar_rotation"),
    *("arm_flex", "arm_add", "elbow_flex"),
)
SHOWN_ANGLES = (
    *(name for name in ANGLES if name != "foot_progression"),
    *("subtalar_angle", "mtp_angle"),
    *OTHER_ANGLES,
)
LEG = ("hip_flexion", "hip_adduction", "hip_rotation", "knee_angle", "ankle_angle")
POWER_JOINTS = (*LOADED_JOINTS, "lumbar_extension")
FORCES = {
    "up": "ground_force_up",
    "forward": "ground_force_forward",
    "left": "ground_force_sideways",
}
OPEN_PANELS = 9  # panels of joint angles over time that are unfolded
MAX_PANELS = 24  # panels of joint angles over time in total
MIN_RANGE = 3.0  # range below which an angle over time is folded away [°]


@dataclass(frozen=True)
class CycleCurves:
    """A coordinate with its side over the gait cycle (0 % at heel strike), one row per cycle.

    Unknown values are NaN; the unit is that of the plot (``"°"``, ``"N m/kg"``).
    """

    name: str
    percent: Float[Array, " n_percent"]
    values: Float[Array, "n_cycles n_percent"]
    unit: str = "°"


def angle_section(subject: ReportedRun) -> list[Section]:
    """Return joint angles over time, if there is no complete gait cycle."""
    if subject.walks:
        return []
    motion, limited_frames = subject.record.motion, subject.limited_frames
    panels = tuple(
        replace(
            panel,
            hatched={
                s: limited_frames[name]
                for s, name in _names(panel).items()
                if name in limited_frames
            },
            dotted=tuple(s for s, name in _names(panel).items() if name in subject.assumed),
        )
        for panel in panels_of(curves_of(motion, motion.joint_names[1:]))
    )
    text = "Joint angles over time, because there is no complete gait cycle."
    text += _marking_legend(any(p.hatched for p in panels), any(p.dotted for p in panels))
    shades = push_shades(subject)
    text += LEGEND if shades else ""
    panels = sorted(panels, key=_is_flat)  # stable: those that move keep their order
    first = [panel for panel in panels if not _is_flat(panel)][:OPEN_PANELS]
    others, drawn = panels[len(first) :], partial(_over_time, time=motion.time, shades=shades)
    found = [Section("Joint angles", drawn(first), text=text)] if first else []
    if others:
        small = f"None of these joints moves through more than {MIN_RANGE:g}°." if not first else ""
        shown = others[: MAX_PANELS - len(first)]
        if len(shown) < len(others):
            small += f" All joints are in motion.mot; {len(first) + len(shown)} are drawn."
        text = f"{text if not first else 'Plotted as above.'} {small}".strip()
        title = "Other joint angles" if first else "Joint angles"
        found.append(Section(title, drawn(shown), text=text, folded=True))
    return found


def _is_flat(panel: Panel) -> bool:
    """Return whether no angle of a panel moves visibly."""
    known = [values[np.isfinite(values)] for values in panel.curves.values()]
    return all(np.ptp(values) < MIN_RANGE for values in known if values.size)


def other_angle_section(subject: ReportedRun) -> list[Section]:
    """Return the angles of trunk and arms over the gait cycle."""
    source = subject.angle_curves
    curves = chosen(source.percent, source.angles, OTHER_ANGLES, "°") if subject.walks else []
    if not curves:
        return []
    title, caption = "Trunk and arms over the gait cycle", "Plotted as above."
    return [cycle_section(title, curves, subject, caption=caption)]


def _over_time(panels: Sequence[Panel], time: Array, **options: Any) -> list[Figure]:
    return [Figure(panel_plot(panel, time, **options)) for panel in panels]


def force_section(subject: ReportedRun) -> list[Section]:
    """Return ground reaction over the gait cycle."""
    source = subject.force_curves
    curves = chosen(source.percent, source.forces, tuple(FORCES), "BW")
    if not curves:
        return []
    caption = "Ground reaction on the foot, in body weights (BW)."
    title = "Ground reaction over the gait cycle"
    return [cycle_section(title, curves, subject, caption=caption)]


def moment_section(subject: ReportedRun) -> list[Section]:
    """Return joint moments over the gait cycle, or over time without a complete cycle."""
    title, source, record = "Joint moments", subject.force_curves, subject.forces
    curves = chosen(source.percent, source.moments, LOADED_JOINTS, "N m/kg", "_moment")
    what = "Internal moments{}, produced by muscles and ligaments"
    if curves:
        sign = "; positive in the positive direction of the joint angle."
        caption = what.format("") + sign
        return [cycle_section(title, curves, subject, caption=caption)]
    if nothing_measured(record):
        return []
    if record.qfrc_actuator is None:
        return [
            Section(
                title, missing="no forces were measured or estimated, so joint moments are unknown."
            )
        ]
    moments = {
        f"{name}_moment [N m]": known_above(record, name) * record.torque(name)
        for name in record.human.coordinates
    }
    panels = panels_of(moments)
    if not panels:
        missing = "no force was measured separately for a foot, so joint moments are unknown."
        return [Section(title, missing=missing)]
    legs = [p for p in panels if p.name.removesuffix("_moment") in LEG] or panels[:12]
    figures = _over_time(legs, record.motion.time, zero=True, shades=push_shades(subject))
    return [Section(title, figures, text=what.format(" over time") + ".", folded=True)]


def power_section(subject: ReportedRun) -> list[Section]:
    """Return joint powers over the gait cycle, or over time without a complete cycle."""
    source, record = subject.force_curves, subject.forces
    curves = chosen(source.percent, source.powers, LOADED_JOINTS, "W/kg", "_power")
    if curves:
        caption = (
            "Joint moment times angular velocity: positive where muscles generate energy, negative "
            "where they absorb it."
        )
        return [cycle_section("Joint powers", curves, subject, caption=caption)]
    if nothing_measured(record):
        return []
    if record.qfrc_actuator is None or source.cycles:
        missing = "joint powers need measured or computed forces and complete gait cycles."
        return [Section("Joint powers", missing=missing)]
    powers = {}
    for name in record.human.coordinates:
        if without_side(name) in POWER_JOINTS:
            power = record.torque(name) * record.motion.velocity(name) / record.human.mass
            powers[f"{name}_power [W/kg]"] = known_above(record, name) * power
    shades = push_shades(subject)
    figures = _over_time(panels_of(powers), record.motion.time, zero=True, shades=shades)
    text = "Joint moment times angular velocity, per kilogram of body mass."
    return [Section("Joint powers over time", figures, text=text, folded=True)]


@needs("foot.percent", "foot.names")
def foot_segment_section(subject: ReportedRun) -> list[Section]:
    """Return the angles of hindfoot, forefoot and hallux."""
    signals = subject.record.signals
    curves = [
        CycleCurves(name, signals["foot.percent"], signals[f"foot.{name}"])
        for name in subject.text_signal("foot.names")
        if f"foot.{name}" in signals
    ]
    if not curves:
        return []
    caption = (
        "Angles between segments of the foot by markers, as defined by the Oxford Foot Model: "
        "hindfoot to tibia, forefoot to hindfoot and to tibia, hallux to forefoot."
    )
    rms = subject.number("foot_segments_marker_rms_mm")
    if rms is not None:
        caption += f" Markers of a segment move {rms:.1f} mm (RMS) relative to each other."
    title = SIGNALS["foot.*"].section
    return [cycle_section(title, curves, subject, caption=caption, published=False)]


def cycle_section(
    title: str,
    curves: Sequence[CycleCurves],
    subject: ReportedRun,
    *,
    caption: str,
    published: bool = True,
) -> Section:
    """Return curves over the gait cycle, one plot per quantity with both sides."""
    grouped: dict[tuple[str, str], list[CycleCurves]] = {}
    for curve in curves:
        grouped.setdefault((without_side(curve.name), curve.unit), []).append(curve)
    figures = [
        curve_figure(base, members, subject, published=published)
        for (base, _), members in grouped.items()
    ]
    names = [base for base, _ in grouped] if published else []
    text = cycle_caption(caption, curves, subject, names)
    return Section(title, figures, text=text, folded=True)


def cycle_caption(
    caption: str, curves: Sequence[CycleCurves], subject: ReportedRun, names: Sequence[str]
) -> str:
    """Return the text of curves over the cycle: numbers of cycles, markings and norms."""
    text = caption
    if any(len(curve.values) > 1 for curve in curves):
        counts = ", ".join(
            f"{max(counted)} {SIDE_NAMES.get(side or '', 'middle')}"
            for side in ("r", "l", None)
            if (counted := [len(c.values) for c in curves if side_of(c.name) == side])
        )
        text += f" Line and coloured band: mean and standard deviation over cycles ({counts})."
    if subject.foot_off:
        text += " Dashed vertical lines: foot off."
    every = {curve.name for curve in curves}
    text += _marking_legend(every & set(subject.limited_percents), every & set(subject.assumed))
    return text + _norm_legend(
        subject, [band for n in names if (band := _norm(subject, n)) is not None]
    )


def _names(panel: Panel) -> dict[str, str]:
    """Return side → full name of the coordinates of a panel."""
    return {side: f"{panel.name}_{side}" if side else panel.name for side in panel.curves}


def _marking_legend(hatched: Collection | bool, dotted: Collection | bool) -> str:
    """Return the legend of hatching and dots, if there are any."""
    text = " Hatched: the joint is at a limit of its range." if hatched else ""
    return text + (" Dotted: assumed, not measured." if dotted else "")


def curve_figure(
    base: str,
    members: Sequence[CycleCurves],
    subject: ReportedRun,
    *,
    published: bool = True,
    ticks: Sequence[tuple[float, str]] = (),
    y_label: str = "",
    height: int = 210,
) -> Figure:
    """Return the plot of one quantity over the gait cycle, both sides, with its norm."""
    series, ribbons = [], []
    unit, norm = members[0].unit, _norm(subject, base) if published else None
    marks = [(at, STROKES[side]) for side, at in subject.foot_off.items()]
    if norm is not None:
        low, high = norm.mean - norm.sd, norm.mean + norm.sd
        ribbons.append(Ribbon(norm.percent, low, high, STROKE_MIDDLE, 0.22))
        name = "own" if norm.population.own else norm.population.name
        series.append(Series(norm.percent, norm.mean, name, STROKE_MIDDLE, 1.0, 0.8, "4 3"))
    for curve in sorted(members, key=lambda c: side_of(c.name) != "r"):
        side = side_of(curve.name)
        mean, sd = mean_sd(curve.values)
        if len(curve.values) > 1:
            ribbons.append(Ribbon(curve.percent, mean - sd, mean + sd, STROKES[side], 0.18))
        limited_frames = subject.limited_percents.get(curve.name)
        dash = DOTTED if curve.name in subject.assumed else ""
        name, colour = SIDE_NAMES.get(side or "", ""), STROKES[side]
        series.append(
            Series(curve.percent, mean, name, colour, 2, dash=dash, hatched=limited_frames)
        )
    sides = {side_of(curve.name) for curve in members}
    drawn = line_plot(
        series,
        bands=ribbons,
        marks=[mark for mark in marks if any(STROKES[side] == mark[1] for side in sides)],
        ticks=ticks,
        title=title_of(base),
        x_label="gait cycle [%]",
        y_label=y_label or axis_label(base, unit),
        least=MIN_SPANS.get(unit, 0.0),
        height=height,
    )
    return Figure(drawn)


def chosen(
    percent: Float[Array, " n_percent"],
    table: Mapping[str, Array],
    names: Sequence[str],
    unit: str,
    suffix: str = "",
) -> list[CycleCurves]:
    """Return the curves of some coordinates on both sides."""
    found = []
    for name in names:
        for side in ("", "_r", "_l"):
            values = table.get(f"{name}{side}")
            if values is not None and len(values):
                full = f"{FORCES.get(name, name)}{suffix}{side}"
                found.append(CycleCurves(full, percent, values, unit))
    return found


def _norm(subject: ReportedRun, name: str) -> norms.NormCurve | None:
    """Return the norm of a curve, of the person's population or else of children; None if none.

    Norms of the user are never mixed with others.
    """
    own = subject.population.own
    if not subject.has_norms:
        return None
    for population in (subject.population,) if own else (subject.population, norms.CHILDREN):
        known = name if own else norms.PUBLISHED_NAMES.get(name, name)
        if known in norms.names(population):
            return norms.norm(known, subject.speed_class, population=population)
    return None


def _norm_legend(subject: ReportedRun, bands: Sequence[norms.NormCurve]) -> str:
    """Return the legend of the norms: number, ages and speed of the people."""
    text, speed = "", subject.number("walking_speed_m_s")
    for people in dict.fromkeys(band.population for band in bands):
        text += f" Grey band: mean ± 1 SD of {people.people}"
        if people.own:
            text += " (your own norms)."
            continue
        text += f", {people.speed}"
        if people is norms.CHILDREN:
            text += f" (here: {subject.speed_class.replace('_', ' ')})"
        text += f"; {people.citation}."
        if people is not subject.population:
            text += " There are no free norms of adults, whose moments tend to be larger."
        elif people is norms.ADULTS and speed is not None and not norms.comfortable(speed):
            text += f" Angles depend on speed, here {speed:.2f} m/s."
    return text

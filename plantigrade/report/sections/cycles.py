"""A walk: curves of angles, forces, moments and powers over the gait cycle, and its measures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.analyze import norms
from plantigrade.analyze.curves import known_above
from plantigrade.arrays import Array, Float
from plantigrade.charts import Figure, Panel, Ribbon, Series, line_plot, panel_plot, panels_of
from plantigrade.charts.labels import SIDE_NAMES, SPAN, axis_label, side_of, title_of, without_side
from plantigrade.charts.theme import STROKE_MIDDLE, STROKES
from plantigrade.motion.views import curves_of
from plantigrade.report.section import Section, Subject, needs
from plantigrade.report.text import figure_text

SHOWN = (
    *("pelvis_tilt", "pelvis_list", "pelvis_rotation"),
    *("hip_flexion", "hip_adduction", "hip_rotation"),
    *("knee_angle", "ankle_angle", "subtalar_angle", "mtp_angle"),
    *("lumbar_extension", "lumbar_bending", "lumbar_rotation"),
    *("arm_flex", "arm_add", "elbow_flex"),
)
LOADED = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")
LEG = ("hip_flexion", "hip_adduction", "hip_rotation", "knee_angle", "ankle_angle")
POWERED = (*LOADED, "lumbar_extension")
FORCES = {
    "up": "ground_force_up",
    "forward": "ground_force_forward",
    "left": "ground_force_sideways",
}
NORMS = {
    "vertical_grf": "ground_force_up",
    "anterior_grf": "ground_force_forward",
    "hip_power": "hip_flexion_power",
    "knee_power": "knee_angle_power",
    "ankle_power": "ankle_angle_power",
}
"""Names of published curves where they are not ours."""
MOST = 24  # panels of joint angles over time


MEASURES = "Spatio-temporal measures"
WHOLE = (
    ("walking speed", "m/s", "walking_speed_m_s"),
    ("cadence", "steps/min", "cadence_steps_min"),
    ("step width", "m", "step_width_m"),
    ("double support", "% of stride", "double_support_pct"),
)
BY_SIDE = (
    ("stride length", "m", "stride_length_{}_m"),
    ("stride time", "s", "stride_time_{}_s"),
    ("step length", "m", "step_length_{}_m"),
    ("step time", "s", "step_time_{}_s"),
    ("stance", "% of stride", "stance_{}_pct"),
    ("swing", "% of stride", "swing_{}_pct"),
)


@dataclass(frozen=True)
class CycleCurves:
    """A coordinate with its side over the gait cycle (0 % at heel strike), one row per cycle.

    NaN is unknown; the unit is that of the plot (``"°"``, ``"N m/kg"``).
    """

    name: str
    percent: Float[Array, " n_percent"]
    values: Float[Array, "n_cycles n_percent"]
    unit: str = "°"


def angle_section(subject: Subject) -> list[Section]:
    """Return joint angles over the gait cycle; over time where there is no whole cycle."""
    if subject.walks:
        curves = chosen(subject.angle_curves.percent, subject.angle_curves.angles, SHOWN, "°")
        caption = "From one heel strike of a foot (0 %) to its next (100 %)."
        title = "Joint angles over the gait cycle"
        return [cycle_section(title, curves, subject, caption=caption)]
    motion = subject.record.motion
    panels = panels_of(curves_of(motion, motion.joint_names[1:]))
    text = "Joint angles over time; no whole gait cycle was found or asked for."
    if len(panels) > MOST:
        text += f" The first {MOST} of {len(panels)} are drawn; all are in motion.mot."
    return [Section("Joint angles", _over_time(panels[:MOST], motion.time), text=text)]


def _over_time(panels: Sequence[Panel], time: Array, **options: bool) -> list[Figure]:
    return [Figure(panel_plot(panel, time, **options)) for panel in panels]


def force_section(subject: Subject) -> list[Section]:
    """Return ground reaction over the gait cycle."""
    source = subject.force_curves
    curves = chosen(source.percent, source.forces, tuple(FORCES), "BW")
    if not curves:
        return []
    caption = "Force of the ground on the foot, in body weights (BW)."
    title = "Ground reaction over the gait cycle"
    return [cycle_section(title, curves, subject, caption=caption)]


def moment_section(subject: Subject) -> list[Section]:
    """Return joint moments over the gait cycle; over time where there is no whole cycle."""
    title, source, record = "Joint moments", subject.force_curves, subject.forces
    curves = chosen(source.percent, source.moments, LOADED, "N m/kg", "_moment")
    what = "Internal moments{}, made by the body's own muscles and ligaments"
    if curves:
        sign = "; positive in the direction in which the joint angle is positive."
        caption = what.format("") + sign
        return [cycle_section(title, curves, subject, caption=caption)]
    if record.qfrc_actuator is None:
        return [Section(title, missing="no forces were measured, so no joint moments.")]
    moments = {
        f"{name}_moment [N m]": known_above(record, name) * record.torque(name)
        for name in record.human.coordinates
    }
    panels = panels_of(moments)
    if not panels:
        missing = "no foot had a force of its own measured, so no joint moments."
        return [Section(title, missing=missing)]
    legs = [p for p in panels if p.name.removesuffix("_moment") in LEG] or panels[:12]
    figures = _over_time(legs, record.motion.time, zero=True)
    return [Section(title, figures, text=what.format(" over time") + ".")]


def power_section(subject: Subject) -> list[Section]:
    """Return joint powers over the gait cycle; over time where there is no whole cycle."""
    source, record = subject.force_curves, subject.forces
    curves = chosen(source.percent, source.powers, LOADED, "W/kg", "_power")
    if curves:
        caption = (
            "Joint moment times joint speed: positive where muscles give energy to the body, "
            "negative where they absorb it."
        )
        return [cycle_section("Joint powers", curves, subject, caption=caption)]
    if record.qfrc_actuator is None or source.cycles:
        missing = "joint powers need measured or computed forces and whole gait cycles."
        return [Section("Joint powers", missing=missing)]
    powers = {}
    for name in record.human.coordinates:
        if without_side(name) in POWERED:
            power = record.torque(name) * record.motion.velocity(name) / record.human.mass
            powers[f"{name}_power [W/kg]"] = known_above(record, name) * power
    figures = _over_time(panels_of(powers), record.motion.time, zero=True)
    text = "Joint moment times joint speed, per kilogram of body mass."
    return [Section("Joint powers over time", figures, text=text)]


@needs("foot.percent", "foot.names")
def foot_segment_section(subject: Subject) -> list[Section]:
    """Return the angles of hindfoot, forefoot and hallux."""
    signals = subject.record.signals
    curves = [
        CycleCurves(name, signals["foot.percent"], signals[f"foot.{name}"])
        for name in subject.words("foot.names")
        if f"foot.{name}" in signals
    ]
    if not curves:
        return []
    caption = (
        "Angles between the segments of the foot, from a fit with multi-segment feet: hindfoot to "
        "tibia, forefoot to hindfoot and to tibia, hallux to forefoot, with the signs and the "
        "order of rotations of the Oxford Foot Model (zero: standing pose of the body). The "
        "forefoot includes the tarsal bones, so the arch bends less than in that model."
    )
    rms = subject.number("foot_segments_marker_rms_mm")
    if rms is not None:
        caption += f" Marker error of the feet {rms:.1f} mm RMS."
    return [cycle_section("Foot segments", curves, subject, caption=caption, published=False)]


def cycle_section(
    title: str,
    curves: Sequence[CycleCurves],
    subject: Subject,
    *,
    caption: str,
    published: bool = True,
) -> Section:
    """Return curves over the gait cycle, one plot per quantity, left and right together."""
    grouped: dict[tuple[str, str], list[CycleCurves]] = {}
    for curve in curves:
        grouped.setdefault((without_side(curve.name), curve.unit), []).append(curve)
    bands = _norms(subject.speed_class) if published else {}
    marks = [(at, STROKES[side]) for side, at in subject.foot_off.items()]
    figures = [
        Figure(_plot(base, unit, members, bands.get(base), marks))
        for (base, unit), members in grouped.items()
    ]
    words = caption
    if any(len(curve.values) > 1 for curve in curves):
        counts = ", ".join(
            f"{max(counted)} {SIDE_NAMES.get(side or '', 'middle')}"
            for side in ("r", "l", None)
            if (counted := [len(c.values) for c in curves if side_of(c.name) == side])
        )
        words += f" Line and coloured band: mean and standard deviation over cycles ({counts})."
    if marks:
        words += " Dashed upright lines: foot off."
    if any(base in bands for base, _ in grouped):
        words += " Grey band: published mean ± 1 SD of healthy people (Schwartz 2008)."
    return Section(title, figures, text=words)


def _plot(base: str, unit: str, members: Sequence[CycleCurves], norm, marks) -> str:
    series, ribbons = [], []
    if norm is not None:
        low, high = norm.mean - norm.sd, norm.mean + norm.sd
        ribbons.append(Ribbon(norm.percent, low, high, STROKE_MIDDLE, 0.22))
        series.append(Series(norm.percent, norm.mean, "norm", STROKE_MIDDLE, 1.0, 0.8, "4 3"))
    for curve in sorted(members, key=lambda c: side_of(c.name) != "r"):
        side = side_of(curve.name)
        mean, sd = mean_sd(curve.values)
        if len(curve.values) > 1:
            ribbons.append(Ribbon(curve.percent, mean - sd, mean + sd, STROKES[side], 0.18))
        series.append(Series(curve.percent, mean, SIDE_NAMES.get(side or "", ""), STROKES[side], 2))
    sides = {side_of(curve.name) for curve in members}
    return line_plot(
        series,
        bands=ribbons,
        marks=[mark for mark in marks if any(STROKES[side] == mark[1] for side in sides)],
        title=title_of(base),
        x_label="gait cycle [%]",
        y_label=axis_label(base, unit),
        least=SPAN.get(unit, 0.0),
    )


def chosen(
    percent: Float[Array, " n_percent"],
    table: Mapping[str, Array],
    names: Sequence[str],
    unit: str,
    suffix: str = "",
) -> list[CycleCurves]:
    """Return the curves of some coordinates, both sides of each."""
    found = []
    for name in names:
        for side in ("", "_r", "_l"):
            values = table.get(f"{name}{side}")
            if values is not None and len(values):
                full = f"{FORCES.get(name, name)}{suffix}{side}"
                found.append(CycleCurves(full, percent, values, unit))
    return found


def mean_sd(values: Float[Array, "n m"]) -> tuple[Float[Array, " m"], Float[Array, " m"]]:
    """Return mean and standard deviation over rows, NaN left out; NaN where nothing is known."""
    known = np.isfinite(values)
    count = known.sum(axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = np.where(known, values, 0.0).sum(axis=0) / count
        spread = np.where(known, values - mean, 0.0) ** 2
        sd = np.sqrt(spread.sum(axis=0) / np.maximum(count - 1, 1))
    return mean, sd


def _norms(speed_class: str) -> dict:
    return {NORMS.get(name, name): norms.norm(name, speed_class) for name in norms.names()}


def measure_section(subject: Subject) -> list[Section]:
    """Return the table of measures: right, left, both, and published."""
    if not subject.walks:
        missing = "no whole gait cycle was found, so no step or stride could be measured."
        return [Section(MEASURES, missing=missing)]
    foot_off = norms.FOOT_OFF[subject.speed_class]
    both = norms.DOUBLE_SUPPORT[subject.speed_class]
    published = {
        "stance": f"{foot_off[0]} ± {foot_off[1]}",
        "double support": f"{both[0]} ± {both[1]}",
    }
    rows = [
        [name, "", "", figure_text(subject.number(key)), unit, published.get(name, "")]
        for name, unit, key in WHOLE
    ]
    for name, unit, key in BY_SIDE:
        right, left = (figure_text(subject.number(key.format(side))) for side in ("r", "l"))
        rows.append([name, right, left, "", unit, published.get(name, "")])
    text = (
        "A step goes from one foot's heel strike to the other's, a stride to the same foot's next. "
        f"Published values: {norms.CITATION}."
    )
    headers = ("measure", "right", "left", "both", "unit", "published")
    return [Section(MEASURES, headers=headers, rows=rows, text=text)]

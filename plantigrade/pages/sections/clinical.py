"""Clinical report sheet: angles of five levels in three planes, scores and symmetry."""

from collections.abc import Mapping, Sequence

import numpy as np

from plantigrade.analyze.gait_profile import ANGLES, MIN_IMPORTANT_DIFFERENCE
from plantigrade.analyze.symmetry import ANGLES as BOTH_SIDES
from plantigrade.charts import Figure, bar_plot
from plantigrade.charts.labels import title_of
from plantigrade.charts.theme import STROKES
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.pages.section import ReportedRun, Section
from plantigrade.pages.sections.cycles import chosen, curve_figure, cycle_caption
from plantigrade.pages.text import rounded_text, signed_text
from plantigrade.record.signals import SIGNALS

TITLE = SIGNALS["norms.mean"].section
PLANES = ("sagittal plane", "frontal plane", "transverse plane")
LEVELS = (
    ("pelvis_tilt", "pelvis_list", "pelvis_rotation"),
    ("hip_flexion", "hip_adduction", "hip_rotation"),
    ("knee_angle", "", ""),
    ("ankle_angle", "subtalar_angle", ""),
    ("mtp_angle", "", "foot_progression"),
)
"""Pelvis, hip, knee, ankle and foot: the coordinate of each plane; empty if there is none."""
NAMES = tuple(name for level in LEVELS for name in level if name)
BLANK = " Blank: the model has no such angle; its knee is a hinge."
OWN_SIDE = {
    "pelvis_list": "own side up ← [°] → down",
    "pelvis_rotation": "own side back ← [°] → front",
}
"""Axis labels for angles of the pelvis, which are drawn for each side."""
FIGURE_HEIGHT = 188  # [px] height of a plot, so that five rows with headings fill one printed page


def clinical_section(subject: ReportedRun) -> list[Section]:
    """Return the angles of pelvis, hip, knee, ankle and foot in three planes, both sides."""
    if not subject.walks:
        return []
    record, percent = subject.record, subject.angle_curves.percent
    marks, ticks = subject.foot_off, opposite_events(subject)
    drawn = {}
    for name in NAMES:
        curves = chosen(percent, subject.clinical_angles, (name,), "°")
        moves = any(np.nanmax(c.values) - np.nanmin(c.values) > 1e-6 for c in curves)
        if moves or (curves and name in ANGLES):
            drawn[name] = curve_figure(
                name,
                curves,
                subject,
                ticks=ticks,
                y_label=OWN_SIDE.get(name, ""),
                height=FIGURE_HEIGHT,
            )
    shown = [c for name in drawn for c in chosen(percent, subject.clinical_angles, (name,), "°")]
    caption = (
        "From heel strike (0 %) to the next heel strike of the same foot (100 %). Pelvis: over the "
        "cycles of each foot, mirrored for the left."
    )
    if marks and ticks:
        caption += " Short lines at the top: foot off and heel strike of the other foot."
    caption += BLANK
    cells_of_symmetry = cycle_caption(caption, shown, subject, list(drawn))
    beside = "recorded" in record.references
    others = {"check.quantity", "world.push"} & record.signals.keys()  # results that come first
    sheet = not beside and not others
    return [Section(TITLE, text=cells_of_symmetry, grid=grid_of(drawn), sheet=sheet, folded=beside)]


def grid_of(drawn: Mapping[str, Figure]) -> list[Sequence[Figure | str]]:
    """Return plots by level and plane under a row of headings, levels without a plot left out."""
    rows = [[drawn.get(name, "") for name in level] for level in LEVELS]
    return [PLANES, *(row for row in rows if any(row))]


def opposite_events(subject: ReportedRun) -> list[tuple[float, str]]:
    """Return foot off and heel strike of the other foot [% of the cycle], with colours."""
    found = []
    for side in SIDES:
        cycles = [c for c in subject.angle_curves.cycles if c.side == side]
        for kind in ("opposite_toe_off", "opposite_heel_strike"):
            at = [c.percent(t) for c in cycles if (t := getattr(c, kind)) is not None]
            if at:
                found.append((sum(at) / len(at), STROKES[side]))
    return found


def profile_section(subject: ReportedRun) -> list[Section]:
    """Return Gait Profile Score, Movement Analysis Profile and symmetry, if known."""
    number, who = subject.number, subject.norm_choice
    if number("gps_deg") is None:
        return []
    labels, values, usual, colours, rows = [], [], [], [], []
    for name in ANGLES:
        reference = number(f"gvs_{name}_reference_deg")
        cells = []
        for side in SIDES:
            value = number(f"gvs_{name}_{side}_deg")
            cells.append(rounded_text(value, 1))
            labels.append(f"{title_of(name)}, {SIDE_NAMES[side]}")
            values.append(float("nan") if value is None else value)
            usual.append(float("nan") if reference is None else reference)
            colours.append(STROKES[side])
        alike = [number(key.format(name)) for key in _SYMMETRY] if name in BOTH_SIDES else []
        cells_of_symmetry = [signed_text(alike[0]) if alike and alike[0] is not None else ""]
        cells_of_symmetry += [rounded_text(alike[1], 1) if alike and alike[1] is not None else ""]
        rows.append([title_of(name), *cells, "", rounded_text(reference, 1), *cells_of_symmetry])
    scores = [rounded_text(number(f"gps_{side}deg"), 1) for side in ("r_", "l_", "")]
    rows.append(
        ["Gait Profile Score", *scores, rounded_text(number("gps_reference_deg"), 1), "", ""]
    )
    headers = (
        "angle, differences in °", "right", "left", "both", "usual",
        "symmetry index of the range, %", "trend symmetry, %",
    )  # fmt: skip
    text = (
        "Root mean square difference between the mean curve of each of nine angles and that of "
        f"{who.population.people}, and the root mean square of them all (Baker et al. 2009, Gait & "
        "Posture 30:265); for both sides the pelvis counts once. Usual, and the tick in each bar: "
        "RMS of that difference over the people of the population. Offsets between definitions of "
        "angles are included, mainly in pelvis tilt, hip "
        f"rotation and foot progression. {MIN_IMPORTANT_DIFFERENCE}° is the minimal clinically "
        "important difference of the score in children (Baker et al. 2012, Gait & Posture 35:612). "
        "Symmetry index: right minus left, relative to their mean (Robinson et al. 1987); trend "
        "symmetry: 0 for curves of equal shape (Crenshaw & Richards 2006, Gait & Posture 24:515)."
    )
    bars = bar_plot(
        labels, values, title="Movement Analysis Profile", x_label="RMS difference [°]",
        tips=usual, colours=colours,
    )  # fmt: skip
    title = "Gait Profile Score and symmetry"
    return [Section(title, [Figure(bars)], text=text, headers=headers, rows=rows, folded=True)]


_SYMMETRY = ("symmetry_index_{}_range_pct", "trend_symmetry_{}_pct")

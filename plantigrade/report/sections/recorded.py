"""The motion beside the recorded one: angles, ranges of motion, centre of mass and soles."""

import numpy as np

from plantigrade.analyze.gait_study import PAPER_TABLE
from plantigrade.analyze.reproduction import ROTATIONS
from plantigrade.arrays import Array, Float
from plantigrade.charts import Figure, Ribbon, Series, line_plot
from plantigrade.charts.labels import SIDE_NAMES, axis_label, side_of, without_side
from plantigrade.charts.theme import STROKE_MIDDLE, STROKE_REFERENCE, STROKES
from plantigrade.constants import SIDES
from plantigrade.report.section import Section, Subject, needs
from plantigrade.report.sections.cycles import mean_sd
from plantigrade.report.text import rounded_text, sided_title, signed_text

SHOWN = (
    *(name for _, name in ROTATIONS),
    *("mtp_angle_r", "mtp_angle_l", "pelvis_tilt", "pelvis_list", "pelvis_rotation"),
    *("lumbar_extension", "lumbar_bending", "lumbar_rotation"),
    *("arm_flex_r", "arm_flex_l", "elbow_flex_r", "elbow_flex_l"),
)


@needs(reference="recorded")
def curve_section(subject: Subject) -> Section:
    """Return reproduced and recorded angles over the gait cycle."""
    title = "Reproduced against recorded angles"
    found = subject.comparison
    if not found.cycles:
        return Section(title, missing="the motion holds no whole gait cycle to draw them over.")
    figures = [
        Figure(
            pair_plot(
                found.percent,
                found.curves_simulated[name],
                found.curves_reference[name],
                title=sided_title(name),
                colour=STROKES[side_of(name)],
                y_label=axis_label(without_side(name), "°"),
                note=f"RMSE {found.rmse[name]:.1f}°, r {rounded_text(found.correlation[name])}",
            )
        )
        for name in SHOWN
        if name in found.rom
    ]
    text = "Full line: reproduced; violet dashes: recorded."
    if "tasks.names" in subject.record.signals:
        text += " Of these angles the tasks know only the posture at the end of each phase."
    text += (
        " Curves are cut at the heel strikes of their own side (pelvis and trunk: right); where "
        "there are several cycles, bands are one standard deviation."
    )
    return Section(title, figures, text=text)


def pair_plot(
    percent: Float[Array, " n_percent"],
    ours: Float[Array, "n_cycles n_percent"],
    theirs: Float[Array, "n_cycles n_percent"],
    *,
    title: str,
    colour: str,
    y_label: str,
    note: str = "",
    width: int = 330,
    height: int = 210,
) -> str:
    """Return a plot of reproduced and recorded curves: mean and standard deviation of rows.

    NaN is unknown; the colour is that of ours, and ``note`` stands beside the label of the axis.
    """
    ribbons, series = [], []
    for rows, shade, dash in ((theirs, STROKE_REFERENCE, "5 3"), (ours, colour, "")):
        rows = rows[np.isfinite(rows).any(axis=1)]
        if not len(rows):
            continue
        mean, sd = mean_sd(rows)
        if len(rows) > 1:
            ribbons.append(Ribbon(percent, mean - sd, mean + sd, shade, 0.15))
        series.append(Series(percent, mean, "", shade, 1.8, 1.0, dash))
    return line_plot(
        series,
        bands=ribbons,
        title=title,
        x_label=f"gait cycle [%] · {note}" if note else "gait cycle [%]",
        y_label=y_label,
        least=10.0,
        width=width,
        height=height,
    )


@needs(reference="recorded")
def rom_section(subject: Subject) -> Section:
    """Return the table of ranges of motion; of an ordered-task gait beside the paper's."""
    title = "Ranges of motion"
    found, published = subject.comparison, "tasks.names" in subject.record.signals
    shown = [(label, name) for label, name in ROTATIONS if name in found.rom]
    if not shown:
        return Section(title, missing="the body has none of the rotations of the table.")
    rows = []
    for label, name in shown:
        (ours, theirs), paper = found.rom[name], PAPER_TABLE[name]
        row = [label, f"{ours:.1f}", f"{theirs:.1f}", signed_text(ours - theirs)]
        row += [f"{found.rmse[name]:.1f}", rounded_text(found.correlation[name])]
        if published:
            row += [str(paper.simulated), str(paper.reference), signed_text(-paper.difference, 0)]
        rows.append(row)
    headers = ["rotation", "reproduced", "recorded", "difference", "RMSE", "r"]
    text = (
        "Range of motion over the gait cycle in degrees, mean over the cycles, and the root mean "
        "square difference (RMSE) and correlation (r) of the curves."
    )
    if published:
        headers += ["paper: simulated", "recorded", "difference"]
        text += " The paper's columns are the means of nine people (Boukheddimi et al., Table I)."
    errors = [abs(found.rom_error[name]) for _, name in shown]
    text += f" Mean difference {np.mean(errors):.1f}°, largest {np.max(errors):.1f}°."
    return Section(title, text=text, headers=headers, rows=rows)


@needs(reference="recorded")
def com_section(subject: Subject) -> Section:
    """Return how far the centre of mass was off, and how high the feet were."""
    time, found = subject.record.motion.time, subject.comparison
    error, soles, recorded = (
        1e3 * values for values in (found.com_error, found.soles, found.soles_reference)
    )
    com = line_plot(
        [Series(time, error, "", STROKE_MIDDLE, 1.8)],
        title="Centre of mass off its path",
        x_label="time [s]",
        y_label="[mm]",
        width=520,
        zero=True,
        least=1.0,
    )
    figures = [Figure(com, f"Largest {np.max(error, initial=0.0):.2f} mm.")]
    for k, side in enumerate(SIDES):
        sole = line_plot(
            [
                Series(time, recorded[:, k], "recorded", STROKE_REFERENCE, 1.6, 1.0, "5 3"),
                Series(time, soles[:, k], "reproduced", STROKES[side]),
            ],
            title=f"{SIDE_NAMES[side].capitalize()} sole",
            x_label="time [s]",
            y_label="lowest point above ground [mm]",
            width=520,
            zero=True,
            least=20.0,
        )
        figures.append(Figure(sole))
    text = ""
    if "tasks.names" in subject.record.signals:
        text = (
            "No task tracks the height of the feet: it follows from the centre of mass, the "
            "heels' paths over the ground, the posture at the end of each phase, and the floor, "
            "which no point of a sole may enter."
        )
    return Section("Centre of mass and soles", figures, text=text)

"""Comparison of motion and forces with the recorded ones."""

from collections.abc import Sequence

import numpy as np

from plantigrade.analyze.curves import LOADED_JOINTS
from plantigrade.analyze.gait_study import PAPER_TABLE
from plantigrade.analyze.reproduction import ROTATIONS, compare
from plantigrade.analyze.reproduction_status import MAX_FORCED_COM_ERROR
from plantigrade.analyze.statistics import mean_sd
from plantigrade.arrays import Array, Float
from plantigrade.charts import Figure, Ribbon, Series, line_plot
from plantigrade.charts.labels import axis_label
from plantigrade.charts.theme import STROKE_MIDDLE, STROKE_REFERENCE, STROKES
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.pages.section import ReportedRun, Section, needs
from plantigrade.pages.sections.ground import AXES
from plantigrade.pages.text import rounded_text, sided_title, signed_text
from plantigrade.record import Record
from plantigrade.side_names import side_of, without_side

OTHER_ANGLES = (
    *("mtp_angle_r", "mtp_angle_l", "pelvis_tilt", "pelvis_list", "pelvis_rotation"),
    *("lumbar_extension", "lumbar_bending", "lumbar_rotation"),
    *("arm_flex_r", "arm_flex_l", "elbow_flex_r", "elbow_flex_l"),
)
NO_FORCES = "the motion was computed without forces."
SEPARATE_MOTION = (
    " They belong to a separate motion (forces.npz), because a balancing body cannot track the "
    "recorded centre of mass to the millimetre. The sections over the gait cycle and the arrows "
    "of the pictures show the same forces."
)
FELL_NOTE = (
    " They belong to a separate motion (forces.npz) and are shown until the fall of the body."
)


@needs(reference="recorded")
def curve_section(subject: ReportedRun) -> list[Section]:
    """Return reproduced and recorded angles over the gait cycle, legs first."""
    title = "Reproduced against recorded angles"
    if not subject.comparison.cycles:
        return [
            Section(title, missing="the motion holds no complete gait cycle to draw them over.")
        ]
    text = "Full line: reproduced; violet dashes: recorded."
    if "tasks.names" in subject.record.signals:
        text += (
            " The tasks include only the posture at the end of each phase and, by default, its "
            "velocity."
        )
    text += (
        " Cycles start at heel strikes of the same side (pelvis and trunk: right). Bands are one "
        "standard deviation over several cycles."
    )
    legs, others = (_pairs(subject, names) for names in ([n for _, n in ROTATIONS], OTHER_ANGLES))
    found = [Section(title, legs, text=text)]
    if others:
        more = "Toes, pelvis, trunk and arms against the recorded ones"
        found.append(Section(more, others, text="Plotted as above.", folded=True))
    return found


def _pairs(subject: ReportedRun, names: Sequence[str]) -> list[Figure]:
    """Return one plot per known coordinate."""
    found = subject.comparison
    return [
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
        for name in names
        if name in found.rom
    ]


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
    """Return a plot of reproduced and recorded curves, with mean and standard deviation of rows.

    Unknown values are NaN; the colour is that of the reproduced curve, and ``note`` is shown next
    to the axis label.
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
def rom_section(subject: ReportedRun) -> Section:
    """Return the table of ranges of motion, for ordered tasks with the paper's values."""
    title = "Ranges of motion"
    found, published = subject.comparison, "tasks.names" in subject.record.signals
    shown = [name for _, name in ROTATIONS if name in found.rom]
    if not shown:
        return Section(title, missing="the body has none of the rotations of the table.")
    rows = []
    for name in shown:
        (ours, theirs), paper = found.rom[name], PAPER_TABLE[name]
        row = [sided_title(name), f"{ours:.1f}", f"{theirs:.1f}", signed_text(ours - theirs)]
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
        headers += ["paper: simulated", "paper: recorded", "paper: difference"]
        text += " The paper's columns are the means of nine people (Boukheddimi et al., Table I)."
    errors = [abs(found.rom_error[name]) for name in shown]
    text += f" Mean difference {np.mean(errors):.1f}°, largest {np.max(errors):.1f}°."
    return Section(title, text=text, headers=headers, rows=rows)


@needs(reference="recorded")
def com_section(subject: ReportedRun) -> Section:
    """Return the error of the centre of mass, and the height of the feet."""
    time, found = subject.record.motion.time, subject.comparison
    error, soles, recorded = (
        1e3 * values for values in (found.com_error, found.soles, found.soles_reference)
    )
    com = line_plot(
        [Series(time, error, "", STROKE_MIDDLE, 1.8)],
        title="Centre of mass distance from its path",
        y_label="[mm]",
        width=520,
        zero=True,
        least=1.0,
    )
    figures = [Figure(com, f"Largest {np.max(error, initial=0.0):.2f} mm.")]
    for k, side in enumerate(SIDES):
        sole = line_plot(
            pair_series(time, soles[:, k], recorded[:, k], side, ("reproduced", "recorded")),
            title=f"{SIDE_NAMES[side].capitalize()} sole",
            y_label="lowest point above ground [mm]",
            width=520,
            zero=True,
            least=20.0,
        )
        figures.append(Figure(sole))
    text = ""
    if "tasks.names" in subject.record.signals:
        text = (
            "No task tracks the height of the feet. It results from the centre of mass, the "
            "horizontal paths of the heels, the posture at the end of each phase, and the "
            "constraint that no point of a sole penetrates the ground."
        )
    return Section("Centre of mass and soles", figures, text=text, folded=True)


def force_section(subject: ReportedRun) -> list[Section]:
    """Return the computed ground reactions, with measured ones if known."""
    title = "Computed ground reactions"
    if not _computed(subject):
        return _absent(subject, title)
    record, upto = _moved(subject), _standing(subject)
    time = record.motion.time[:upto]
    measured = _measured(record, "measured.force")
    if measured is not None:
        title = "Ground reactions: computed beside measured"
    figures = []
    for axis, name in AXES.items():
        for k, side in enumerate(SIDES):
            drawing = _plot(
                time,
                record.foot(side).force[:upto, axis] / record.weight,
                None if measured is None else measured[:upto, k, axis] / record.weight,
                side,
                title=f"{SIDE_NAMES[side].capitalize()}, {name}",
                y_label="[BW]",
                least=0.1,
            )
            figures.append(Figure(drawing))
    text = "Ground reaction on each foot in body weights. Full line: computed"
    text += " without any measured force; violet dashes: measured." if measured is not None else "."
    if record is not subject.record and record is subject.forces:
        text += SEPARATE_MOTION
    elif record is not subject.record:
        text += FELL_NOTE
    return [Section(title, figures, text=text, folded=True)]


def moment_section(subject: ReportedRun) -> list[Section]:
    """Return the computed joint moments, with those from measured forces if known."""
    title = "Computed joint moments"
    if not _computed(subject):
        return _absent(subject, title)
    record, upto = _moved(subject), _standing(subject)
    measured = _measured(record, "measured.moment")
    names = [str(name) for name in record.signals.get("measured.moment_names", ())]
    if measured is not None:
        title = "Joint moments: computed beside measured"
    else:
        hinges = record.human.coordinates
        names = [f"{n}_{s}" for n in LOADED_JOINTS for s in SIDES if f"{n}_{s}" in hinges]
    figures = [
        Figure(
            _plot(
                record.motion.time[:upto],
                record.torque(name)[:upto] / record.human.mass,
                None if measured is None else measured[:upto, i],
                side_of(name) or "",
                title=sided_title(name),
                y_label=axis_label(without_side(name), "N m/kg"),
                least=0.2,
            )
        )
        for i, name in enumerate(names)
    ]
    text = "Internal moments per body mass"
    if measured is not None:
        text += "; violet dashes: inverse dynamics of the recorded motion and the measured forces"
    return [Section(title, figures, text=text + ".", folded=True)]


def _moved(subject: ReportedRun) -> Record:
    """Return the motion moved by forces, even after a fall."""
    return subject.run.others.get("forces", subject.record)


def _computed(subject: ReportedRun) -> bool:
    """Return whether there are computed forces, of tasks or with measured ones."""
    moved = _moved(subject)
    there = moved.has_forces and moved.qfrc_actuator is not None
    there &= "forces.band" not in moved.signals  # estimated forces have their own sections
    return there and (moved is not subject.record or "measured.force" in moved.signals)


def _measured(record: Record, name: str) -> Array | None:
    """Return a measured signal; None if it was never measured."""
    found = record.signals.get(name)
    return found if found is not None and np.isfinite(found).any() else None


def _standing(subject: ReportedRun) -> int:
    """Return the number of frames before a fall, or of all frames."""
    moved = _moved(subject)
    if subject.forces is moved or "recorded" not in moved.references:
        return moved.motion.n_frames
    fell = compare(moved).com_error > MAX_FORCED_COM_ERROR
    return int(np.argmax(fell)) if fell.any() else moved.motion.n_frames


def _absent(subject: ReportedRun, title: str) -> list[Section]:
    """Return a section with the reason, for a motion from tasks; nothing for others."""
    from_tasks = "tasks.names" in subject.record.signals
    return [Section(title, missing=NO_FORCES)] if from_tasks else []


def _plot(time: Array, ours: Array, theirs: Array | None, side: str, **options) -> str:
    series = pair_series(time, ours, theirs, side, ("computed", "measured"))
    return line_plot(series, width=520, zero=True, **options)


def pair_series(
    x: Float[Array, " n"],
    ours: Float[Array, " n"],
    theirs: Float[Array, " n"] | None,
    side: str,
    labels: tuple[str, str],
) -> list[Series]:
    """Return a curve of a side over violet dashes of another one; without what is not known."""
    series = []
    if theirs is not None and np.isfinite(theirs).any():
        series.append(Series(x, theirs, labels[1], STROKE_REFERENCE, 1.6, 1.0, "5 3"))
    if np.isfinite(ours).any():
        series.append(Series(x, ours, labels[0], STROKES[side], 1.8))
    return series

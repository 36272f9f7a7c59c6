"""Computed ground reactions and joint moments beside the measured ones."""

import numpy as np

from plantigrade.analyze.reproduction import compare
from plantigrade.arrays import Array
from plantigrade.charts import Figure, Series, line_plot
from plantigrade.charts.labels import SIDE_NAMES, axis_label, side_of, without_side
from plantigrade.charts.theme import STROKE_REFERENCE, STROKES
from plantigrade.constants import SIDES
from plantigrade.record import Record
from plantigrade.report.section import Section, Subject
from plantigrade.report.text import sided_title

AXES = ("forward", "sideways (left positive)", "vertical")
SHOWN = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")
NOT_ASKED = "the motion moved by forces was not asked for."
MOVED = (
    " They belong to a motion of their own (forces.npz): a body that balances cannot follow the "
    "recorded centre of mass to the millimetre. The sections over the gait cycle and the arrows "
    "of the pictures show the same forces."
)
FELL = " They belong to a motion of their own (forces.npz), in which the body fell; up to there."
FALLEN = 0.15  # a body whose centre of mass is further off its path has fallen [m]


def force_section(subject: Subject) -> list[Section]:
    """Return the computed ground reactions, beside the measured ones where there are any."""
    title = "Ground reactions: computed beside measured"
    if not _computed(subject):
        return _absent(subject, title)
    record = _moved(subject)
    upto = _standing(subject)
    time = record.motion.time[:upto]
    measured = record.signals.get("measured.force")
    if measured is None:
        title = "Computed ground reactions"
    figures = []
    for axis in (2, 0, 1):
        for k, side in enumerate(SIDES):
            drawing = _plot(
                time,
                record.foot(side).force[:upto, axis] / record.weight,
                None if measured is None else measured[:upto, k, axis] / record.weight,
                side,
                title=f"{SIDE_NAMES[side].capitalize()}, {AXES[axis]}",
                y_label="[BW]",
                least=0.1,
            )
            figures.append(Figure(drawing))
    text = "Force of the ground on each foot in body weights. Full line: computed"
    text += " without any measured force; violet dashes: measured." if measured is not None else "."
    if record is not subject.record and record is subject.forces:
        text += MOVED
    elif record is not subject.record:
        text += FELL
    return [Section(title, figures, text=text)]


def moment_section(subject: Subject) -> list[Section]:
    """Return the computed joint moments, beside inverse dynamics of the measured forces."""
    title = "Joint moments: computed beside measured"
    if not _computed(subject):
        return _absent(subject, title)
    record, upto = _moved(subject), _standing(subject)
    measured = record.signals.get("measured.moment")
    names = [str(name) for name in record.signals.get("measured.moment_names", ())]
    if measured is None:
        title = "Computed joint moments"
        hinges = record.human.coordinates
        names = [f"{n}_{s}" for n in SHOWN for s in SIDES if f"{n}_{s}" in hinges]
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
    return [Section(title, figures, text=text + ".")]


def _moved(subject: Subject) -> Record:
    """Return the motion moved by forces, also one that fell."""
    return subject.run.others.get("forces", subject.record)


def _computed(subject: Subject) -> bool:
    """Return whether there are computed forces: of tasks, or with measured ones to compare."""
    moved = _moved(subject)
    there = moved.has_forces and moved.qfrc_actuator is not None
    return there and (moved is not subject.record or "measured.force" in moved.signals)


def _standing(subject: Subject) -> int:
    """Return the number of frames before the body fell; all where it did not."""
    moved = _moved(subject)
    if subject.forces is moved or "recorded" not in moved.references:
        return moved.motion.n_frames
    fell = compare(moved).com_error > FALLEN
    return int(np.argmax(fell)) if fell.any() else moved.motion.n_frames


def _absent(subject: Subject, title: str) -> list[Section]:
    """Return the line that says why, for a motion from tasks; nothing for others."""
    from_tasks = "tasks.names" in subject.record.signals
    return [Section(title, missing=NOT_ASKED)] if from_tasks else []


def _plot(time: Array, ours: Array, theirs: Array | None, side: str, **options) -> str:
    series = []
    if theirs is not None and np.isfinite(theirs).any():
        series.append(Series(time, theirs, "measured", STROKE_REFERENCE, 1.6, 1.0, "5 3"))
    series.append(Series(time, ours, "computed", STROKES[side], 1.8))
    return line_plot(series, x_label="time [s]", width=520, zero=True, **options)

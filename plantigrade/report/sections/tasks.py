"""The ordered tasks of a gait: their order, when they act, and what each level missed."""

import numpy as np

from plantigrade.charts import Bar, Figure, Series, line_plot, timeline_plot
from plantigrade.charts.labels import SIDE_NAMES
from plantigrade.charts.theme import PALETTE, STROKE_MIDDLE, STROKES
from plantigrade.constants import SIDES
from plantigrade.report.section import Section, Subject, needs
from plantigrade.report.text import task_text

TINY = 1e-8  # residuals below this are drawn here: they are zero but for rounding
LONGEST = 60  # phases beyond which only the beginning of the timeline is drawn
REGIONS = ("heel", "ball", "toes")


@needs("tasks.names", "tasks.level", "tasks.active")
def task_section(subject: Subject) -> Section:
    """Return the order of the tasks, and the phases, contacts and tasks over time."""
    signals, time = subject.record.signals, subject.record.motion.time
    last = float(time[-1])
    phases = signals.get("phase.span", np.zeros((0, 2)))
    end = float(phases[LONGEST - 1, 1]) if len(phases) > LONGEST else last
    rows = [("phase", _phases(subject)), *_contacts(subject)]
    names, levels = subject.words("tasks.names"), [int(n) for n in signals["tasks.level"]]
    for k, name in enumerate(names):
        active = signals["tasks.active"][:, k].astype(bool)
        bars = [Bar(float(time[a]), float(time[b]), _tint(levels[k])) for a, b in runs(active)]
        rows.append((f"{levels[k]}  {task_text(name)}", bars))
    cut = [(label, [b for bar in bars if (b := _cut(bar, end))]) for label, bars in rows]
    ends = [float(t) for t in signals.get("posture.end", ()) if t <= end]
    caption = (
        "Upright lines: ends of phases, where the posture is to be reached. A numbered row is a "
        "task with its level; its bar shows when the task is active."
    )
    if end < last:
        caption += f" The first {end:.1f} s of {last:.1f} s are drawn."
    drawing = timeline_plot(cut, title="What is active when", x_label="time [s]", marks=ends)
    meanings = subject.words("tasks.meanings") or ("",) * len(names)
    table = [["0", "limits of the joints", "Range, speed and acceleration of every joint."]]
    table += [[str(levels[k]), task_text(name), meanings[k]] for k, name in enumerate(names)]
    chosen = subject.figures.get("tasks") or subject.run.provenance.settings.get("tasks")
    text = f"The tasks of the set “{chosen}”, most important first." if chosen else ""
    text += (
        " A task of a lower level is done as well as the levels above it leave freedom, and never "
        "changes what they reach."
    )
    return Section(
        "The tasks and when they act",
        [Figure(drawing, caption, wide=True)],
        text=text.strip(),
        headers=("level", "task", "what it does"),
        rows=table,
    )


@needs("tasks.names", "tasks.level", "tasks.active", "tasks.residual")
def residual_section(subject: Subject) -> Section:
    """Return by how much each level was missed over time."""
    signals, time = subject.record.signals, subject.record.motion.time
    active, level = signals["tasks.active"].astype(bool), signals["tasks.level"]
    residual = np.where(active, signals["tasks.residual"], 0.0)
    series = []
    for k in sorted({int(v) for v in level}):
        mine = level == k
        missed = np.linalg.norm(residual[:, mine], axis=1)
        missed = np.where(active[:, mine].any(axis=1), missed, np.nan)
        words = [task_text(n) for n, m in zip(subject.words("tasks.names"), mine, strict=True) if m]
        words = list(dict.fromkeys(w.removesuffix(" right").removesuffix(" left") for w in words))
        series.append(Series(time, missed, f"{k} {', '.join(words)}", _tint(k), 1.3, 0.9))
    drawing = line_plot(
        series,
        title="",
        x_label="time [s]",
        y_label="acceleration missed [1/s²]",
        width=1060,
        height=320,
        log=TINY,
    )
    caption = (
        "Logarithmic; lines at the lower edge are zero but for rounding. A level stands out where "
        "those above it, or a limit of a joint, leave it no freedom."
    )
    text = (
        "Norm of the difference between the acceleration each level asks for and the one it gets, "
        "in m/s² (posture: rad/s²)."
    )
    return Section("What each level missed", [Figure(drawing, caption, wide=True)], text=text)


def runs(active: np.ndarray) -> list[tuple[int, int]]:
    """Return first and last frame of every stretch in which something is active."""
    edges = np.flatnonzero(np.diff(np.r_[0, active.astype(np.int8), 0]))
    last = len(active) - 1
    return [(int(a), min(int(b), last)) for a, b in edges.reshape(-1, 2)]


def _phases(subject: Subject) -> list[Bar]:
    spans = subject.record.signals.get("phase.span", np.zeros((0, 2)))
    bars = []
    for (start, stop), kind, swing in zip(
        spans, subject.words("phase.kind"), subject.words("phase.swing"), strict=True
    ):
        double = kind == "double"
        words = "double support" if double else f"{SIDE_NAMES[swing]} swing"
        colour = STROKE_MIDDLE if double else STROKES[swing]
        bars.append(Bar(float(start), float(stop), colour, words, 0.35))
    return bars


def _contacts(subject: Subject) -> list[tuple[str, list[Bar]]]:
    spans = subject.record.signals.get("contact.span", np.zeros((0, 2)))
    places = subject.words("contact.place")
    return [
        (
            f"{SIDE_NAMES[side]} {region} on the ground",
            [
                Bar(float(start), float(stop), STROKES[side], opacity=0.6)
                for (start, stop), place in zip(spans, places, strict=True)
                if place == f"{region}_{side}"
            ],
        )
        for side in SIDES
        for region in REGIONS
    ]


def _cut(bar: Bar, end: float) -> Bar | None:
    if bar.start >= end:
        return None
    return Bar(bar.start, min(bar.stop, end), bar.colour, bar.label, bar.opacity)


def _tint(level: int) -> str:
    return PALETTE[int(level) % len(PALETTE)]

"""The ordered tasks of a gait: their order, active times, and the residual of each level."""

from dataclasses import replace

import numpy as np

from plantigrade.arrays import Array
from plantigrade.charts import Bar, Figure, Series, line_plot, timeline_plot
from plantigrade.charts.theme import PALETTE, STROKE_MIDDLE, STROKES
from plantigrade.constants import SIDE_NAMES, SIDES
from plantigrade.motion.filters import runs
from plantigrade.pages.section import ReportedRun, Section, needs
from plantigrade.pages.text import place_text, task_text
from plantigrade.record.signals import SIGNALS

MIN_DRAWN = 1e-8  # smaller residuals are rounding errors and drawn at this value
MAX_PHASES = 60  # maximum number of phases in the timeline
REGIONS = ("heel", "ball", "toes")


@needs("tasks.names", "tasks.level", "tasks.active")
def task_section(subject: ReportedRun) -> Section:
    """Return the order of the tasks, and the phases, contacts and tasks over time."""
    signals, time = subject.record.signals, subject.record.motion.time
    last = float(time[-1])
    phases = signals.get("phase.span", np.zeros((0, 2)))
    end = float(phases[MAX_PHASES - 1, 1]) if len(phases) > MAX_PHASES else last
    rows = [("phase", _phases(subject)), *_contacts(subject)]
    names, levels = subject.text_signal("tasks.names"), [int(n) for n in signals["tasks.level"]]
    for k, name in enumerate(names):
        active = signals["tasks.active"][:, k].astype(bool)
        bars = active_bars(active, time, _tint(levels[k]))
        rows.append((f"{levels[k]}  {task_text(name)}", bars))
    cut = [
        (label, [replace(bar, stop=min(bar.stop, end)) for bar in bars if bar.start < end])
        for label, bars in rows
    ]
    ends = [float(t) for t in signals.get("posture.end", ()) if t <= end]
    caption = (
        "Vertical lines: ends of phases, the target times of postures. Numbered rows are tasks "
        "with their level; bars show when a task is active."
    )
    if end < last:
        caption += f" The first {end:.1f} s of {last:.1f} s are drawn."
    drawing = timeline_plot(cut, title="Active tasks over time", marks=ends)
    meanings = subject.text_signal("tasks.meanings", len(names))
    table = [["0", "limits of the joints", "Range, speed and acceleration of every joint."]]
    table += [[str(levels[k]), task_text(name), meanings[k]] for k, name in enumerate(names)]
    chosen = subject.figures.get("tasks") or subject.run.provenance.settings.get("tasks")
    text = f"The tasks of the set “{chosen}”, most important first." if chosen else ""
    text += (
        " A task of a lower level is done as well as the levels above it leave freedom, and never "
        "changes what they reach."
    )
    return Section(
        SIGNALS["tasks.active"].section,
        [Figure(drawing, caption, wide=True)],
        text=text.strip(),
        headers=("level", "task", "what it does"),
        rows=table,
        folded=True,
    )


@needs("tasks.names", "tasks.level", "tasks.active", "tasks.residual")
def residual_section(subject: ReportedRun) -> Section:
    """Return the residual of each level over time."""
    signals, time = subject.record.signals, subject.record.motion.time
    active, level = signals["tasks.active"].astype(bool), signals["tasks.level"]
    residual = np.where(active, signals["tasks.residual"], 0.0)
    residual_of = SIGNALS["tasks.residual"]
    series = []
    for k in sorted({int(v) for v in level}):
        mine = level == k
        missed = np.linalg.norm(residual[:, mine], axis=1)
        missed = np.where(active[:, mine].any(axis=1), missed, np.nan)
        words = [
            task_text(n) for n, m in zip(subject.text_signal("tasks.names"), mine, strict=True) if m
        ]
        words = list(dict.fromkeys(w.removesuffix(" right").removesuffix(" left") for w in words))
        series.append(Series(time, missed, f"{k} {', '.join(words)}", _tint(k), 1.3, 0.9))
    drawing = line_plot(
        series,
        y_label=f"residual acceleration [{residual_of.unit}]",
        width=1060,
        height=320,
        log=MIN_DRAWN,
    )
    caption = (
        "Logarithmic; lines at the lower edge are rounding errors. A residual is large where "
        "higher levels, or joint limits, leave no freedom for a level."
    )
    text = (
        "Norm of the difference between desired and achieved acceleration of each level, "
        "in m/s² (posture: rad/s²)."
    )
    figures = [Figure(drawing, caption, wide=True)]
    return Section(residual_of.section, figures, text=text, folded=True)


def active_bars(active: Array, time: Array, colour: str, opacity: float = Bar.opacity) -> list[Bar]:
    """Return a bar for every interval of active frames."""
    last = len(time) - 1
    spans = [(time[s.start], time[min(s.stop, last)]) for s in runs(active)]
    return [Bar(float(start), float(stop), colour, "", opacity) for start, stop in spans]


def _phases(subject: ReportedRun) -> list[Bar]:
    spans = subject.record.signals.get("phase.span", np.zeros((0, 2)))
    swings = subject.text_signal("phase.swing")
    bars = []
    for (start, stop), kind, swing in zip(
        spans, subject.text_signal("phase.kind"), swings, strict=True
    ):
        double = kind == "double"
        words = "double support" if double else f"{SIDE_NAMES[swing]} swing"
        colour = STROKE_MIDDLE if double else STROKES[swing]
        bars.append(Bar(float(start), float(stop), colour, words, 0.35))
    return bars


def _contacts(subject: ReportedRun) -> list[tuple[str, list[Bar]]]:
    places = [f"{region}_{side}" for side in SIDES for region in REGIONS]
    bars: dict[str, list[Bar]] = {place: [] for place in places}
    spans = subject.record.signals.get("contact.span", np.zeros((0, 2)))
    for (start, stop), place in zip(spans, subject.text_signal("contact.place"), strict=True):
        bar = Bar(float(start), float(stop), STROKES[place[-1]], opacity=0.6)
        bars.setdefault(place, []).append(bar)
    return [(f"{place_text(p, p[-1])} on the ground", bars[p]) for p in places]


def _tint(level: int) -> str:
    return PALETTE[int(level) % len(PALETTE)]

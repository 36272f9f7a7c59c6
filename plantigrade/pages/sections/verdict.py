"""Results of the check and of the solver, and the required joint strength."""

import numpy as np

from plantigrade.analyze.quantities import CONDITION, QUANTITY
from plantigrade.analyze.quantities import quantity as quantity_of
from plantigrade.charts import Figure, Series, bar_plot, line_plot
from plantigrade.charts.labels import COORDINATES
from plantigrade.charts.theme import STROKE_LEFT, STROKE_MIDDLE, STROKE_RIGHT, STROKES
from plantigrade.constants import SIDE_NAMES
from plantigrade.pages.section import ReportedRun, Section, needs
from plantigrade.pages.text import (
    figure_text,
    number_text,
    place_text,
    power_text,
    rounded_text,
    sided_title,
)
from plantigrade.record.signals import SIGNALS
from plantigrade.side_names import side_of, without_side

MIN_DRAWN = 1e-9  # smaller violations are drawn at this value
MAX_JOINTS = 16  # joints in the table of strength
SOLVERS = {"interior-point": "banded interior point", "ipopt": "IPOPT"}
STAGE, NUMBER, OBJECTIVE, VIOLATION, OPTIMALITY = range(5)
"""Columns of ``solver.history``."""
CONDITION_UNITS = {"deg": (1.0, "°"), "deg/s": (1.0, "°/s"), "m": (1000.0, "mm")}
"""Units of conditions: factor and label in the table."""
HEADERS = ("quantity", "worst", "limit", "unit", "where", "when", "ok")


@needs("check.quantity", "check.value", "check.limit", "check.bad")
def check_section(subject: ReportedRun) -> Section:
    """Return the table of the check: worst value, limit, location and time."""
    record = subject.record
    rows = [row for met, row in _rows(subject) if not met]
    text = (
        "The check is independent of the optimiser: it examines the finished motion in "
        f"{record.motion.n_frames} frames over {record.motion.duration:.2f} s with MuJoCo's "
        "inverse dynamics, and alone determines whether the run is ok. Residual forces must be "
        "nearly zero, and contacts in stance must not slip. Negative values have that margin to "
        "the limit."
    )
    return Section(SIGNALS["check.value"].section, text=text, headers=HEADERS, rows=rows)


@needs("check.quantity", "check.value", "check.limit", "check.bad")
def condition_section(subject: ReportedRun) -> list[Section]:
    """Return the conditions of the task that are met; others are in the table of the check."""
    rows = [row for met, row in _rows(subject) if met]
    text = "Conditions of the task, evaluated in every frame of the check."
    section = Section("Conditions of the task", text=text, headers=HEADERS, rows=rows, folded=True)
    return [section] if rows else []


def _rows(subject: ReportedRun) -> list[tuple[bool, list[str]]]:
    """Return the rows of the check, and whether each is a condition that is met."""
    words, check = subject.text_signal, subject.record.group("check")
    n, rows = len(check["quantity"]), []
    for quantity, value, limit, unit, where, side, time, bad in zip(
        words("check.quantity"),
        check["value"],
        check["limit"],
        words("check.unit", n),
        words("check.where", n),
        words("check.side", n),
        check.get("time", np.full(n, np.nan)),
        check["bad"],
        strict=True,
    ):
        factor, unit = CONDITION_UNITS.get(unit, (1.0, unit))
        judged = np.isfinite(value) and np.isfinite(limit)
        digits = _digits(factor * limit)
        known = quantity == CONDITION.name or quantity in QUANTITY
        row = [quantity_of(quantity).label if known else quantity.replace("_", " ")]
        row += [_number(factor * x, digits) for x in (value, limit)]
        row += [unit, _place(where, side), f"{time:.2f} s" if np.isfinite(time) else ""]
        row += [("no" if bad else "yes") if judged or bad else "–"]
        rows.append((quantity == "condition" and not bad, row))
    return rows


def _digits(limit: float) -> int:
    """Return the decimals of a value that is compared with a limit: three digits of the limit."""
    if not np.isfinite(limit) or abs(limit) < 1e-9:
        return 2
    return int(np.clip(2 - np.floor(np.log10(abs(limit))), 0, 3))


def _number(value: float, digits: int) -> str:
    return rounded_text(0.0 if abs(value) < 0.5 * 10.0**-digits else value, digits)


def _place(where: str, side: str) -> str:
    """Return a readable name of a location, coordinate or condition.

    Example:
        >>> _place("heel_back_r", "r"), _place("knee_angle_r", "r"), _place("height of seat_l", "")
        ('right heel back', 'knee flexion, right', 'height of seat, left')
        >>> _place("pelvis_ty (at least)", "")
        'pelvis height (at least)'
    """
    name, bracket, bound = where.partition(" (")
    bound = bracket + bound
    if without_side(name) in COORDINATES:
        title = sided_title(name)
        return title[0].lower() + title[1:] + bound
    stem, _, last = name.replace("_", " ").rpartition(" ")
    if not side and last in SIDE_NAMES and stem:
        return f"{stem}, {SIDE_NAMES[last]}{bound}"
    return place_text(name, side) + bound


@needs("check.findings")
def findings_section(subject: ReportedRun) -> list[Section]:
    """Return the findings of the check, worst first."""
    findings = subject.text_signal("check.findings")
    return _numbered(
        SIGNALS["check.findings"].section,
        "finding",
        findings,
        "Worst first, relative to the limit.",
    )


@needs("solver.broken")
def broken_section(subject: ReportedRun) -> list[Section]:
    """Return the constraints the solver did not satisfy."""
    return _numbered(
        SIGNALS["solver.broken"].section,
        "constraint",
        subject.text_signal("solver.broken"),
        "The most violated constraint of each kind, at the nodes of the solver's last iterate, "
        "and what to relax.",
    )


def _numbered(title: str, what: str, sentences: tuple[str, ...], text: str) -> list[Section]:
    if not sentences:
        return []
    rows = [[str(i), sentence] for i, sentence in enumerate(sentences, 1)]
    return [Section(title, text=text, headers=("", what), rows=rows)]


@needs("solver.history", "solver.stage_names")
def strength_section(subject: ReportedRun) -> Section:
    """Return the required share of each joint's strength."""
    title, record = "Joint strength used", subject.record
    model, limits = record.human.model, record.limits.torque
    rows = []
    for i, name in enumerate(record.human.coordinates):
        own = model.jnt_actfrcrange[i + 1] if model.jnt_actfrclimited[i + 1] else (0.0, 0.0)
        low, high = own if limits is None else limits[:, i]
        if record.qfrc_actuator is None or not np.any([low, high]):
            continue
        torque = record.torque(name)
        used = torque / np.where(torque > 0, max(high, 1e-9), min(low, -1e-9))
        most = int(np.argmax(used))
        rows.append((100 * float(used[most]), name, float(torque[most])))
    if not rows:
        return Section(title, missing="the joints have no torque limits.")
    rows = sorted(rows, reverse=True)[:MAX_JOINTS]
    drawing = bar_plot(
        [place_text(name, side_of(name) or "") for _, name, _ in rows],
        [used for used, _, _ in rows],
        x_label="peak torque [% of the joint's limit in that direction]",
        colours=[STROKES[side_of(name)] for _, name, _ in rows],
        notes=[f"{torque:+.0f} N m".replace("-", "−") for _, _, torque in rows],
        width=720,
    )
    text = "The most heavily loaded joints."
    return Section(title, [Figure(drawing, wide=True)], text=text, folded=True)


@needs("solver.history", "solver.stage_names")
def convergence_section(subject: ReportedRun) -> Section:
    """Return objective, violation and optimality over the iterations of all stages."""
    title = SIGNALS["solver.history"].section
    history = subject.record.signals["solver.history"]
    if not len(history):
        return Section(title, missing="the solver reported no iterations.")
    count = np.arange(float(len(history)))
    starts = [float(np.argmax(history[:, STAGE] == k)) for k in np.unique(history[:, STAGE])[1:]]
    options = {
        "x_label": "iteration",
        "y_label": "[1]",
        "marks": [(start - 0.5, STROKE_MIDDLE) for start in starts],
        "width": 520,
        "height": 260,
    }
    violation = Series(count, history[:, VIOLATION], "violation", STROKE_RIGHT)
    optimality = Series(count, history[:, OPTIMALITY], "optimality", STROKE_LEFT)
    errors = line_plot([violation, optimality], title="Errors", log=MIN_DRAWN, **options)
    series = [Series(count, history[:, OBJECTIVE])]
    objective = line_plot(series, title="Objective", **options)
    missed = (
        "Violation: the most violated constraint, in its own unit (body weights, metres, radians, "
        "100 N m). Optimality: scaled residual of the first-order conditions."
    )
    cost = "Squared torques, accelerations and forces, weighted and integrated over time."
    cost += " Vertical lines: a new stage." if starts else ""
    figures = [Figure(errors, missed), Figure(objective, cost)]
    headers = (
        "stage", "solver", "nodes", "iterations", "ended", "objective", "violation", "of",
    )  # fmt: skip
    return Section(title, figures, headers=headers, rows=_stages(subject), folded=True)


def _stages(subject: ReportedRun) -> list[list[str]]:
    solver, words = subject.record.group("solver"), subject.text_signal
    history, names = solver["history"], words("solver.stage_names")
    solvers = words("solver.stage_solvers", len(names))
    ended = words("solver.stage_status", len(names))
    unknown = np.full(len(names), np.nan)
    nodes = solver.get("stage_nodes", unknown)
    worst = words("solver.history_worst", len(history))
    rows = []
    for k, name in enumerate(names):
        own = np.flatnonzero(history[:, STAGE] == k)
        row = [name, SOLVERS.get(solvers[k], solvers[k]), figure_text(nodes[k])]
        row += [str(max(len(own) - 1, 0)), ended[k]]
        if len(own):
            last = history[own[-1]]
            row += [number_text(last[OBJECTIVE]), power_text(last[VIOLATION])]
            row += [worst[own[-1]].replace("_", " ")]
        rows.append([*row, *[""] * (8 - len(row))])
    return rows

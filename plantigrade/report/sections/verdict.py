"""What the checker says of a motion, what the solver says, and the strength the motion takes."""

import numpy as np

from plantigrade.charts import Figure, Series, bar_plot, line_plot
from plantigrade.charts.labels import side_of
from plantigrade.charts.theme import STROKE_LEFT, STROKE_MIDDLE, STROKE_RIGHT, STROKES
from plantigrade.report.section import Section, Subject, needs
from plantigrade.report.text import figure_text, number_text, place_text, power_text

TINY = 1e-9  # smaller violations are drawn here
MOST = 16  # joints in the table of strength
SOLVERS = {"interior-point": "banded interior point", "ipopt": "IPOPT"}
STAGE, NUMBER, OBJECTIVE, VIOLATION, OPTIMALITY = range(5)
"""Columns of ``solver.history``."""
QUANTITIES = {
    "root_force": "unexplained force on the body, largest",
    "root_force_rms": "unexplained force on the body, RMS",
    "root_moment": "unexplained moment on the body, largest",
    "root_moment_rms": "unexplained moment on the body, RMS",
    "slip": "slip of standing contacts",
    "slip_speed": "slip speed of standing contacts",
    "penetration": "depth below the ground",
    "hover": "height of standing contacts above the ground",
    "friction": "friction, tangential over normal force",
    "adhesion": "pull of the ground",
    "pressure": "centre of pressure outside the support",
    "unsupported": "force where nothing stands",
    "force": "normal force at one contact site",
    "coordinate": "joint beyond its range",
    "velocity": "joint speed",
    "torque": "joint torque",
    "velocity_mismatch": "velocity against rate of position",
    "acceleration_mismatch": "acceleration against rate of velocity",
    "momentum": "rate of momentum against the forces",
    "energy": "rate of energy against joint power",
    "condition": "condition of the task",
}
"""What the checker looks at, in the words of the table; others by their own names."""


@needs("check.quantity", "check.value", "check.limit", "check.bad")
def check_section(subject: Subject) -> Section:
    """Return everything that was checked: worst value, limit, where and when."""
    record, words = subject.record, subject.words
    check = record.group("check")
    n = len(check["quantity"])
    rows = []
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
        judged = np.isfinite(value) and np.isfinite(limit)
        row = [QUANTITIES.get(quantity, quantity.replace("_", " "))]
        row += [figure_text(0.0 if abs(value) < 5e-4 else value), figure_text(limit), unit]
        row += [place_text(where, side), f"{time:.2f} s" if np.isfinite(time) else ""]
        rows.append([*row, ("no" if bad else "yes") if judged or bad else "–"])
    text = (
        "The checker shares nothing with the optimiser: it examines the finished motion in "
        f"{record.motion.n_frames} frames over {record.motion.duration:.2f} s with MuJoCo's "
        "inverse dynamics, and it alone decides whether the run is ok. Forces that no contact "
        "explains must be (nearly) zero, and standing contacts must not slip. Negative values lie "
        "that far on the safe side."
    )
    headers = ("quantity", "worst", "limit", "unit", "where", "when", "ok")
    return Section("Check", text=text, headers=headers, rows=rows)


@needs("check.findings")
def findings_section(subject: Subject) -> list[Section]:
    """Return what the checker found wrong, worst first."""
    findings = subject.words("check.findings")
    return _numbered(
        "What the checker found", "finding", findings, "Worst first, relative to what is allowed."
    )


@needs("solver.broken")
def broken_section(subject: Subject) -> list[Section]:
    """Return the constraints the solver did not satisfy."""
    return _numbered(
        "Constraints the solver did not satisfy",
        "constraint",
        subject.words("solver.broken"),
        "The most violated constraint of each kind, at the nodes of the solver's last iterate, "
        "and what to relax.",
    )


def _numbered(title: str, what: str, sentences: tuple[str, ...], text: str) -> list[Section]:
    if not sentences:
        return []
    rows = [[str(i), sentence] for i, sentence in enumerate(sentences, 1)]
    return [Section(title, text=text, headers=("", what), rows=rows)]


@needs("solver.history", "solver.stage_names")
def strength_section(subject: Subject) -> Section:
    """Return how much of each joint's strength the motion takes."""
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
    rows = sorted(rows, reverse=True)[:MOST]
    drawing = bar_plot(
        [place_text(name, side_of(name) or "") for _, name, _ in rows],
        [used for used, _, _ in rows],
        x_label="largest torque [% of the joint's limit in that direction]",
        colours=[STROKES[side_of(name)] for _, name, _ in rows],
        notes=[f"{torque:+.0f} N m".replace("-", "−") for _, _, torque in rows],
        width=720,
    )
    text = "The most heavily loaded joints."
    return Section(title, [Figure(drawing, wide=True)], text=text, folded=True)


@needs("solver.history", "solver.stage_names")
def convergence_section(subject: Subject) -> Section:
    """Return objective, violation and optimality over the iterations of all stages."""
    title, history = "Convergence", subject.record.signals["solver.history"]
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
    errors = line_plot([violation, optimality], title="Errors", log=TINY, **options)
    series = [Series(count, history[:, OBJECTIVE])]
    objective = line_plot(series, title="Objective", **options)
    missed = (
        "Violation: the most violated constraint, in its own unit (body weights, metres, radians, "
        "100 N m). Optimality: scaled residual of the first-order conditions."
    )
    cost = "Squared torques, accelerations and forces, weighted and integrated over time."
    cost += " Upright lines: a new stage." if starts else ""
    figures = [Figure(errors, missed), Figure(objective, cost)]
    headers = (
        "stage", "solver", "nodes", "iterations", "ended", "objective", "violation", "of",
    )  # fmt: skip
    return Section(title, figures, headers=headers, rows=_stages(subject), folded=True)


def _stages(subject: Subject) -> list[list[str]]:
    solver, words = subject.record.group("solver"), subject.words
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

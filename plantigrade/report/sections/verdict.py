"""The verdict of the checker, and what is wrong if anything is."""

import numpy as np

from plantigrade.report.section import Section, Subject, needs
from plantigrade.report.text import figure_text, place_text

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
        rows.append(
            [
                QUANTITIES.get(quantity, quantity.replace("_", " ")),
                figure_text(0.0 if abs(value) < 5e-4 else value),
                figure_text(limit) if np.isfinite(limit) else "–",
                unit,
                place_text(where, side),
                f"{time:.2f} s" if np.isfinite(time) else "",
                ("no" if bad else "yes") if judged or bad else "–",
            ]
        )
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

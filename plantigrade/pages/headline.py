"""The head of a report: lines on the person, and the figures of its tiles."""

from collections.abc import Sequence

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.pages.section import ReportedRun
from plantigrade.pages.shown import shown_in
from plantigrade.pages.text import rounded_text
from plantigrade.pages.verdict import acted_on_body

FIGURES = {one.key: one for one in shown_in("headline")}
"""Figures of tiles; a unit begins with the space before it."""
GAIT = ("walking_speed_m_s", "running_speed_m_s", "cadence_steps_min")
FIT_ERRORS = ("marker_rms_mean_mm", "joint_rms_mm")
SIMULATION = (
    "speed_m_s", "recorded_speed_m_s", "landings", "tracking_error_rms_deg", "trunk_lean_mean_deg",
    "astray_max_m", "vertical_force_max_bw", "motor_torque_max_pct",
)  # fmt: skip
REPRODUCTION = (
    "rom_error_mean_deg", "rom_error_max_deg", "com_error_max_mm", "contact_drift_max_mm",
    "sole_lowest_mm", "vertical_force_rmse_bw",
)  # fmt: skip
SYNTHESIS = (
    "walking_speed_m_s", "cadence_steps_min", "displacement_m", "duration_s", "flight_rise_m",
    "take_off_speed_m_s", "knee_angle_range_r_deg", "ground_force_max_bw", "cost_of_transport",
)  # fmt: skip


def person_lines(subject: ReportedRun) -> list[str]:
    """Return lines on the person, the model, and the norms of the gait."""
    human, age, figures = subject.record.human, subject.number("age_years"), subject.figures
    name, sex, date = (figures.get(key) for key in ("subject_name", "sex", "recorded_on"))
    known = [f"Subject {name}"] if name else []
    known += [str(sex)] if sex else []
    known += [f"{age:.3g} years"] if age is not None else []
    known += [f"body height {human.height:.2f} m", f"mass {human.mass:.1f} kg"]
    known += [f"recorded on {date}"] if date else []
    known += [f"{6 + len(human.coordinates)} degrees of freedom, {human.feet} feet"]
    who = subject.norm_choice
    if subject.walks and subject.has_norms:
        known += [f"compared with {who.population.name}, {who.reason}"]
    return known


def headline_figures(subject: ReportedRun) -> dict[str, str]:
    """Return names and values of the headline figures."""
    signals = subject.record.signals
    if "check.quantity" in signals:
        verdict = {"verdict": "passed" if subject.run.ok else "failed"}
        found = verdict | _figures_of(subject, SYNTHESIS)
        if "walking speed" in found:
            found.pop("distance", None)
        return found
    if "tasks.names" in signals:
        return _figures_of(subject, REPRODUCTION)
    if subject.run.kind == "simulate":
        return _survival(subject) | _figures_of(subject, SIMULATION)
    found = _figures_of(subject, GAIT) | _both_sides(subject)
    return found | _figures_of(subject, FIT_ERRORS)


def _survival(subject: ReportedRun) -> dict[str, str]:
    """Return the first tiles of a simulation: on the feet or not, and what acted on the body."""
    fell = subject.number("fell_at_s")
    diverged = subject.number("diverged_at_s")
    if fell is not None:
        found = {"fell": f"at {fell:.2f} s"}
    elif diverged is not None:
        found = {"diverged": f"at {diverged:.2f} s"}
    else:
        found = {"on their feet": f"all {subject.record.motion.duration:.1f} s"}
    acted = acted_on_body(subject)
    name = "withstood" if fell is None and diverged is None else "exposed to"
    return found | ({name: ", ".join(acted)} if acted else {})


def _both_sides(subject: ReportedRun) -> dict[str, str]:
    """Return step length, Gait Profile Score and range of the knee, right and left."""
    found, usual = {}, rounded_text(subject.number("gps_reference_deg"), 1)
    for name, unit, key, digits in (
        ("step length, right and left", " m", "step_length_{}_m", 2),
        (f"Gait Profile Score (usual: {usual}°)", "°", "gps_{}_deg", 1),
    ):
        sides = [subject.number(key.format(side)) for side in SIDES]
        if any(value is not None for value in sides):
            found[name] = " / ".join(rounded_text(value, digits) for value in sides) + unit
    ranges = []
    for side in SIDES:
        rows = subject.angle_curves.angles.get(f"knee_angle_{side}", np.empty((0, 1)))
        spans = np.nanmax(rows, axis=1) - np.nanmin(rows, axis=1) if len(rows) else [np.nan]
        ranges.append(rounded_text(float(np.mean(spans)), 0))
    if ranges != ["–", "–"]:
        found["knee range, right and left"] = " / ".join(ranges) + "°"
    return found


def _figures_of(subject: ReportedRun, keys: Sequence[str]) -> dict[str, str]:
    found = {}
    for key in keys:
        one = FIGURES[key]
        if (value := subject.number(key)) is not None:
            found[one.label] = f"{rounded_text(value, one.digits)}{one.unit}"
    return found

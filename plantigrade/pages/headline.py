"""The head of a report: lines on the person, and the figures of its tiles."""

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.pages.section import Subject
from plantigrade.pages.text import rounded_text
from plantigrade.pages.verdict import acted_on_body

Figures = tuple[tuple[str, str, str, int], ...]
"""Name, unit, key and decimals of each figure."""

FIT_FIGURES: Figures = (
    ("walking speed", " m/s", "walking_speed_m_s", 2),
    ("running speed", " m/s", "running_speed_m_s", 2),
    ("cadence", " steps/min", "cadence_steps_min", 0),
    ("RMS marker error", " mm", "marker_rms_mean_mm", 1),
    ("RMS joint centre error", " mm", "joint_rms_mm", 1),
)
SIMULATION_FIGURES: Figures = (
    ("speed", " m/s", "speed_m_s", 2),
    ("speed of the recording", " m/s", "recorded_speed_m_s", 2),
    ("steps", "", "landings", 0),
    ("joint angles off the motion, RMS", "°", "tracking_error_rms_deg", 1),
    ("trunk lean, mean", "°", "trunk_lean_mean_deg", 1),
    ("distance from path, maximum", " m", "astray_max_m", 2),
    ("vertical force, peak", " BW", "vertical_force_max_bw", 2),
    ("joint strength used, peak", " %", "motor_torque_max_pct", 0),
)
REPRODUCTION_FIGURES: Figures = (
    ("range of motion error, mean", "°", "rom_error_mean_deg", 1),
    ("range of motion error, maximum", "°", "rom_error_max_deg", 1),
    ("centre of mass error, maximum", " mm", "com_error_max_mm", 1),
    ("contact drift, maximum", " mm", "contact_drift_max_mm", 1),
    ("lowest point of the soles", " mm", "sole_lowest_mm", 1),
    ("vertical force error, RMS", " BW", "vertical_force_rmse_bw", 3),
)
SYNTHESIS_FIGURES: Figures = (
    ("walking speed", " m/s", "walking_speed_m_s", 2),
    ("cadence", " steps/min", "cadence_steps_min", 0),
    ("distance", " m", "displacement_m", 2),
    ("duration", " s", "duration_s", 2),
    ("rise in flight", " m", "flight_rise_m", 2),
    ("take-off speed", " m/s", "take_off_speed_m_s", 2),
    ("knee range", "°", "knee_angle_range_r_deg", 0),
    ("vertical force, peak", " BW", "ground_force_max_bw", 2),
    ("cost of transport", "", "cost_of_transport", 2),
)


def person_lines(subject: Subject) -> list[str]:
    """Return lines on the person, the model, and the norms of the gait."""
    human, age, figures = subject.record.human, subject.number("age_years"), subject.figures
    name, sex, date = (figures.get(key) for key in ("subject_name", "sex", "recorded_on"))
    known = [f"Subject {name}"] if name else []
    known += [str(sex)] if sex else []
    known += [f"{age:.3g} years"] if age is not None else []
    known += [f"body height {human.height:.2f} m", f"mass {human.mass:.1f} kg"]
    known += [f"recorded on {date}"] if date else []
    known += [f"{human.model.nv} degrees of freedom, {human.feet} feet"]
    who = subject.norm_choice
    if subject.walks and (who.population.own or not subject.runs):
        known += [f"compared with {who.population.name}, {who.reason}"]
    return known


def headline_figures(subject: Subject) -> dict[str, str]:
    """Return names and values of the headline figures."""
    signals = subject.record.signals
    if "check.quantity" in signals:
        verdict = {"verdict": "passed" if subject.run.ok else "failed"}
        found = verdict | _figures_of(subject, SYNTHESIS_FIGURES)
        if "walking speed" in found:
            found.pop("distance", None)
        return found
    if "tasks.names" in signals:
        return _figures_of(subject, REPRODUCTION_FIGURES)
    if subject.run.kind == "simulate":
        return _survival(subject) | _figures_of(subject, SIMULATION_FIGURES)
    found = _figures_of(subject, FIT_FIGURES[:3]) | _both_sides(subject)
    return found | _figures_of(subject, FIT_FIGURES[3:])


def _survival(subject: Subject) -> dict[str, str]:
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


def _both_sides(subject: Subject) -> dict[str, str]:
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


def _figures_of(subject: Subject, figures: Figures) -> dict[str, str]:
    return {
        name: f"{rounded_text(value, digits)}{unit}"
        for name, unit, key, digits in figures
        if (value := subject.number(key)) is not None
    }

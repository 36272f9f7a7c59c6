"""The short figures at the top of a report."""

import numpy as np

from plantigrade.report.subject import Subject

MEASURED = (
    ("walking speed", " m/s", "walking_speed_m_s", 2),
    ("cadence", " steps/min", "cadence_steps_min", 0),
    ("marker error, RMS", " mm", "marker_rms_mean_mm", 1),
    ("joint centre error, RMS", " mm", "joint_rms_mm", 1),
)
FROM_TASKS = (
    ("range of motion error, mean", "°", "rom_error_mean_deg", 1),
    ("range of motion error, largest", "°", "rom_error_max_deg", 1),
    ("centre of mass error, largest", " mm", "com_error_max_mm", 1),
    ("contact drift, largest", " mm", "contact_drift_max_mm", 1),
    ("lowest point of the soles", " mm", "sole_lowest_mm", 1),
    ("time per gait cycle", " s", "time_per_cycle_s", 2),
    ("vertical force error, RMS", " BW", "vertical_force_rmse_bw", 3),
)
SOLVED = (
    ("walking speed", " m/s", "walking_speed_m_s", 2),
    ("cadence", " steps/min", "cadence_steps_min", 0),
    ("distance", " m", "displacement_m", 2),
    ("duration", " s", "duration_s", 2),
    ("rise in flight", " m", "flight_rise_m", 2),
    ("take-off speed", " m/s", "take_off_speed_m_s", 2),
    ("knee range", "°", "knee_angle_range_r_deg", 0),
    ("vertical force, largest", " BW", "ground_force_max_bw", 2),
    ("cost of transport", "", "cost_of_transport", 2),
    ("unexplained force, RMS", " % BW", "check_root_force_rms_bw_percent", 2),
    ("solved in", " s", "solve_time_s", 1),
)


def facts_of(subject: Subject) -> dict[str, str]:
    """Return name and value of what is shown large."""
    signals = subject.record.signals
    if "check.quantity" in signals:
        verdict = {"verdict": "passed" if subject.run.ok else "did not pass"}
        found = verdict | _told(subject, SOLVED)
        if "walking speed" in found:
            found.pop("distance", None)
        return found
    if "tasks.names" in signals:
        return _told(subject, FROM_TASKS)
    return _told(subject, MEASURED) | _knee_ranges(subject)


def _told(subject: Subject, wanted: tuple[tuple[str, str, str, int], ...]) -> dict[str, str]:
    values = {(name, unit, n): subject.number(key) for name, unit, key, n in wanted}
    return {
        name: f"{value:.{digits}f}{unit}".replace("-", "−")
        for (name, unit, digits), value in values.items()
        if value is not None
    }


def _knee_ranges(subject: Subject) -> dict[str, str]:
    found = {}
    for side, word in (("r", "right"), ("l", "left")):
        rows = subject.angle_curves.angles.get(f"knee_angle_{side}", np.empty((0, 1)))
        if len(rows):
            rom = float(np.nanmean(np.nanmax(rows, axis=1) - np.nanmin(rows, axis=1)))
            found[f"{word} knee range"] = f"{rom:.0f}°"
    return found

"""Figures of a movement with its forces, from a Record: distance, work, flight, gait, norms."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.integrate import trapezoid

from plantigrade.analyze.clinical import clinical_figures, norms_for, usual_walk
from plantigrade.analyze.curves import GaitCurves, gait_curves
from plantigrade.analyze.feet import foot_path
from plantigrade.analyze.gait import gait_measures
from plantigrade.analyze.norms import agreement_with_norm, names
from plantigrade.constants import SIDES
from plantigrade.dynamics.centroid import Centroid, centroid
from plantigrade.motion.cycles import cut_cycles
from plantigrade.motion.filters import interpolate, runs
from plantigrade.record import Record
from plantigrade.spatial.conventions import facing

SAGITTAL = ("hip_flexion", "knee_angle", "ankle_angle")
FOOT_PATH_RATE = 200.0  # [Hz] of the feet's paths, resampled to equidistant times

MIN_DISTANCE = 0.3  # [m] above which a walk has a cost of transport


def movement_figures(record: Record, person: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return figures of distance, work and forces, and of a walk its gait measures.

    Keys are flat, in snake_case, with the unit as suffix. The record needs torques and contact
    forces; figures of the ``person`` (``age_years``) determine the norms.
    """
    motion, human = record.motion, record.human
    whole = centroid(human, motion.qpos, motion.qvel)
    com = whole.com
    distance = float(np.linalg.norm(com[-1, :2] - com[0, :2]))
    vertical = sum(record.foot(side).force[:, 2] for side in SIDES) / record.weight
    power = np.stack([record.torque(n) * motion.velocity(n) for n in human.coordinates], axis=1)
    positive = np.maximum(power, 0.0).sum(axis=1)
    given, work = (float(trapezoid(x, motion.time)) for x in (positive, np.abs(power).sum(1)))
    found = {
        "displacement_m": distance,
        "com_lowest_m": float(com[:, 2].min()),
        "com_highest_m": float(com[:, 2].max()),
        "ground_force_max_bw": float(np.max(vertical)),
        "joint_work_positive_j": given,
        "joint_work_absolute_j": work,
        "joint_power_max_w": float(positive.max()),
    }
    for stem in SAGITTAL:
        for side in SIDES:
            name = f"{stem}_{side}"
            found[f"{stem}_range_{side}_deg"] = float(np.ptp(np.rad2deg(motion[name])))
            most = np.abs(record.torque(name)).max() / human.mass
            found[f"{stem}_moment_max_{side}_nm_kg"] = float(most)
    found |= flight_figures(record, whole)
    if motion.events and distance > MIN_DISTANCE:
        found["cost_of_transport"] = work / (record.weight * distance)
        found["cost_of_transport_positive"] = given / (record.weight * distance)
    return found | walk_figures(record, person or {})


def flight_figures(record: Record, whole: Centroid) -> dict[str, float]:
    """Return duration and height of the first flight; nothing without flight."""
    time, planned = record.motion.time, record.contact_planned
    flights = [] if planned is None else runs(np.asarray(~planned.any(axis=1)))
    flight = next((f for f in flights if f.stop - f.start > 1), None)
    if flight is None:
        return {}
    flies = np.arange(flight.start, flight.stop)
    last = max(int(flies[0]) - 1, 0)
    height = whole.com[:, 2]
    return {
        "flight_time_s": float(time[flies[-1]] - time[last]),
        "take_off_speed_m_s": float(whole.com_vel[last, 2]),
        "flight_rise_m": float(height[flies].max() - height[last]),
    }


def walk_figures(record: Record, person: Mapping[str, Any]) -> dict[str, Any]:
    """Return the measures of a walk; nothing for other motions."""
    motion, human = record.motion, record.human
    if not motion.events:
        return {}
    time = np.linspace(
        motion.time[0], motion.time[-1], int(np.ceil(motion.duration * FOOT_PATH_RATE - 1e-9)) + 1
    )
    feet = foot_path(human, motion.qpos)
    heel, toe = (interpolate(time, motion.time, x) for x in (feet.heel, feet.toe))
    direction = walking_direction(record)
    if direction == "backward":  # on toes, which land first
        heel, toe = toe, heel
    found: dict[str, Any] = gait_measures(time, heel, toe, motion.events, overground=True).metrics()
    if direction != "forward":
        found["walking_direction"] = direction
    if direction == "sideways":  # lengths and widths of steps are along the way, feet are across it
        found = {k: v for k, v in found.items() if "step_length" not in k and "step_width" not in k}
    for key in ("treadmill", "belt_speed_m_s", "running"):
        found.pop(key, None)
    if any(c.quantity == "displacement" for c in record.conditions):  # every stride is the same
        found = {k: v for k, v in found.items() if "_sd_" not in k}
    for name in ("thigh", "shank", "ankle_height"):
        found[f"length_{name}_m"] = float(getattr(human.dimensions, name))
    known = {**person, **found}
    curves = gait_curves(record)
    found |= ground_force_figures(record) | clinical_figures(record, known, curves)
    return found | norm_figures(record, known, curves)


def walking_direction(record: Record) -> str:
    """Return where a person walks who covers ground: ``"forward"``, ``"backward"``, ``"sideways"``.

    It is the larger mean of the speed of the pelvis along and across where the pelvis faces; a
    person on a treadmill walks forward.
    """
    qpos, velocity = record.motion.qpos, record.motion.qvel[:, :2]
    ahead = facing(qpos[:, 3:7])
    along = float(np.mean((velocity * ahead).sum(axis=1)))
    across = float(np.mean(velocity[:, 1] * ahead[:, 0] - velocity[:, 0] * ahead[:, 1]))
    if np.hypot(along, across) * record.motion.duration < MIN_DISTANCE:
        return "forward"
    if abs(across) > abs(along):
        return "sideways"
    return "forward" if along > 0 else "backward"


def ground_force_figures(record: Record) -> dict[str, float]:
    """Return both peaks of the vertical force in stance and the trough between them [BW]."""
    t, found = record.motion.time, {}
    for side in SIDES:
        up = record.foot(side).force[:, 2] / record.weight
        rows = []
        for cycle in cut_cycles(record.motion.events, side=side):
            if cycle.toe_off is None:
                continue
            stance = (t >= cycle.start) & (t <= cycle.toe_off)
            share = (t[stance] - cycle.start) / (cycle.toe_off - cycle.start)
            force = up[stance]
            first = int(np.argmax(np.where(share < 0.5, force, -1.0)))
            second = int(np.argmax(np.where(share >= 0.5, force, -1.0)))
            rows.append((force[first], force[first : second + 1].min(), force[second]))
        for k, name in enumerate(("peak_1", "trough", "peak_2") if rows else ()):
            found[f"ground_force_{name}_{side}_bw"] = float(np.mean([row[k] for row in rows]))
    return found


def norm_figures(record: Record, known: Mapping[str, Any], curves: GaitCurves) -> dict[str, float]:
    """Return differences of hip, knee and ankle angles from published means over the cycle.

    The means are those of adults, children or the user's norms.
    """
    choice = norms_for(record, known)
    if (
        "walking_speed_m_s" not in known
        or not usual_walk(known)
        or not set(SAGITTAL) <= set(names(choice.population))
    ):
        return {}
    found, raw, free = {}, [], []
    for name in SAGITTAL:
        rows = curves.angles.get(f"{name}_r", np.empty((0, 1)))
        if not len(rows):
            return {}
        mean = np.nanmean(rows, axis=0)
        held = agreement_with_norm(
            curves.percent, mean, name, choice.speed_class, population=choice.population
        )
        raw.append(held.rmse)
        free.append(held.rmse_offset_removed)
        found[f"norm_rmse_{name}_deg"] = held.rmse
        found[f"norm_correlation_{name}"] = held.correlation
    found["norm_rmse_mean_deg"] = float(np.mean(raw))
    found["norm_rmse_offset_removed_mean_deg"] = float(np.mean(free))
    return found

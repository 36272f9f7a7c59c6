"""Walks from tasks in all planes, compared with norms and published ranges."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from experiments.cached_results import Result
from experiments.plane_figures import load_figures, plane_figures, published
from experiments.table import Grid, Row, at_least, at_most, between
from plantigrade.analyze import norms
from plantigrade.analyze.curves import gait_curves
from plantigrade.analyze.norms import agreement_with_norm
from plantigrade.record import Run

ANGLES = ("pelvis_tilt", "pelvis_list", "pelvis_rotation", "hip_flexion", "hip_adduction")
ANGLES += ("hip_rotation", "knee_angle", "ankle_angle")
LOADS = ("hip_flexion_moment", "hip_adduction_moment", "knee_angle_moment", "ankle_angle_moment")
LOADS += ("hip_flexion_power", "knee_angle_power", "ankle_angle_power")
ANGLES_AT_OPPOSITE_STRIKE = ("pelvis_tilt", "hip_flexion", "knee_angle", "ankle_angle")
"""Angles at the heel strike of the other foot, half way through the cycle."""

ANKLE_MOMENT = (1.5, 0.15)
"""Peak of adults at free speed [N m/kg], and the allowed relative difference."""

GOAL_SPEEDS = (1.0, 1.6)
"""Range of speeds with goals [m/s]."""

ARM_SWING_SPEED = 0.8
"""Speed from which arms swing once per stride, opposite to the legs [m/s]."""


def planes_of(run: Run, speed: float, kind: str) -> dict[str, Any]:
    """Return figures of all planes, agreement of curves with norms, and published ranges.

    Args:
        run: A periodic walk.
        speed: Its speed [m/s].
        kind: Class of speed of children's norms.
    """
    curves, record = gait_curves(run.record), run.record
    means = {n: np.nanmean(x, axis=0) for n, x in curves.angles.items() if len(x)}
    loads = {n: np.nanmean(x, axis=0) for n, x in curves.loads().items() if len(x)}
    agreement, within = {}, {}
    for name in (*ANGLES, *LOADS):
        own = means.get(name, means.get(f"{name}_r", loads.get(f"{name}_r")))
        if own is None:
            continue
        held = agreement_with_norm(curves.percent, own, name, kind)
        agreement[name] = {"rmse": held.rmse, "r": held.correlation}
        if name in ANGLES:
            band = norms.norm(name, population=norms.ADULTS)
            mean, sd = (np.interp(curves.percent, band.percent, x) for x in (band.mean, band.sd))
            within[name] = float(100.0 * np.mean(np.abs(own - mean) <= sd))
    cadence = float(run.figures["cadence_steps_min"])
    own_steps = {"step_length": 60.0 * speed / cadence, "cadence": cadence}
    steps = {n: (mean - sd, mean + sd) for n, (mean, sd) in norms.adult_steps(speed).items()}
    opposite = {}
    for name in ANGLES_AT_OPPOSITE_STRIKE:
        band = norms.norm(name, population=norms.ADULTS)
        own = means[name if name in means else f"{name}_r"]
        pairs = ((curves.percent, own), (band.percent, band.mean), (band.percent, band.sd))
        opposite[name] = [float(np.interp(50.0, *pair)) for pair in pairs]
    return {
        "figures": plane_figures(record) | load_figures(curves) | own_steps,
        "usual": {n: list(x) for n, x in (published(record.human, speed) | steps).items()},
        "at_opposite_strike": opposite,
        "agreement": agreement,
        "within_sd_adults_percent": within,
    }


COLUMNS = (
    ("trunk lean ± deg", "trunk_lean_deg", "{:.1f}"),
    ("head lean ± deg", "head_lean_deg", "{:.1f}"),
    ("pelvis list ± deg", "pelvis_lean_deg", "{:.1f}"),
    ("pelvis turn ± deg", "pelvis_rotation_deg", "{:.1f}"),
    ("trunk turn ± deg", "trunk_rotation_deg", "{:.1f}"),
    ("pelvis to trunk deg", "pelvis_trunk_phase_deg", "{:.0f}"),
    ("arm swing deg", "arm_swing_deg", "{:.0f}"),
    ("arm to leg deg", "arm_phase_deg", "{:.0f}"),
    ("elbow deg", "elbow_range_deg", "{:.0f}"),
    ("CoM up mm", "com_up_down_mm", "{:.0f}"),
    ("CoM side mm", "com_sideways_mm", "{:.0f}"),
    ("friction", "friction_used", "{:.2f}"),
    ("toe-out deg", "foot_progression_out_deg", "{:.1f}"),
    ("L front", "angular_momentum_frontal", "{:.3f}"),
    ("L side", "angular_momentum_sagittal", "{:.3f}"),
    ("L up", "angular_momentum_vertical", "{:.3f}"),
    ("step m", "step_length", "{:.2f}"),
    ("steps/min", "cadence", "{:.0f}"),
)
LOAD_FIGURES = (
    ("hip early", "hip_extensor_early_nm_kg", "{:.2f}"),
    ("hip late swing", "hip_extensor_late_swing_nm_kg", "{:.2f}"),
    ("hip abductor", "hip_abductor_nm_kg", "{:.2f}"),
    ("knee early", "knee_extensor_early_nm_kg", "{:.2f}"),
    ("ankle", "ankle_plantarflexor_nm_kg", "{:.2f}"),
    ("hip W/kg", "hip_power_max_w_kg", "{:.2f}"),
    ("knee W/kg", "knee_power_min_w_kg", "{:.2f}"),
    ("ankle W/kg", "ankle_power_max_w_kg", "{:.2f}"),
    ("braking BW", "ground_force_braking_bw", "{:.2f}"),
    ("pushing BW", "ground_force_pushing_bw", "{:.2f}"),
    ("inward BW", "ground_force_inward_bw", "{:.3f}"),
)


def plane_grids(results: Mapping[str, Result]) -> tuple[Grid, ...]:
    """Return figures of all planes, what joints bear, and how near curves are to norms."""
    there = {key: r["planes"] for key, r in results.items() if "planes" in r}
    grids = []
    for title, shown in (
        ("All planes", COLUMNS),
        ("Moments [N m/kg], powers, forces", LOAD_FIGURES),
    ):
        lines = []
        for key, p in there.items():
            lines.append([key, *(_cell(p["figures"], name, form) for _, name, form in shown)])
            known = [p["usual"].get(name) for _, name, _ in shown]
            if any(known):
                words = ("" if x is None else f"{x[0]:.3g}–{x[1]:.3g}" for x in known)
                lines.append(["  people", *words])
        grids.append(Grid(title, ("", *(name for name, _, _ in shown)), lines))
    near = [
        [key, *(_cell(p["agreement"].get(n, {}), "r", "{:.2f}") for n in (*ANGLES, *LOADS))]
        for key, p in there.items()
    ]
    header = ("", *(n.replace("_", " ") for n in (*ANGLES, *LOADS)))
    grids.append(Grid("Correlation with children's norms of the speed class", header, near))
    inside = [
        [key, *(_cell(p["within_sd_adults_percent"], n, "{:.0f}") for n in ANGLES)]
        for key, p in there.items()
    ]
    struck = [
        [key, *("{:.0f} ({:.0f} ± {:.0f})".format(*x) for x in p["at_opposite_strike"].values())]
        for key, p in there.items()
    ]
    title = "As the other foot strikes (adults at comfortable speed) [deg]"
    grids.append(
        Grid(title, ("", *(n.replace("_", " ") for n in ANGLES_AT_OPPOSITE_STRIKE)), struck)
    )
    title = "Part of the cycle within one SD of adults at comfortable speed [%]"
    grids.append(Grid(title, header[: 1 + len(ANGLES)], inside))
    return tuple(grids)


def plane_rows(key: str, planes: Mapping[str, Any], speed: float) -> Iterator[Row]:
    """Return what a walk is held against in all planes."""
    figures, usual, near = planes["figures"], planes["usual"], planes["agreement"]
    if speed >= ARM_SWING_SPEED and "arm_swing_deg" in figures:
        yield between(key, "arm against leg", figures["arm_phase_deg"], 150.0, 210.0, "deg")
        low, high = usual["arm_swing_deg"]
        yield between(key, "arm swing", figures["arm_swing_deg"], low, high, "deg")
    if not GOAL_SPEEDS[0] <= speed <= GOAL_SPEEDS[1]:
        return
    yield at_most(key, "trunk lean, either way", figures["trunk_lean_deg"], 3.0, "deg")
    yield at_most(key, "head lean, either way", figures["head_lean_deg"], 2.0, "deg")
    yield at_least(key, "pelvis_rotation r", near["pelvis_rotation"]["r"], 0.8)
    yield at_least(key, "hip_adduction r", near["hip_adduction"]["r"], 0.85)
    people = float(np.mean(usual["com_up_down_mm"]))
    up = figures["com_up_down_mm"]
    yield between(key, "centre of mass up and down", up, 0.75 * people, 1.25 * people, "mm")
    yield at_most(key, "friction used", figures["friction_used"], 0.35)
    mean, part = ANKLE_MOMENT
    ankle = figures["ankle_plantarflexor_nm_kg"]
    low, high = mean * (1 - part), mean * (1 + part)
    yield between(key, "ankle moment", ankle, low, high, "N m/kg")
    early, late = (figures[f"hip_extensor_{n}_nm_kg"] for n in ("early", "late_swing"))
    yield at_least(key, "hip extensors, early stance over late swing", early / late, 1.0)
    inside = float(np.mean(list(planes["within_sd_adults_percent"].values())))
    yield at_least(key, "cycle within one SD of adults, mean of angles", inside, 90.0, "%")


def growth_row(results: Mapping[str, Result]) -> Iterator[Row]:
    """Return whether the centre of mass goes up and down the more, the faster the walk.

    Nothing where walks were made at fewer than two of the speeds that are judged.
    """
    up = {
        float(r["options"]["speed"]): r["planes"]["figures"]["com_up_down_mm"]
        for key, r in results.items()
        if key.startswith("speeds/") and "planes" in r
    }
    there = [up[v] for v in sorted(up) if GOAL_SPEEDS[0] <= v <= GOAL_SPEEDS[1]]
    if len(there) > 1:
        least = float(np.diff(there).min())
        quantity = "centre of mass up and down, growth from speed to speed"
        yield at_least("all speeds", quantity, least, 0.0, "mm")


def _cell(table: Mapping[str, float], name: str, form: str) -> str:
    return form.format(table[name]) if name in table else "-"

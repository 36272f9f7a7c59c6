"""Measures of a walk that tell how much it resembles a person's, of recordings and simulations."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from experiments.gait_shape import humps_of
from plantigrade.analyze.curves import gait_curves
from plantigrade.analyze.feet import foot_path
from plantigrade.analyze.gait import gait_measures
from plantigrade.analyze.norms import ADULTS, NormCurve, norm
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.dynamics.centroid import centroid
from plantigrade.kinematics.posture import leans
from plantigrade.motion.cycles import PERCENT
from plantigrade.motion.filters import lowpass
from plantigrade.record import Record

MOMENT_CUTOFF = 6.0  # [Hz] as in the analysis of recordings
JOINTS = {"ankle": "ankle_angle", "knee": "knee_angle", "hip": "hip_flexion"}
"""Joint → its coordinate."""
PEAKS = ("first_peak", "trough", "second_peak")
"""Extremes of the vertical force of a foot in stance."""
DIFFERENCE_MEASURES = (
    *("knee_at_strike", "least_knee", "com_height", "trunk", "head"),
    *("trunk_range", "head_range", "double_support", "step_width"),
)
"""Measures of which the difference counts."""
DOUBLE_SUPPORT_SD = 3.0  # [% of the cycle] of children at a free speed
FIRST_HALF = 50  # [% of the cycle] the first peak of the force is before it

Measures = dict[str, float | Sequence[float]]


def measures(record: Record, *, since: float = 0.0, force_cutoff: float | None = None) -> Measures:
    """Return measures of the gait cycles of a walk; curves are means over cycles and sides.

    Args:
        record: The walk, with gait events and forces.
        since: Cycles count from this time on [s].
        force_cutoff: Cut-off of forces [Hz] of a simulation, whose moments are filtered at
            :data:`MOMENT_CUTOFF`; None for a recording, which is filtered already.

    Returns:
        ``first_peak``, ``trough``, ``second_peak``, ``raw_peak`` [BW]; ``ankle``, ``knee``, ``hip``
        moments over the cycle [N m/kg]; ``knee_at_strike``, ``least_knee`` [deg]; ``com_height``,
        ``com_excursion``, ``step_width`` [m]; ``trunk``, ``head`` leaning forward, on
        average and their ``…_range`` in a cycle [deg];
        ``double_support`` [% of the cycle]. Unknown ones are NaN.
    """
    human, motion = record.human, record.motion
    events = tuple(e for e in motion.events if e.time >= since)
    record = replace(record, motion=replace(motion, events=events))
    inside = (motion.time >= events[0].time) & (motion.time <= events[-1].time)
    found: Measures = dict(vertical_force(record, force_cutoff))
    found["raw_peak"] = max(float(record.foot(s).force[inside, 2].max()) for s in SIDES)
    found["raw_peak"] /= record.weight
    smoothed = record if force_cutoff is None else _filtered(record, MOMENT_CUTOFF)
    curves = gait_curves(smoothed, estimated=True)
    for joint, coordinate in JOINTS.items():
        found[joint] = _mean_curve(curves.moments, coordinate).tolist()
    found["least_knee"] = float(
        min(np.rad2deg(motion[f"{JOINTS['knee']}_{side}"][inside]).min() for side in SIDES)
    )
    found["knee_at_strike"] = float(_mean_curve(curves.angles, JOINTS["knee"])[0])
    height = centroid(human, motion.qpos, motion.qvel).com[:, 2] - record.ground.height
    cycles = [(motion.time >= c.start) & (motion.time < c.stop) for c in curves.cycles]
    found["com_height"] = float(np.mean([height[cycle].mean() for cycle in cycles]))
    found["com_excursion"] = float(np.median([np.ptp(height[cycle]) for cycle in cycles]))
    for name, landmark in (("trunk", "c7"), ("head", "vertex")):
        ahead = leans(human, motion.qpos, landmark)[:, 0]
        found[name] = float(np.mean([ahead[cycle].mean() for cycle in cycles]))
        found[f"{name}_range"] = float(np.median([np.ptp(ahead[cycle]) for cycle in cycles]))
    feet = foot_path(human, motion.qpos)
    steps = gait_measures(motion.time, feet.heel, feet.toe, events)
    found["double_support"] = steps.double_support.mean
    found["step_width"] = steps.step_width.mean
    return found


def vertical_force(record: Record, cutoff: float | None = None) -> dict[str, float]:
    """Return the extremes of the vertical force of a foot in stance: medians of its stances [BW].

    Args:
        record: The walk, with gait events.
        cutoff: Cut-off at which the force is filtered [Hz]; None for no filter.
    """
    if cutoff is not None:
        record = _filtered(record, cutoff)
    curves, humps = gait_curves(record, estimated=True), []
    for side in SIDES:
        offs = [c.percent(c.toe_off) for c in curves.cycles if c.side == side and c.toe_off]
        for row in curves.forces.get(f"up_{side}", ()):
            if np.isfinite(row).all() and offs:
                humps.append(humps_of(curves.percent, row, float(np.mean(offs))))
    if not humps:
        return dict.fromkeys(PEAKS, float("nan"))
    found = np.median([[h.first, h.trough, h.second] for h in humps], axis=0)
    return dict(zip(PEAKS, found.tolist(), strict=True))


def differences(own: Mapping, recorded: Mapping) -> dict[str, float]:
    """Return how a walk differs from the recorded one.

    Args:
        own: Its measures.
        recorded: Those of the recording.

    Returns:
        ``…_ratio`` of forces, peak moments and excursion; ``…_r`` of moments; differences of the
        other measures, in their units; ``…_sd``, differences in percent of people's SD.
    """
    found: dict[str, float] = {}
    for name in (*PEAKS, "com_excursion"):
        found[f"{name}_ratio"] = own[name] / recorded[name]
    for name in DIFFERENCE_MEASURES:
        found[name] = own[name] - recorded[name]
    found["raw_peak"] = own["raw_peak"]
    force, knee = norm("vertical_grf"), norm(JOINTS["knee"], population=ADULTS)
    for name in PEAKS:
        sd = _sd_of_peak(force, name)
        found[f"{name}_sd"] = 100.0 * abs(own[name] - recorded[name]) / sd
    found["knee_at_strike_sd"] = 100.0 * abs(found["knee_at_strike"]) / float(knee.sd[0])
    found["double_support_sd"] = 100.0 * abs(found["double_support"]) / DOUBLE_SUPPORT_SD
    for joint, coordinate in JOINTS.items():
        mine, theirs = (np.array(each[joint], dtype=float) for each in (own, recorded))
        k = int(np.nanargmax(np.abs(theirs))) if np.isfinite(theirs).any() else 0
        sign = np.sign(theirs[k])
        peak = float(np.max(sign * mine))
        found[f"{joint}_moment_r"] = float(np.corrcoef(mine, theirs)[0, 1])
        found[f"{joint}_moment_peak_ratio"] = peak / float(abs(theirs[k]))
        published = norm(f"{coordinate}_moment")
        sd = float(np.interp(k, published.percent, published.sd))
        found[f"{joint}_moment_sd"] = 100.0 * abs(peak - float(abs(theirs[k]))) / sd
    return found


def _sd_of_peak(curve: NormCurve, name: str) -> float:
    """Return people's SD of the vertical force where their mean has an extreme [BW]."""
    first = int(np.argmax(np.where(curve.percent < FIRST_HALF / 2, curve.mean, 0.0)))
    second = int(np.argmax(np.where(curve.percent > FIRST_HALF / 2, curve.mean, 0.0)))
    trough = first + int(np.argmin(curve.mean[first : second + 1]))
    return float(curve.sd[(first, trough, second)[PEAKS.index(name)]])


def _mean_curve(table: Mapping[str, Array], name: str) -> Float[Array, " n_percent"]:
    """Return the mean of a curve over the cycles of both sides; NaN without one."""
    rows = [row for side in SIDES for row in table.get(f"{name}_{side}", ())]
    return np.nanmean(rows, axis=0) if rows else np.full(len(PERCENT), np.nan)


def _filtered(record: Record, cutoff: float) -> Record:
    """Return a record with filtered forces and torques."""
    time = record.motion.time
    changed = {
        name: lowpass(time, values, cutoff=cutoff)
        for name in ("contact_force", "qfrc_actuator")
        if (values := getattr(record, name)) is not None
    }
    return replace(record, **changed)

"""Accuracy of fits: agreement with markers, OpenSim, Plug-in Gait and force plates.

Every trial of the data folder with markers is fitted with its file name alone; its angles in all
planes, moments and events are compared with those of other software and of the plates. The people
of the calibration set (:data:`SETTLING_PEOPLE`), on whom constants of the fit were chosen, have a
table of their own; the other one is the validation set.
"""

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.event_agreement import event_rows, event_sheet
from experiments.joint_centres import (
    COLUMNS,
    centre_rows,
    opensim_centres,
    plug_in_gait_centres,
)
from experiments.knee_axis import COLUMNS as KNEE_AXIS
from experiments.knee_axis import knee_axis_rows
from experiments.stored_angles import (
    Agreement,
    against_opensim,
    against_plug_in_gait,
    agreement_sheet,
    on_clock,
    shared,
)
from experiments.table import (
    ResultTable,
    Row,
    at_least,
    at_most,
    between,
    over_trials,
    sheets_of,
    within,
)
from plantigrade.analyze.statistics import compare_curves
from plantigrade.analyze.trial import CUTOFF, SIDES, Trial
from plantigrade.io import read
from plantigrade.io.mot import read_table
from plantigrade.kinematics.inverse import InverseKinematics
from plantigrade.kinematics.state import PointSet
from plantigrade.motion import Recording, Table
from plantigrade.motion.filters import lowpass
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import FitSettings

LEGS = ("hip_flexion", "knee_angle", "ankle_angle")
MAX_MOMENT_ROUGHNESS = 0.6
"""Roughness of the worst stored moment above which none of a file is compared [1]."""

NOTES = (
    "",
    "How to read it: stored Plug-in Gait moments are low-passed like ours before they are compared "
    "(unfiltered, r of the hip and knee is 0.02 to 0.1 lower); where a file's own are mostly noise "
    "they are shown without a goal. gait2392's solution has its toes locked, so rigid feet are "
    "held against it and the default feet are shown beside. Plate events count only where the "
    "force rises or falls cleanly under one foot alone.",
    "Angles of one rotation differ by a constant where the axes of the segments do, so RMSE stands "
    "beside RMSE without the mean difference. OpenSim's knees are hinges like ours; Plug-in Gait's "
    "turn freely, so hip_rotation (what thigh, shank and foot agree on) stands beside "
    "hip_rotation_thigh (what the thigh's markers show, Plug-in Gait's way). ankle_dorsiflexion is "
    "its ankle angle (shank to metatarsal head), ankle_angle the coordinate of a rigid foot. Its "
    "hip joint centre is another: with that of Harrington its adduction would be 1 to 2 deg more, "
    "and (stored with the standing trials) hip and knee of HC032 3.3 and 2.5 deg more flexed, hips "
    "of HC038 up to 0.7 deg less and knees 1.4 more. In gaitalytics its knee centres lie 35 and "
    "21 mm ahead of the middle between the epicondyles' markers: 9 and 6 deg of knee flexion.",
    "Ours less theirs by joint centres: change of our knee flexion if a centre of the reference "
    "takes the place of ours alone, or all three do, and our zero against the straight leg. "
    "Plug-in Gait's knees are more extended than ours, OpenSim's more flexed, because their knee "
    "centres lie behind and ahead of ours; the epicondyle's marker is 4 mm behind ours in HC038, "
    "13 and 18 mm in HC032, 6 mm behind and 6 ahead in Rajagopal's walk, and 19 and 13 mm behind "
    "OpenSim's knee there.",
    "Knee axis: adduction of the knee that correlates with its flexion (cross-talk) shows a turned "
    "axis. With the axis turned until adduction varies least (Baker 1999), the offset of hip "
    "rotation is gone; its r hardly changes, because one thigh marker determines it. Its knee "
    "centre moves, too: in gaitalytics 6 deg of difference in knee flexion become 1 to 3. There "
    "both epicondyles were recorded, and they are the reference: in stance with an almost straight "
    "knee they turn as the shank does, the thigh marker does not.",
)
# Motions of other skeletons; those in which somebody walks become rows.
SKELETONS = ("cmu_asfamc/*.amc", "cmu_bvh/*.bvh", "deepmimic/*.txt")
# Walking trials with markers; those OpenSim solved too, with its angles, its moments and the feet
# its model has.
WALKS = (
    "c3d/HC038A11.c3d",
    "c3d/HC038A27.c3d",
    "c3d/HC032A03.c3d",
    "c3d/opensim_walking2.c3d",
    "c3d/gaitalytics_treadmill_events.c3d",
    "opensim/rajagopal_walk/markers_walk.trc",
    "opensim/gait2392_subject01/subject01_walk1.trc",
)
# Other movements with markers: their angles, where OpenSim solved them, and their marker error.
MOVEMENTS = (
    "opensim/opencap_subject4/squats1.trc",
    "opensim/opencap_subject4/STS1.trc",
    "opensim/opencap_subject4/DJ1.trc",
    "opensim/running_subject04/run200.trc",
    "opensim/running_subject04/run300.trc",
)
COM_AHEAD = "centre of mass ahead of the forces"
OVERVIEW = (
    *("marker RMS, mean", "joint centre RMS", COM_AHEAD, "lumbar joint behind the hips"),
    *("trunk, forward lean, mean", "arm joint at its stop, most"),
    *("inverse kinematics, median", "read, fit and analyse"),
)
"""Figures of the table over all trials."""
SETTLING_PEOPLE = ("HC032", "opensim_walking2", "gait2392_subject01", "opencap_subject4")
"""People on whose recordings constants of the fit were settled, as parts of the trials' names."""
# One of each kind: Plug-in Gait's outputs, OpenSim's angles and moments, each sort of skeleton.
QUICK_TRIALS = (
    "c3d/HC032A03.c3d",
    "opensim/rajagopal_walk/markers_walk.trc",
    "opensim/gait2392_subject01/subject01_walk1.trc",
    "cmu_asfamc/16_21.amc",
    "cmu_bvh/07_01.bvh",
    "deepmimic/humanoid3d_walk.txt",
)
# The gait2392 solution has its toes and subtalar joints locked: it is held against rigid feet.
OPENSIM = {
    WALKS[-2]: ("coordinates.sto", "id_walk.sto", None),
    WALKS[-1]: ("std_subject01_walk1_ik.mot", None, "rigid"),
    **{name: (f"{Path(name).stem}_ik.mot", None, None) for name in MOVEMENTS[:3]},
}
# The models of these solutions, for their joint centres.
OPENSIM_MODELS = {
    WALKS[-2]: "subject_walk_scaled.osim",
    MOVEMENTS[0]: "optimized_scale_and_markers.osim",
}
# Our coordinate → Plug-in Gait's moment, and the sign between them.
PLUG_IN_GAIT = {
    "hip_flexion": ("HipMoment", -1),
    "knee_angle": ("KneeMoment", -1),
    "ankle_angle": ("AnkleMoment", -1),
}


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over every walking trial in a data folder."""
    title = "Accuracy of fits, each called with its file name alone"
    others = [p.relative_to(data).as_posix() for s in SKELETONS for p in sorted(data.glob(s))]
    names = QUICK_TRIALS if quick else (*WALKS, *MOVEMENTS, *others)
    with_markers = {*WALKS, *MOVEMENTS}

    def rows(path: Path, name: str) -> list[Row]:
        return trial_rows(path, name) if name in with_markers else skeleton_rows(path, name)

    table = over_trials(title, data, names, rows, say=say, notes=NOTES)
    settled = [row for row in table.rows if any(who in row.subject for who in SETTLING_PEOPLE)]
    rest = [row for row in table.rows if row not in settled]
    means = [
        *com_mean("people on whom constants were settled", settled),
        *com_mean("other people", rest),
    ]
    sheets = [
        *sheets_of("All trials", table.rows, OVERVIEW),
        agreement_sheet("Angles of people on whom constants were settled", settled),
        agreement_sheet("Angles of other people", rest),
        *sheets_of("Knee: ours less theirs by joint centres", table.rows, COLUMNS),
        *knee_axis_sheets("of people on whom constants were settled", settled),
        *knee_axis_sheets("of other people", rest),
        event_sheet("Events of people on whom constants were settled", settled),
        event_sheet("Events of other people", rest),
    ]
    return replace(table, rows=[*table.rows, *means], sheets=sheets)


def knee_axis_sheets(who: str, rows: Iterable[Row]) -> list[str]:
    """Return hip rotation against Plug-in Gait and corrected, with the cross-talk of its axis."""
    return sheets_of(f"Knee axis and hip rotation {who}", rows, tuple(KNEE_AXIS.values()))


def com_mean(who: str, rows: Iterable[Row]) -> list[Row]:
    """Return the mean distance of the centre of mass ahead of the forces over the walks."""
    ahead = [r.value for r in rows if r.quantity == COM_AHEAD and r.subject in WALKS]
    mean = float(np.mean([v for v in ahead if v is not None])) if ahead else None
    return [] if mean is None else [between(who, f"{COM_AHEAD}, mean", mean, -10, 10, "mm")]


def trial_rows(path: Path, name: str) -> list[Row]:
    """Return all rows of one trial."""
    started = time.perf_counter()
    recording, trial = fit_trial(path)
    seconds = time.perf_counter() - started
    rows = [
        at_most(name, "marker RMS, mean", trial.fit.metrics["marker_rms_mean_mm"], 10, "mm"),
        at_most(name, "inverse kinematics, median", frame_time_ms(trial), 1.0, "ms/frame"),
        Row(name, "read, fit and analyse", seconds, "s"),
    ]
    rows += posture_rows(name, trial.fit.metrics)
    ahead = trial.figures.get("com_ahead_mm")
    if ahead is not None:
        rows.append(Row(name, COM_AHEAD, ahead, "mm"))
    if name in WALKS or trial.measures.running:
        rows += event_rows(name, trial, recording)
    if name in OPENSIM:
        angles, moments, feet = OPENSIM[name]
        theirs = read(path.parent / angles).coordinates
        assert theirs is not None
        found = list(against_opensim(trial, theirs))
        if feet is None:
            rows += angle_rows(name, found)
        else:  # other feet than theirs: shown, without a goal
            same = fit_trial(path, FitSettings(feet=feet))[1]
            rows += angle_rows(name, found, goals=False)
            note = f" with {feet} feet as there"
            rows += angle_rows(name, against_opensim(same, theirs), note)
        if moments is not None:
            rows += opensim_moment_rows(name, trial, path.parent / moments)
    if name in OPENSIM_MODELS:
        model, angles = (path.parent / each for each in (OPENSIM_MODELS[name], OPENSIM[name][0]))
        rows += centre_rows(name, trial, opensim_centres(trial, model, angles))
    if recording.outputs:
        centres = plug_in_gait_centres(trial, recording)
        rows += centre_rows(name, trial, centres)
        rows += (axis := knee_axis_rows(name, trial, centres))
        # Where the file has medial epicondyles, these are the reference of hip rotation.
        free = any(row.quantity == KNEE_AXIS["epicondyles"] for row in axis)
        for each in against_plug_in_gait(trial, recording):
            rows += each.rows(
                name, goals=not (free and each.angle.startswith("hip_rotation_thigh"))
            )
        rows += plug_in_gait_moment_rows(name, trial, recording)
    return rows


def posture_rows(name: str, figures: Mapping[str, float]) -> list[Row]:
    """Return the posture: lumbar joint, trunk, head, arms; nothing of assumed parts."""
    behind = figures["lumbar_behind_hips_mm"]
    row = at_most(name, "", abs(behind - 45), 25)
    rows = [Row(name, "lumbar joint behind the hips", behind, "mm", "20 to 70 mm", row.met)]
    for part, key in (("trunk", "trunk_lean_mean_deg"), ("head", "neck_lean_mean_deg")):
        if key in figures:
            rows.append(Row(name, f"{part}, forward lean, mean", figures[key], "deg"))
    if (stop := figures.get("arms_at_stop_pct")) is not None:
        rows.append(at_most(name, "arm joint at its stop, most", stop, 5, "%"))
    if (standing := figures.get("trunk_lean_standing_deg")) is not None:
        rows.append(within(name, "trunk, forward lean, standing", standing, 8, "deg"))
    return rows


def angle_rows(
    name: str, found: Iterable[Agreement], note: str = "", *, goals: bool = True
) -> list[Row]:
    """Return the figures of all angles of a trial."""
    return [row for each in found for row in each.rows(name, note, goals=goals)]


def skeleton_rows(path: Path, name: str) -> list[Row]:
    """Return the rows of a retargeted skeleton; none if nobody walks in it."""
    started = time.perf_counter()
    trial = fit_trial(path)[1]
    seconds = time.perf_counter() - started
    if len(trial.cycles) < 2:
        return []
    figures = trial.fit.metrics
    return [
        Row(name, "joint centre RMS", figures["joint_rms_mm"], "mm"),
        at_most(name, "foot drift in stance, mean", figures["foot_drift_mean_mm"], 5, "mm"),
        at_most(name, "feet below the ground, most", figures["penetration_max_mm"], 5, "mm"),
        Row(name, "knee range, right", _range(trial, "knee_angle_r"), "deg"),
        Row(name, "knee range, left", _range(trial, "knee_angle_l"), "deg"),
        Row(name, "read, fit and analyse", seconds, "s"),
    ]


def _range(trial: Trial, coordinate: str) -> float:
    return float(np.rad2deg(np.ptp(trial.motion[coordinate])))


def frame_time_ms(trial: Trial) -> float:
    """Return the median time of inverse kinematics per frame, warm-started [ms]."""
    fit = trial.fit
    assert fit.markers is not None
    points = PointSet(
        fit.human, [p.body for p in fit.places], np.array([p.position for p in fit.places])
    )
    solver = InverseKinematics(points)
    spent = []
    qpos = fit.qpos[0]
    for measured in fit.markers.positions:
        begin = time.perf_counter()
        qpos = solver.solve(measured, qpos).qpos
        spent.append(time.perf_counter() - begin)
    return 1e3 * float(np.median(spent))


def opensim_moment_rows(name: str, trial: Trial, moments: Path) -> list[Row]:
    """Compare moments with OpenSim's."""
    rows: list[Row] = []
    if trial.moments is None or trial.forces is None:
        return rows
    table = read_table(moments)
    for column in (f"{joint}_{side}" for joint in LEGS for side in SIDES):
        i = 6 + trial.fit.human.hinge(column)
        known = np.asarray(trial.forces.valid_side)[:, trial.forces.sides.index(column[-1])]
        tau = np.where(known, trial.moments.tau[:, i], np.nan)
        mine = Table((column,), trial.fit.time, tau[:, None])
        their = Table((column,), table.time, table[f"{column}_moment"][:, None])
        a, b = shared(mine, their, column)
        ok = np.isfinite(a)
        a, b = a[ok], b[ok]
        peak = np.abs(b).argmax()
        near = np.abs(np.arange(len(b)) - peak) < 0.1 / np.median(np.diff(table.time))
        ours_peak = a[near][np.abs(a[near]).argmax()]
        off = 100 * abs(abs(ours_peak) - abs(b[peak])) / abs(b[peak])
        label = f"{column} moment against OpenSim"
        rows.append(at_least(name, f"{label}, r", compare_curves(a, b).correlation, 0.97))
        rows.append(at_most(name, f"{label}, peak", off, 10, "%"))
    return rows


def plug_in_gait_moment_rows(name: str, trial: Trial, recording: Recording) -> list[Row]:
    """Compare sagittal moments with Plug-in Gait's, stored in the file."""
    rows: list[Row] = []
    fit, markers = trial.fit, recording.markers
    if markers is None or trial.moments is None or trial.forces is None:
        return rows
    clock = markers.time
    keys = {side.upper() + moment for moment, _ in PLUG_IN_GAIT.values() for side in SIDES}
    noisy = any(
        roughness(recording.outputs[k][:, 0]) > MAX_MOMENT_ROUGHNESS
        for k in keys & {*recording.outputs}
    )
    for joint, (moment, sign) in PLUG_IN_GAIT.items():
        for side in SIDES:
            column = f"{joint}_{side}"
            stored = recording.outputs.get(side.upper() + moment)
            if stored is None:
                continue
            k = trial.forces.sides.index(side)
            loaded = np.asarray(trial.forces.valid_side)[:, k] & (trial.forces.force[:, k, 2] > 20)
            # Plug-in Gait stores moments of unfiltered motion: both in the same band.
            theirs = lowpass(clock, stored[:, 0], cutoff=CUTOFF)
            theirs = on_clock(clock, theirs, fit.time)
            mine = trial.moments.tau[:, 6 + fit.human.hinge(column)]
            ok = loaded & np.isfinite(theirs) & (theirs != 0)
            if ok.sum() > 20:
                r = sign * compare_curves(mine[ok], theirs[ok]).correlation
                row = at_least(name, f"{column} moment against Plug-in Gait, r", r, 0.95)
                if noisy:
                    row = replace(row, goal="", met=None, note="theirs is mostly noise")
                rows.append(row)
    return rows


def roughness(values: np.ndarray) -> float:
    """Return the noise of a curve: standard deviation of second differences over its own."""
    x = values[np.isfinite(values)]
    return float(np.std(np.diff(x, 2)) / np.std(x)) if len(x) > 10 else float("nan")

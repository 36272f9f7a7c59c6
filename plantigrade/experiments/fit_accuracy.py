"""How close fits come: to markers, to OpenSim, to Plug-in Gait, to force plates.

Every walking trial of the data folder is fitted as a user would call it, with its file name alone;
then its angles, moments and events are held against what other software and the plates say.
"""

import time
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from plantigrade.analyze.statistics import correlation, rmse_offset_removed
from plantigrade.analyze.trial import CUTOFF, SIDES, Trial
from plantigrade.experiments.table import ResultTable, Row, at_least, at_most, over_trials
from plantigrade.io import read
from plantigrade.io.mot import read_table
from plantigrade.kinematics.inverse import InverseKinematics
from plantigrade.kinematics.state import PointSet
from plantigrade.motion import Recording, Table
from plantigrade.motion.filters import lowpass
from plantigrade.motion.plate_events import plate_events
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import FitSettings

LEGS = ("hip_flexion", "knee_angle", "ankle_angle")
ROUGH = 0.6  # roughness of the worst stored moment above which none of a file is held against
LONGEST_MATCH = 0.15  # events further apart than this are different events [s]

NOTES = (
    "",
    "How to read it: stored Plug-in Gait moments are low-passed like ours before they are compared "
    "(unfiltered, r of the hip and knee is 0.02 to 0.1 lower); where a file's own are mostly noise "
    "they are shown without a goal. gait2392's solution has its toes locked, so rigid feet are "
    "held against it and the default feet are shown beside. Plate events count only where the "
    "force rises or falls cleanly under one foot alone.",
    "The constants of calibration and event detection were settled with these trials in view: on "
    "other recordings expect somewhat more.",
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
# One of each kind: Plug-in Gait's outputs, OpenSim's angles and moments, each sort of skeleton.
QUICK = (
    "c3d/HC032A03.c3d",
    "opensim/rajagopal_walk/markers_walk.trc",
    "opensim/gait2392_subject01/subject01_walk1.trc",
    "cmu_asfamc/16_21.amc",
    "cmu_bvh/07_01.bvh",
    "deepmimic/humanoid3d_walk.txt",
)
# The gait2392 solution has its toes and subtalar joints locked: it is held against rigid feet.
OPENSIM = {
    "opensim/rajagopal_walk/markers_walk.trc": ("coordinates.sto", "id_walk.sto", None),
    "opensim/gait2392_subject01/subject01_walk1.trc": (
        "std_subject01_walk1_ik.mot",
        None,
        "rigid",
    ),
}
# Plug-in Gait's angle and moment → ours, and the sign between them.
PLUG_IN_GAIT = {
    "hip_flexion": ("HipAngles", "HipMoment", -1),
    "knee_angle": ("KneeAngles", "KneeMoment", -1),
    "ankle_angle": ("AnkleAngles", "AnkleMoment", -1),
}


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over every walking trial in a data folder.

    Args:
        data: The folder (layout as in its README).
        quick: A few trials of different kinds instead.
        say: Called with one line per trial as it is done.
    """
    title = "Accuracy of fits, each called with its file name alone"
    others = [p.relative_to(data).as_posix() for s in SKELETONS for p in sorted(data.glob(s))]
    names = QUICK if quick else (*WALKS, *others)

    def rows(path: Path, name: str) -> list[Row]:
        return trial_rows(path, name) if name in WALKS else skeleton_rows(path, name)

    return over_trials(title, data, names, rows, say=say, notes=NOTES)


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
    rows += event_rows(name, trial, recording)
    if name in OPENSIM:
        angles, moments, feet = OPENSIM[name]
        theirs = read(path.parent / angles)
        rows += opensim_rows(name, trial, theirs, path.parent, moments)
        if feet is not None:
            for i, row in enumerate(rows):
                if "against OpenSim" in row.quantity:  # other feet: shown, without a goal
                    rows[i] = replace(row, goal="", met=None)
            same = fit_trial(path, FitSettings(feet=feet))[1]
            for row in opensim_rows(name, same, theirs, path.parent, moments):
                rows.append(replace(row, quantity=f"{row.quantity}, {feet} feet as there"))
    if recording.outputs:
        rows += plug_in_gait_rows(name, trial, recording)
    return rows


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


def opensim_rows(
    name: str, trial: Trial, theirs: Recording, folder: Path, moments: str | None
) -> list[Row]:
    """Hold angles and moments against OpenSim's."""
    rows = []
    coordinates = theirs.coordinates
    assert coordinates is not None
    names, values = trial.fit.human.to_coordinates(trial.fit.qpos)
    ours = Table(names, trial.fit.time, values)
    for joint in LEGS:
        for side in SIDES:
            a, b = shared(ours, coordinates, f"{joint}_{side}")
            error = rmse_offset_removed(np.rad2deg(a), np.rad2deg(b))
            rows.append(at_most(name, f"{joint}_{side} against OpenSim, RMSE", error, 3, "deg"))
    if moments is None or trial.moments is None or trial.forces is None:
        return rows
    table = read_table(folder / moments)
    for joint in LEGS:
        for side in SIDES:
            column = f"{joint}_{side}"
            i = 6 + trial.fit.human.hinge(column)
            known = np.asarray(trial.forces.valid_side)[:, trial.forces.sides.index(side)]
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
            rows.append(at_least(name, f"{label}, r", correlation(a, b), 0.97))
            rows.append(at_most(name, f"{label}, peak", off, 10, "%"))
    return rows


def plug_in_gait_rows(name: str, trial: Trial, recording: Recording) -> list[Row]:
    """Hold sagittal angles and moments against Plug-in Gait's, stored in the file."""
    rows = []
    fit = trial.fit
    assert recording.markers is not None
    clock = recording.markers.time
    names, values = fit.human.to_coordinates(fit.qpos)
    stored_moments = [
        recording.outputs[s.upper() + m]
        for _, m, _ in PLUG_IN_GAIT.values()
        for s in SIDES
        if s.upper() + m in recording.outputs
    ]
    noisy = any(roughness(x[:, 0]) > ROUGH for x in stored_moments)
    for joint, (angle, moment, sign) in PLUG_IN_GAIT.items():
        for side in SIDES:
            column, prefix = f"{joint}_{side}", side.upper()
            stored = recording.outputs.get(prefix + angle)
            if stored is not None and np.isfinite(stored[:, 0]).sum() > 20:
                theirs = on_clock(clock, stored[:, 0], fit.time)
                mine = np.rad2deg(values[:, names.index(column)])
                r = correlation(mine, theirs)
                rows.append(at_least(name, f"{column} against Plug-in Gait, r", r, 0.95))
            stored = recording.outputs.get(prefix + moment)
            if stored is None or trial.moments is None or trial.forces is None:
                continue
            k = trial.forces.sides.index(side)
            loaded = np.asarray(trial.forces.valid_side)[:, k] & (trial.forces.force[:, k, 2] > 20)
            # Plug-in Gait stores moments of unfiltered motion: both in the same band.
            theirs = lowpass(clock, stored[:, 0], cutoff=CUTOFF)
            theirs = on_clock(clock, theirs, fit.time)
            mine = trial.moments.tau[:, 6 + fit.human.hinge(column)]
            ok = loaded & np.isfinite(theirs) & (theirs != 0)
            if ok.sum() > 20:
                r = sign * correlation(mine[ok], theirs[ok])
                row = at_least(name, f"{column} moment against Plug-in Gait, r", r, 0.95)
                if noisy:
                    row = replace(row, goal="", met=None, note="theirs is mostly noise")
                rows.append(row)
    return rows


def roughness(values: np.ndarray) -> float:
    """Return how much of a curve is frame-to-frame noise: its second differences to its spread."""
    x = values[np.isfinite(values)]
    return float(np.std(np.diff(x, 2)) / np.std(x)) if len(x) > 10 else float("nan")


def event_rows(name: str, trial: Trial, recording: Recording) -> list[Row]:
    """Hold the kinematic events against the plates and the events stored in the file."""
    rows = []
    own = trial.motion.events
    fit = trial.fit
    measured = plate_events(fit.recording.plates, fit.time, trial.feet.heel, trial.feet.toe)
    for what, truth in (("plates", measured), ("file", recording.events)):
        if not truth:
            continue
        for kind in ("heel_strike", "toe_off"):
            theirs = [e for e in truth if e.kind == kind and fit.time[0] <= e.time <= fit.time[-1]]
            if not theirs:
                continue
            errors, missed, invented = match(own, theirs, kind, complete=what == "file")
            label = f"{kind} against {what}"
            if errors:
                mae = 1e3 * float(np.mean(np.abs(errors)))
                rows.append(at_most(name, f"{label}, mean error ({len(errors)})", mae, 20, "ms"))
            rows.append(at_most(name, f"{label}, missed", missed, 0))
            if what == "file":
                rows.append(at_most(name, f"{label}, invented", invented, 0))
    return rows


def match(ours: Iterable, theirs: Iterable, kind: str, *, complete: bool):
    """Return time errors of matched events [s], the number missed and the number invented."""
    errors, missed, used = [], 0, set()
    ours = [e for e in ours if e.kind == kind]
    theirs = list(theirs)
    for e in theirs:
        near = [
            (abs(o.time - e.time), i)
            for i, o in enumerate(ours)
            if o.side == e.side and i not in used
        ]
        if near and min(near)[0] < LONGEST_MATCH:
            i = min(near)[1]
            used.add(i)
            errors.append(ours[i].time - e.time)
        else:
            missed += 1
    first, last = min(e.time for e in theirs), max(e.time for e in theirs)
    extra = [o for i, o in enumerate(ours) if i not in used and first < o.time < last]
    return errors, missed, len(extra) if complete else 0


def shared(a: Table, b: Table, column: str) -> tuple[np.ndarray, np.ndarray]:
    """Return a column of both tables on the clock of the second, where both have it."""
    inside = (b.time >= a.time[0]) & (b.time <= a.time[-1])
    return np.interp(b.time[inside], a.time, a[column]), b[column][inside]


def on_clock(clock: np.ndarray, values: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return a signal at the samples of another clock that lie on it; NaN elsewhere."""
    index = np.rint(np.interp(wanted, clock, np.arange(len(clock)))).astype(int)
    return np.where(np.abs(clock[index] - wanted) < 1e-3, values[index], np.nan)

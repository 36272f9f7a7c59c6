"""Recordings tracked on contact forces, compared with force plates.

Each recording is fitted with its file name alone; its motion becomes a trajectory problem without
the plates, near the forces that the quadratic program of the whole recording estimates. Walks on
plates are compared with them, and so are that program alone and published figures of OpenGRF;
walks, a chair and squats without plates must pass the check.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.fit_accuracy import SETTLING_PEOPLE, WALKS
from experiments.force_figures import FORCES, MOMENTS, OPENGRF
from experiments.gait_forces import STANCES
from experiments.table import (
    ResultTable,
    Row,
    at_most,
    equal,
    mean_rows,
    over_trials,
    sheets_of,
    within,
)
from plantigrade.analyze.check import check
from plantigrade.analyze.gait_forces import ForceComparison
from plantigrade.analyze.reproduction import Comparison
from plantigrade.analyze.trial import Trial
from plantigrade.constants import SIDES
from plantigrade.kinematics.contacts import MID_STANCE, stances
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.motion import Motion
from plantigrade.ordered_tasks.phases import walking_events
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import TrackSettings
from plantigrade.workflows.track import Tracked, track_trial

QUICK_TRIALS = ("opensim/gait2392_subject01/subject01_walk1.trc",)
MAX_WALK = 2.5
"""Longest tracked interval of a walk: two strides [s]."""
MAX_OTHER = 6.0
"""Longest tracked interval of other motions: a squat, from the chair and back [s]."""
START_TIMES = {"cmu_bvh/13_01.bvh": 2.5}
"""Start of the tracked interval [s]."""
OTHER_TRIALS = (
    "opensim/opencap_subject4/STS1.trc",
    "opensim/opencap_subject4/squats1.trc",
    "opensim/opencap_squat/squats1_videoAndMocap.mot",
    "opensim/gait2392_subject01/normal_gait.mot",
    "opensim/gait2392_subject01/crouch_gait.mot",
    *(f"cmu_asfamc/{n}.amc" for n in ("02_01", "02_02", "07_01", "07_05", "07_08", "07_12")),
    *(f"cmu_asfamc/{n}.amc" for n in ("16_15", "16_21", "49_01", "131_01", "131_12")),
    "cmu_bvh/07_01.bvh",
    "cmu_bvh/13_01.bvh",
    "deepmimic/humanoid3d_walk.txt",
    "deepmimic/humanoid3d_stealthy_walk.txt",
)
"""Walking, chairs and squats without plates under every foot."""
PROGRAM_PREFIX = "program alone: "
"""How figures begin that are the quadratic program's, without tracking."""
FIGURES = (*FORCES, *MOMENTS)
ANKLE_RMS = "ankle angle from the recording, RMS of the worse foot"
ANKLE_RANGE = "ankle, range of motion from the recorded one, worse foot"
KNEE_RMS = "knee flexion from the recording, RMS of the worse leg"
HIP_RMS = "hip flexion from the recording, RMS of the worse leg"
KNEE_RANGE = "knee flexion, range of motion from the recorded one, worse leg"
HIP_RANGE = "hip flexion, range of motion from the recorded one, worse leg"
JOINTS = (
    ("ankle_angle", ANKLE_RMS, ANKLE_RANGE),
    ("knee_angle", KNEE_RMS, KNEE_RANGE),
    ("hip_flexion", HIP_RMS, HIP_RANGE),
)
FOOT_FLAT = "heel strike to foot flat"
FOOT_FLAT_RECORDED = "heel strike to foot flat, recorded"
FLAT_LATE = "foot flat later than recorded, worse foot"
OFF_LATE = "toes rise later than recorded, worst step"
MAX_EVENT_ERROR = 15.0  # largest error of foot flat and toe-off [ms]
MIN_TOE_RISE = 0.010  # height of the toes above their level in midstance that counts as risen [m]
NEAR_TOE_OFF = 0.15  # largest time between toe-off and that [s]
PEOPLE_FLAT = "80–120"  # heel strike to foot flat of healthy adults [ms]

NOTES = (
    STANCES,
    "Plates are withheld, but where no file tells the body mass it is found from them.",
    f"Settled half: {', '.join(SETTLING_PEOPLE)}; weights were settled there.",
    f"Of a walk {MAX_WALK:g} s are tracked, of what is no walk {MAX_OTHER:g} s.",
    "Program: the quadratic program whose forces the tracked motion keeps near, over the same "
    "frames; it changes no motion, and leaves an unexplained wrench.",
    OPENGRF,
    f"Heel strike to foot flat of healthy adults: {PEOPLE_FLAT} ms.",
)


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over walks on force plates, and other recordings, in a data folder."""
    title = "Recordings tracked on contact forces"
    names = QUICK_TRIALS if quick else (*WALKS, *OTHER_TRIALS)
    table = over_trials(title, data, names, trial_rows, say=say, notes=NOTES)
    rows = list(table.rows)
    walks = {row.subject for row in rows if row.quantity == FORCES[0].name}
    for half, settled in (("settled half", True), ("other half", False)):
        own = [
            r
            for r in rows
            if r.subject in walks and settled == any(s in r.subject for s in SETTLING_PEOPLE)
        ]
        rows += mean_rows(half, own)
    forces = {prefix + f.name for f in FIGURES for prefix in ("", PROGRAM_PREFIX)}
    sheets = sheets_of("Forces and moments", rows, forces)
    sheets += sheets_of("Motions", [row for row in rows if row.quantity not in forces])
    return replace(table, rows=rows, sheets=sheets)


def trial_rows(path: Path, name: str) -> list[Row]:
    """Return all rows of one recording."""
    _, trial = fit_trial(path)
    tracked = track_trial(trial, span(trial, name))
    angle, way = tracked.moved()
    solution, record = tracked.solution, tracked.record()
    verdict = check(record)
    faults = "" if verdict.ok else "; ".join(verdict.sentences()[:3])
    rows = angle_rows(name, tracked.against_recording) + toe_off_rows(name, tracked)
    if name in WALKS and tracked.walk.measured is not None:
        rows += _figures(name, tracked.against_plates(), "")
        rows += _figures(name, tracked.estimate_against_plates(), PROGRAM_PREFIX)
    return [
        *rows,
        Row(name, "moved from the recording, RMS", float(np.rad2deg(angle)), "deg"),
        Row(name, "pelvis moved from the recording, RMS", 1e3 * way, "mm"),
        Row(name, "lifted onto its soles", 1e3 * tracked.lift, "mm"),
        equal(name, "passes the check", float(verdict.ok), 1, "", faults),
        equal(name, "near the recording", float(not tracked.violations), 1, "", tracked.violations),
        Row(name, "solved", float(solution.success), note=solution.status),
        Row(name, "iterations", float(solution.iterations)),
        Row(name, "time", tracked.seconds, "s", note=f"for {_seconds(tracked):.2f} s of motion"),
    ]


def angle_rows(name: str, held: Comparison) -> list[Row]:
    """Return how far legs and feet are from the recorded ones; foot flat where somebody walks."""
    rows = []
    for joint, rms_name, range_name in JOINTS:
        own = [f"{joint}_{side}" for side in SIDES]
        rms = max(held.rmse[angle] for angle in own)
        off = max((held.rom_error[angle] for angle in own), key=abs)
        most = at_most(name, rms_name, rms, 2.5, "deg")
        rows.append(most if rms_name == ANKLE_RMS else Row(name, rms_name, rms, "deg"))
        rows.append(replace(within(name, range_name, off, 5.0, "deg"), goal="<= 5 either way"))
    for quantity, k in ((FOOT_FLAT, 0), (FOOT_FLAT_RECORDED, 1)):
        seen = [1e3 * held.foot_flat[side][k] for side in SIDES]
        if np.isfinite(seen).any():
            rows.append(Row(name, quantity, float(np.nanmean(seen)), "ms"))
    late = [1e3 * (a - b) for a, b in held.foot_flat.values() if np.isfinite(a - b)]
    if late:
        rows.append(_event_row(name, FLAT_LATE, max(late, key=abs)))
    return rows


def toe_off_rows(name: str, tracked: Tracked) -> list[Row]:
    """Return by how much toes rise later than recorded, the worst of all steps."""
    found = tracked.compared().motion
    late = []
    for side in SIDES:
        ours, theirs = (
            _toes_rise(tracked, motion, side, found.time[-1]) for motion in (found, tracked.motion)
        )
        late += [1e3 * (a - b) for a, b in zip(ours, theirs, strict=True) if np.isfinite(a - b)]
    return [_event_row(name, OFF_LATE, max(late, key=abs))] if late else []


def _toes_rise(tracked: Tracked, motion: Motion, side: str, last: float) -> list[float]:
    """Return when the toes of each step are well above their level in midstance [s]."""
    points = sole_paths(tracked.human, motion.qpos)
    height = points.position[:, points.of(side, "toes"), 2].min(axis=1)
    risen = []
    for stance in stances(tracked.motion.events, side, tracked.start, last):
        stop = stance.stop + NEAR_TOE_OFF
        if not stance.whole or stance.start < tracked.start or stop > last:
            continue
        flat = [(motion.time >= stance.start + x).argmax() for x in MID_STANCE]
        level = float(np.median(height[flat[0] : flat[1] + 1])) + MIN_TOE_RISE
        near = (motion.time >= stance.stop - NEAR_TOE_OFF) & (motion.time <= stop)
        up = np.flatnonzero(near & (height > level))
        risen.append(float(motion.time[up[0]]) if len(up) else np.nan)
    return risen


def _event_row(name: str, quantity: str, late: float) -> Row:
    row = within(name, quantity, late, MAX_EVENT_ERROR, "ms")
    return replace(row, goal=f"<= {MAX_EVENT_ERROR:g} either way")


def span(trial: Trial, name: str) -> TrackSettings:
    """Return the tracked interval: at most :data:`MAX_WALK` or :data:`MAX_OTHER`."""
    walked = [e.time for e in walking_events(trial.motion.events)]
    walks = len(walked) > 2 and name not in START_TIMES
    first, last = (float(trial.motion.time[i]) for i in (0, -1))
    start, stop = (walked[0], walked[-1]) if walks else (START_TIMES.get(name, first), last)
    return TrackSettings(start=start, stop=min(stop, start + (MAX_WALK if walks else MAX_OTHER)))


def _seconds(tracked: Tracked) -> float:
    return tracked.stop - tracked.start


def _figures(name: str, c: ForceComparison, prefix: str) -> list[Row]:
    values = ((figure, figure.of(c)) for figure in FIGURES)
    return [Row(name, prefix + f.name, x, f.unit) for f, x in values if np.isfinite(x)]

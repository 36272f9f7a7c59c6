"""Recordings made physical on ground reactions, beside what the force plates measured.

Each recording is fitted with its file name alone; its motion becomes a trajectory problem that
withholds the plates and keeps near the forces that the whole recording's quadratic program
estimates. Walks on plates are held against them, beside that program by itself and what OpenGRF
prints; walks, a chair and squats without them must pass the check.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.fit_accuracy import SETTLED, WALKS
from experiments.force_figures import FORCES, MOMENTS, Figure
from experiments.gait_forces import STANCES
from experiments.table import ResultTable, Row, at_most, over_trials, sheet
from plantigrade.analyze.check import check
from plantigrade.analyze.gait_forces import ForceComparison
from plantigrade.analyze.reproduction import Comparison
from plantigrade.analyze.trial import Trial
from plantigrade.constants import SIDES
from plantigrade.ordered_tasks.phases import walking_events
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import TrackSettings
from plantigrade.workflows.track import Tracked, track_trial

QUICK = ("opensim/gait2392_subject01/subject01_walk1.trc",)
LONGEST = 2.5  # of a recording, this much is tracked: two strides [s] …
REST = 6.0  # … and this much where nobody walks: a squat, from the chair and back
FROM = {"cmu_bvh/13_01.bvh": 2.5}  # where what is to be tracked begins [s]
OTHERS = (
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
PROGRAM = "program alone: "
"""How figures begin that are the quadratic program's, without tracking."""
FIGURES = (*FORCES, *MOMENTS)
ANKLE_RMS = "ankle angle from the recording, RMS of the worse foot"
ANKLE_RANGE = "ankle, range of motion from the recorded one, worse foot"
FLAT, FLAT_RECORDED = "heel strike to foot flat", "heel strike to foot flat, recorded"
PEOPLE_FLAT = "80–120"  # heel strike to foot flat of healthy adults [ms]

NOTES = (
    STANCES,
    "Plates are withheld, but where no file tells the body mass it is found from them.",
    f"Settled half: {', '.join(SETTLED)}; weights were settled there.",
    f"Of a walk {LONGEST:g} s are tracked, of what is no walk {REST:g} s.",
    "Program: the quadratic program whose forces the tracked motion keeps near, over the same "
    "frames; it bends no motion, and leaves a wrench that nothing explains. OpenGRF: what Di "
    "Pietro, Di Puccio and Modenese (2025) print of level walking of seven adults, other data.",
)


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over walks on force plates, and other recordings, in a data folder."""
    title = "Recordings tracked on contact forces"
    names = QUICK if quick else (*WALKS, *OTHERS)
    table = over_trials(title, data, names, trial_rows, say=say, notes=NOTES)
    return replace(table, sheets=(*_sheets(table.rows), *_ankles(table.rows), _passed(table.rows)))


def trial_rows(path: Path, name: str) -> list[Row]:
    """Return all rows of one recording."""
    _, trial = fit_trial(path)
    tracked = track_trial(trial, span(trial, name))
    angle, way = tracked.moved()
    solution, record = tracked.solution, tracked.record()
    verdict = check(record)
    faults = "" if verdict.ok else "; ".join(verdict.words()[:3])
    rows = angle_rows(name, tracked.against_recording)
    if name in WALKS and tracked.walk.measured is not None:
        rows += _figures(name, tracked.against_plates(), "")
        rows += _figures(name, tracked.estimate_against_plates(), PROGRAM)
    return [
        *rows,
        Row(name, "moved from the recording, RMS", float(np.rad2deg(angle)), "deg"),
        Row(name, "pelvis moved from the recording, RMS", 1e3 * way, "mm"),
        Row(name, "lifted onto its soles", 1e3 * tracked.lift, "mm"),
        Row(name, "passes the check", float(verdict.ok), "", "= 1", verdict.ok, faults),
        Row(
            name,
            "near the recording",
            float(not tracked.violations),
            "",
            "= 1",
            not tracked.violations,
            tracked.violations,
        ),
        Row(name, "solved", float(solution.success), note=solution.status),
        Row(name, "iterations", float(solution.iterations)),
        Row(name, "time", tracked.seconds, "s", note=f"for {_seconds(tracked):.2f} s of motion"),
    ]


def angle_rows(name: str, held: Comparison) -> list[Row]:
    """Return how far ankles and feet are from the recorded ones; foot flat where somebody walks."""
    ankles = [f"ankle_angle_{side}" for side in SIDES]
    rms = max(held.rmse[ankle] for ankle in ankles)
    off = max((held.rom_error[ankle] for ankle in ankles), key=abs)
    rows = [
        at_most(name, ANKLE_RMS, rms, 2.5, "deg"),
        Row(name, ANKLE_RANGE, off, "deg", "<= 5 either way", abs(off) <= 5.0),
    ]
    for quantity, k in ((FLAT, 0), (FLAT_RECORDED, 1)):
        seen = [1e3 * held.foot_flat[side][k] for side in SIDES]
        if np.isfinite(seen).any():
            rows.append(Row(name, quantity, float(np.nanmean(seen)), "ms"))
    return rows


def span(trial: Trial, name: str) -> TrackSettings:
    """Return what is tracked of a recording: not more than :data:`LONGEST` or :data:`REST`."""
    walked = [e.time for e in walking_events(trial.motion.events)]
    walks = len(walked) > 2 and name not in FROM
    first, last = (float(trial.motion.time[i]) for i in (0, -1))
    start, stop = (walked[0], walked[-1]) if walks else (FROM.get(name, first), last)
    return TrackSettings(start=start, stop=min(stop, start + (LONGEST if walks else REST)))


def _seconds(tracked: Tracked) -> float:
    return tracked.stop - tracked.start


def _figures(name: str, c: ForceComparison, prefix: str) -> list[Row]:
    values = ((figure, figure.of(c)) for figure in FIGURES)
    return [Row(name, prefix + f.name, x, f.unit) for f, x in values if np.isfinite(x)]


def _sheets(rows: Sequence[Row]) -> tuple[str, ...]:
    """Return the figures of each walk, tracked and of the program, then the means of the halves."""
    values: dict[str, dict[str, float]] = {}
    for row in rows:
        if row.value is not None:
            values.setdefault(row.subject, {})[row.quantity] = float(row.value)
    walks = {n: each for n, each in values.items() if FORCES[0].name in each}
    if not walks:
        return ()
    halves = {
        "settled half": [n for n in walks if any(who in n for who in SETTLED)],
        "other half": [n for n in walks if not any(who in n for who in SETTLED)],
    }
    found = []
    for title, figures in (("Ground reactions", FORCES), ("Joint moments", MOMENTS)):
        lines = [line for n, each in walks.items() for line in _pair(Path(n).stem, [each], figures)]
        for half, names in halves.items():
            lines += _pair(half, [walks[n] for n in names], figures) if names else []
        lines.append(["OpenGRF", *(f.opengrf or "–" for f in figures)])
        found.append(sheet(title, ("", *(f.short for f in figures)), lines))
    return tuple(found)


def _pair(
    name: str, walks: Sequence[dict[str, float]], figures: Sequence[Figure]
) -> list[list[str]]:
    """Return two lines of means over walks: tracked, and of the program by itself."""
    lines = []
    for words, prefix in (("tracked", ""), ("program", PROGRAM)):
        cells = []
        for figure in figures:
            known = [w[prefix + figure.name] for w in walks if prefix + figure.name in w]
            cells.append(f"{np.mean(known):.{figure.digits}f}" if known else "–")
        lines.append([f"{name}, {words}", *cells])
    return lines


def _ankles(rows: Sequence[Row]) -> tuple[str, ...]:
    """Return how near ankles and feet are to the recorded ones, of each walk and both halves."""
    titles = {
        ANKLE_RMS: ("ankle RMS deg", 1),
        ANKLE_RANGE: ("range off deg", 1),
        FLAT: ("foot flat ms", 0),
        FLAT_RECORDED: ("recorded ms", 0),
    }
    values: dict[str, dict[str, float]] = {}
    for row in rows:
        if row.quantity in titles and row.value is not None:
            values.setdefault(row.subject, {})[row.quantity] = float(row.value)
    walks = {name: each for name, each in values.items() if FLAT in each}
    if not walks:
        return ()

    def line(name: str, known: Sequence[dict[str, float]]) -> list[str]:
        means = {q: [each[q] for each in known if q in each] for q in titles}
        cells = [f"{np.mean(x):.{titles[q][1]}f}" if x else "–" for q, x in means.items()]
        return [name, *cells]

    lines = [line(Path(name).stem, [each]) for name, each in walks.items()]
    for half, settled in (("settled half", True), ("other half", False)):
        known = [x for n, x in walks.items() if any(who in n for who in SETTLED) == settled]
        lines += [line(half, known)] if known else []
    lines.append(["people", "", "", PEOPLE_FLAT, ""])
    return (sheet("Ankles and feet", ("", *(short for short, _ in titles.values())), lines),)


def _passed(rows: Sequence[Row]) -> str:
    """Return which recordings pass the check, and what it took."""
    columns = {
        "passes the check": ("passes", 0),
        "near the recording": ("near it", 0),
        "iterations": ("iterations", 0),
        "moved from the recording, RMS": ("moved deg", 1),
        "pelvis moved from the recording, RMS": ("pelvis mm", 1),
        "time": ("s", 1),
    }
    values: dict[str, dict[str, float]] = {}
    for row in rows:
        if row.quantity in columns and row.value is not None:
            values.setdefault(row.subject, {})[row.quantity] = float(row.value)
    lines = []
    for name, each in values.items():
        cells = [f"{each.get(what, np.nan):.{digits}f}" for what, (_, digits) in columns.items()]
        lines.append([Path(name).stem, "yes" if each["passes the check"] else "no", *cells[1:]])
    return sheet("The check", ("", *(short for short, _ in columns.values())), lines)

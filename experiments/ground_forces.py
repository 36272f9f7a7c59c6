"""Forces without plates: ground reactions estimated from the motion against measured ones.

Each recording is fitted with its file name alone; its plates are then withheld, and the forces of
the whole trial's quadratic program are compared with them, also with noise added to the motion,
for one foot with the plates of the other, and at the ends of recordings cut at many instants.
Constants were chosen on one half of the people and are validated on the other.
"""

import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from experiments.abrupt_transfers import transfer_rows
from experiments.fit_accuracy import MOVEMENTS, SETTLING_PEOPLE, WALKS
from experiments.force_figures import (
    BAND_FIGURES,
    BY_PHASE,
    COMPUTING_TIME,
    FIGURES,
    FORCES,
    LEAST_CORRELATION,
    MOMENTS,
    PRESSURE_AHEAD,
    Figure,
)
from experiments.gait_forces import STANCES
from experiments.given_ground import GROUNDS, on_ground
from experiments.left_out import left_out_rows, left_out_sheet
from experiments.recording_ends import END_DURATION, phase_rows
from experiments.table import ResultTable, Row, over_trials, sheet, sheets_of
from plantigrade.analyze.force_tilt import MAX_TILT, force_tilt, levelled
from plantigrade.analyze.gait_forces import ForceComparison, compare_forces
from plantigrade.analyze.trial import Trial, analyse
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.dynamics.ground_forces import estimate_forces
from plantigrade.dynamics.inverse import inverse_dynamics
from plantigrade.errors import ReproduceError
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.kinematics.result import Fit
from plantigrade.motion.filters import lowpass
from plantigrade.threads import on_one_thread
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import FitSettings

QUICK_TRIALS = ("c3d/HC032A03.c3d", "opensim/gait2392_subject01/subject01_walk1.trc")
MASSES = {f"opensim/opencap_subject4/{name}.trc": 60.2 for name in ("STS1", "DJ1")}
"""Body mass where neither file nor plates tell it [kg]: weighed in other trials of the person."""
ACTIVITIES = {
    "running": ("run200", "run300"),
    "squats": ("squats1",),
    "chair": ("STS1",),
    "jumps": ("DJ1",),
}
"""Movements other than walking, each judged by itself: parts of the names of recordings."""
NOISE_MM = 1.0  # [mm] RMS of noise added to translations
NOISE_DEG = 0.3  # [deg] RMS of noise added to rotations
NOISE_HZ = 5.0  # [Hz] below which that noise is
NOISY_PREFIX = "with noise, "
ONE_PLATE_PREFIX = "beside one plate, "
GIVEN_GROUND_PREFIX = "on given ground, "
LEVELLED_PREFIX = "levelled plates, "
PREFIXES = {
    "": "",
    LEVELLED_PREFIX: " against plates without their tilt",
    NOISY_PREFIX: f", {NOISE_MM:g} mm and {NOISE_DEG:g}° of noise added",
    ONE_PLATE_PREFIX: " of each foot beside the plates of the other",
    GIVEN_GROUND_PREFIX: " on given ground, of generated walks",
}
"""Prefix of figures → its words in the title of a table."""


NOTES = (
    STANCES,
    "Plates are withheld; only where no file tells the body mass it is the one that they carry.",
    f"Settled half: {', '.join(SETTLING_PEOPLE)}; all constants were settled there. The other half "
    "is other people and other laboratories.",
    f"With noise: {NOISE_MM:g} mm and {NOISE_DEG:g}° (RMS, below {NOISE_HZ:g} Hz) added to every "
    "coordinate of the fitted motion; held against the plates and inverse dynamics without it.",
    "OpenGRF: what Di Pietro, Di Puccio and Modenese (2025) print of level walking of seven "
    "adults; other people and another protocol.",
    "Against plates without their tilt: where their horizontal force over whole strides exceeds "
    f"that of the motion by more than {100 * MAX_TILT:g} % of the weight (a tilt of "
    f"{np.rad2deg(MAX_TILT):.1f}°), it is taken off; other recordings as above.",
    "Beside one plate: the plates of one foot are known, those of the other are withheld.",
    "Movements other than walking have rows of their own and are in no mean of a half.",
    "On given ground: walks generated there, whose forces are exact, recorded with the markers and "
    "the faults of a laboratory; without --quick.",
    "Where load goes over otherwise: in double supports with both feet on plates the rear foot has "
    "another share of the load, and the net moment what follows from it.",
    "Each source with constants of all others: usual curves of the feet measured on their plates, "
    "bands as wide as 90 % of their measured values need. Scales of the program and spreads of the "
    "curves are the shipped ones, which were chosen by hand on the settled half.",
    f"By phase: recordings are cut in double support and after landings; of the cut ones the first "
    f"or last {END_DURATION:g} s count.",
)


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over the recordings with force plates of a data folder."""
    title = "Ground reactions without force plates"
    names = QUICK_TRIALS if quick else (*WALKS, *MOVEMENTS)
    table = over_trials(title, data, names, trial_rows, say=say, notes=NOTES)
    table = replace(table, rows=[*table.rows, *(() if quick else given_rows(say))])
    values: dict[str, dict[str, float]] = {}
    for row in table.rows:
        values.setdefault(row.subject, {})[row.quantity] = _number(row.value)
    halves = {
        "settled half": [
            n for n in values if n in WALKS and any(part in n for part in SETTLING_PEOPLE)
        ],
        "other half": [
            n for n in values if n in WALKS and not any(part in n for part in SETTLING_PEOPLE)
        ],
    }
    means = {half: _means([values[n] for n in names]) for half, names in halves.items() if names}
    for half, found in means.items():
        vertical = [values[n][FORCES[0].name] for n in halves[half] if FORCES[0].name in values[n]]
        if vertical:
            found[LEAST_CORRELATION.name] = min(vertical)
    groups = {
        words: _means([values[n] for n in values if any(part in n for part in parts)])
        for words, parts in ACTIVITIES.items()
    }
    groups = {words: found for words, found in groups.items() if found}
    rows = [row for half, found in means.items() for row in _judged(half, found)]
    for words, found in groups.items():
        rows += _judged(words, found, (PRESSURE_AHEAD, *BAND_FIGURES))
    sheets = _sheets(values, {**means, **groups})
    if not quick and (trials := walks(data)):
        left_out = left_out_rows(trials)
        rows, sheets = [*rows, *left_out], (*sheets, left_out_sheet(left_out))
        for half, own in halves.items():
            changed = transfer_rows({name: trials[name] for name in own if name in trials})
            title = f"Vertical force where load goes over otherwise, {half}"
            rows, sheets = [*rows, *changed], (*sheets, *sheets_of(title, changed))
    return replace(table, rows=[*table.rows, *rows], sheets=sheets)


def walks(data: Path) -> dict[str, Trial]:
    """Return the walks of a folder, their plates withheld."""
    found = {}
    for name in (name for name in WALKS if (data / name).exists()):
        fit = fit_trial(data / name)[1].fit
        found[name] = analyse(fit, mass=fit.human.mass, without_plates=True)
    return found


def trial_rows(path: Path, name: str) -> list[Row]:
    """Return all rows of one recording: as it is, and of a walk also with noise."""
    trial = fit_trial(path, FitSettings(mass=MASSES.get(name)))[1]
    if trial.forces is None:
        raise ReproduceError(f"{path} has no force plates to compare with")
    fit, mass = trial.fit, trial.fit.human.mass
    alone = analyse(fit, mass=mass, without_plates=True)
    if alone.ground is None:
        return [Row(name, FORCES[0].name, None, note=" ".join(alone.notes[-1:]))]
    started = time.process_time()
    on_one_thread(estimate_forces)(alone.fit.human, alone.motion)  # as in a fit
    seconds = time.process_time() - started
    rows = [
        *_compared(name, alone, alone, ""),
        Row(name, COMPUTING_TIME.name, seconds, COMPUTING_TIME.unit),
    ]
    if name in WALKS:
        rows += _rows(name, against_level(alone), LEVELLED_PREFIX)
        noisy = analyse(with_noise(fit, name), mass=mass, without_plates=True)
        rows += _compared(name, noisy, alone, NOISY_PREFIX)
        rows += _rows(name, beside_one_plate(alone), ONE_PLATE_PREFIX)
        rows += phase_rows(name, alone, mass)
    return rows


def given_rows(say: Callable[[str], None] = lambda _: None) -> list[Row]:
    """Return the rows of generated walks on slopes and steps, fitted with those as given."""
    rows = []
    for name, walk in GROUNDS.items():
        rows += _rows(name, on_ground(*walk), GIVEN_GROUND_PREFIX)
        say(f"{name} done")
    return rows


def against_level(trial: Trial) -> ForceComparison:
    """Return an estimate against its withheld plates, without their tilt where they have one."""
    assert trial.withheld is not None
    human, motion, (forces, moments) = trial.fit.human, trial.motion, trial.withheld
    assert motion.qacc is not None
    tilt = force_tilt(motion.time, forces, moments, trial.cycles)
    if tilt is not None and np.hypot(*tilt) > MAX_TILT:
        forces = levelled(forces, tilt)
        moments = inverse_dynamics(human, motion.qpos, motion.qvel, motion.qacc, forces)
        trial = replace(trial, withheld=(forces, moments))
    assert trial.measured is not None
    return compare_forces(trial.record(), trial.measured, belt=_belt(trial))


def beside_one_plate(trial: Trial) -> ForceComparison:
    """Return each foot estimated beside the plates of the other, against its own.

    The trial's plates were withheld.
    """
    assert trial.withheld is not None and trial.measured is not None
    human, motion, (forces, _) = trial.fit.human, trial.motion, trial.withheld
    assert motion.qacc is not None
    feet, found = [], None
    for k, side in enumerate(SIDES):
        known = np.array(forces.valid_side)
        known[:, k] = False
        if not np.any(forces.force[known[:, 1 - k], 1 - k]):
            continue
        measured = replace(forces, valid_side=known, valid=known.all(axis=1))
        ground = estimate_forces(human, motion, measured=measured)
        moments = inverse_dynamics(human, motion.qpos, motion.qvel, motion.qacc, ground.forces)
        record = replace(trial, ground=ground, moments=moments).record()
        found = compare_forces(record, trial.measured, belt=_belt(trial))
        feet += [foot for foot in found.feet if foot.side == side]
    return ForceComparison(motion.time, tuple(feet), 0.0 if found is None else found.residual)


def with_noise(fit: Fit, name: str) -> Fit:
    """Return a fit with slow noise on every coordinate, the same for the same name."""
    model, n = fit.human.model, len(fit.time)
    white = np.random.default_rng(zlib.crc32(name.encode())).standard_normal((n, model.nv))
    slow = lowpass(fit.time, white, cutoff=NOISE_HZ)
    slow /= np.sqrt(np.mean(slow**2, axis=0))
    slow *= np.r_[np.full(3, 1e-3 * NOISE_MM), np.full(model.nv - 3, np.deg2rad(NOISE_DEG))]
    qpos = fit.qpos.copy()
    for f in range(n):
        mujoco.mj_integratePos(model, qpos[f], slow[f], 1.0)
    return replace(fit, qpos=qpos)


def _compared(name: str, trial: Trial, true: Trial, prefix: str) -> list[Row]:
    """Return the figures of an estimate against what was measured without noise."""
    if trial.ground is None or true.measured is None:
        return [Row(name, prefix + FORCES[0].name, None, note=" ".join(trial.notes[-1:]))]
    c = compare_forces(trial.record(), true.measured, belt=_belt(true))
    noise = Row(name, f"{prefix}noise of the motion", trial.ground.noise)
    return [*_rows(name, c, prefix), noise]


def _rows(name: str, c: ForceComparison, prefix: str) -> list[Row]:
    """Return those figures that there are."""
    values = [(figure, figure.of(c)) for figure in FIGURES]
    return [Row(name, prefix + f.name, x, f.unit) for f, x in values if np.isfinite(x)]


def _belt(trial: Trial) -> Float[Array, "n_frames 3"]:
    """Return the path of the ground under a trial [m]."""
    return moving_ground(trial.motion.time, trial.feet.heel, trial.feet.toe)


def _means(found: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Return the mean of each figure over the recordings that have it."""
    names = dict.fromkeys(name for each in found for name in each)
    values = {n: [each[n] for each in found if np.isfinite(each.get(n, np.nan))] for n in names}
    return {n: float(np.mean(v)) for n, v in values.items() if v}


def _judged(
    half: str,
    found: Mapping[str, float],
    figures: Sequence[Figure] = (*FIGURES, *BY_PHASE, LEAST_CORRELATION, COMPUTING_TIME),
) -> list[Row]:
    """Return means, of a half of the people or of a movement, beside the goals."""
    rows = []
    for prefix in PREFIXES:
        for figure in figures:
            value = found.get(prefix + figure.name)
            if value is None:
                continue
            row = Row(half, prefix + figure.name, value, figure.unit)
            if figure.goal is not None:
                met = value >= figure.goal if figure.least else abs(value) <= figure.goal
                met = met and (figure.most is None or value <= figure.most)
                row = replace(row, goal=_goal(figure), met=bool(met))
            rows.append(row)
    return rows


def _sheets(
    values: Mapping[str, Mapping[str, float]], means: Mapping[str, Mapping[str, float]]
) -> tuple[str, ...]:
    """Return ground reactions, moments and bands, one line a recording, then the means."""
    found = []
    lines = {**{Path(name).stem: each for name, each in values.items()}, **means}
    for prefix, words in PREFIXES.items():
        for title, figures in (
            (f"Ground reactions{words}", FORCES),
            (f"Joint moments{words}", (*MOMENTS, *(() if prefix else (COMPUTING_TIME,)))),
            (f"Specification values in the 90 % bands [%]{words}", BAND_FIGURES),
            (f"Vertical force by phase{words}", () if prefix else (*BY_PHASE, LEAST_CORRELATION)),
        ):
            table = [
                [name, *(_shown(each.get(prefix + f.name), f.digits) for f in figures)]
                for name, each in lines.items()
                if any(np.isfinite(each.get(prefix + f.name, np.nan)) for f in figures)
            ]
            if not table:
                continue
            if any(f.opengrf for f in figures):
                table.append(["OpenGRF", *(f.opengrf or "–" for f in figures)])
            if any(f.goal is not None for f in figures):
                table.append(["goal", *(_goal(f) for f in figures)])
            found.append(sheet(title, ("", *(f.short for f in figures)), table))
    return tuple(found)


def _goal(figure: Figure) -> str:
    if figure.goal is None:
        return ""
    if figure.most is not None:
        return f"{figure.goal:g}-{figure.most:g}"
    return f"{'>=' if figure.least else '<='} {figure.goal:g}"


def _shown(value: float | None, digits: int) -> str:
    return "–" if value is None or not np.isfinite(value) else f"{value:.{digits}f}"


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)

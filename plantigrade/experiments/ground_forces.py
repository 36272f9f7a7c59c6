"""Forces without plates: ground reactions estimated from the motion, beside the measured ones.

Each recording is fitted with its file name alone; its plates are then withheld, and what the whole
trial's quadratic program gives is held against them, also with noise added to the motion, and of
one foot beside the plates of the other. Constants
were settled on one half of the people and are judged by the other.
"""

import time
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from plantigrade.analyze.gait_forces import ForceComparison, compare_forces
from plantigrade.analyze.trial import Trial, analyse
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.dynamics.ground_forces import estimate_forces
from plantigrade.dynamics.inverse import inverse_dynamics
from plantigrade.errors import ReproduceError
from plantigrade.experiments.fit_accuracy import MOVEMENTS, SETTLED, WALKS
from plantigrade.experiments.gait_forces import STANCES
from plantigrade.experiments.table import ResultTable, Row, over_trials, sheet
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.kinematics.result import Fit
from plantigrade.motion.filters import lowpass
from plantigrade.threads import on_one_thread
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import FitSettings

QUICK = ("c3d/HC032A03.c3d", "opensim/gait2392_subject01/subject01_walk1.trc")
MASSES = {f"opensim/opencap_subject4/{name}.trc": 60.2 for name in ("STS1", "DJ1")}
"""Body mass where neither file nor plates tell it [kg]: weighed in other trials of the person."""
NOISE_MM, NOISE_DEG, NOISE_HZ = 1.0, 0.3, 5.0  # RMS of added noise [mm], [deg]; below [Hz]
NOISY, BESIDE = "with noise, ", "beside one plate, "
PREFIXES = {
    "": "",
    NOISY: f", {NOISE_MM:g} mm and {NOISE_DEG:g}° of noise added",
    BESIDE: " of each foot beside the plates of the other",
}
"""How figures begin, and what is said of them over a table."""


@dataclass(frozen=True)
class Figure:
    """One figure of the table.

    Attributes:
        name: Of its rows.
        short: Over its column.
        of: Reads it from a comparison; the computing time is measured.
        unit: Its unit.
        goal: What the mean over recordings is held against; None for none.
        least: Whether the goal is the least that is wanted, not the most.
        opengrf: What [DiPietro2025]_ prints.
        digits: Behind the decimal point.
    """

    name: str
    short: str
    of: Callable[[ForceComparison], float]
    unit: str = ""
    goal: float | None = None
    least: bool = False
    opengrf: str = ""
    digits: int = 3


def _moment(kind: str, joint: str) -> Callable[[ForceComparison], float]:
    return lambda c: getattr(c, f"moment_{kind}").get(joint, float("nan"))


def _covered(what: str) -> Callable[[ForceComparison], float]:
    return lambda c: 100.0 * c.covered.get(what, float("nan"))


FORCES = (
    Figure("vertical force, r", "vert r", lambda c: c.vertical_r, "", 0.98, True, ">= .94"),
    Figure("vertical force, RMSE", "BW", lambda c: c.vertical_rmse, "BW", 0.05),
    Figure("forward force, r", "fore r", lambda c: c.forward_r, "", 0.98, True, ".81-.91"),
    Figure("forward force, RMSE", "BW", lambda c: c.forward_rmse, "BW"),
    Figure(
        "forward force, nRMSE", "%", lambda c: c.forward_nrmse,
        "%", 5.0, opengrf="4.4-6.1", digits=1,
    ),
    Figure("sideways force, r", "side r", lambda c: c.sideways_r, "", 0.94, True),
    Figure("sideways force, RMSE", "BW", lambda c: c.sideways_rmse, "BW"),
    Figure(
        "centre of pressure x, median error", "CoP x mm", lambda c: 1e3 * c.pressure_median_m[0],
        "mm", 12.0, opengrf="21-23", digits=1,
    ),
    Figure(
        "centre of pressure y, median error", "y mm", lambda c: 1e3 * c.pressure_median_m[1],
        "mm", digits=1,
    ),
    Figure(
        "centre of pressure, backward in a stance", "back mm", lambda c: 1e3 * c.backward_m,
        "mm", 10.0, digits=1,
    ),
)  # fmt: skip
"""Ground reactions."""
MOMENTS = tuple(
    figure
    for joint, words, goal, printed in (
        ("ankle_angle", "ankle", 0.97, ".98"),
        ("knee_angle", "knee", 0.92, ""),
        ("hip_flexion", "hip", 0.96, ""),
    )
    for figure in (
        Figure(f"{words} moment, r", f"{words} r", _moment("r", joint), "", goal, True, printed),
        Figure(f"{words} moment, RMSE", "N m/kg", _moment("rmse", joint), "N m/kg"),
    )
)
"""Joint moments against inverse dynamics with the plates."""
BANDS = tuple(
    Figure(f"{words} in the 90 % band", short, _covered(what), "%", 80.0, True, digits=0)
    for what, words, short in (
        ("vertical_force", "vertical force", "vertical"),
        ("forward_force", "forward force", "forward"),
        ("sideways_force", "sideways force", "sideways"),
        ("pressure_x", "centre of pressure x", "CoP x"),
        ("pressure_y", "centre of pressure y", "CoP y"),
        ("ankle_angle_moment", "ankle moment", "ankle"),
        ("knee_angle_moment", "knee moment", "knee"),
        ("hip_flexion_moment", "hip moment", "hip"),
    )
)
"""How often the measured value lies in the band."""
TIME = Figure("computing time", "s", lambda c: float("nan"), "s", 0.5, digits=2)
FIGURES = (*FORCES, *MOMENTS, *BANDS)

NOTES = (
    STANCES,
    "Plates are withheld; only where no file tells the body mass it is the one that they carry.",
    f"Settled half: {', '.join(SETTLED)}; all constants were settled there. The other half is "
    "other people and other laboratories.",
    f"With noise: {NOISE_MM:g} mm and {NOISE_DEG:g}° (RMS, below {NOISE_HZ:g} Hz) added to every "
    "coordinate of the fitted motion; held against the plates and inverse dynamics without it.",
    "OpenGRF: what Di Pietro, Di Puccio and Modenese (2025) print of level walking of seven "
    "adults; other people and another protocol.",
    "Beside one plate: what the plates of one foot told is known, that of the other is withheld.",
    "Movements other than walking have rows of their own and are in no mean.",
)


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over the recordings with force plates of a data folder."""
    title = "Ground reactions without force plates"
    names = QUICK if quick else (*WALKS, *MOVEMENTS)
    table = over_trials(title, data, names, trial_rows, say=say, notes=NOTES)
    values: dict[str, dict[str, float]] = {}
    for row in table.rows:
        values.setdefault(row.subject, {})[row.quantity] = _number(row.value)
    halves = {
        "settled half": [n for n in values if n in WALKS and any(part in n for part in SETTLED)],
        "other half": [n for n in values if n in WALKS and not any(part in n for part in SETTLED)],
    }
    means = {half: _means([values[n] for n in names]) for half, names in halves.items() if names}
    rows = [row for half, found in means.items() for row in _judged(half, found)]
    return replace(table, rows=[*table.rows, *rows], sheets=_sheets(values, means))


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
    rows = [*_compared(name, alone, alone, ""), Row(name, TIME.name, seconds, TIME.unit)]
    if name in WALKS:
        noisy = analyse(with_noise(fit, name), mass=mass, without_plates=True)
        rows += _compared(name, noisy, alone, NOISY)
        rows += _rows(name, beside_one_plate(alone), BESIDE)
    return rows


def beside_one_plate(trial: Trial) -> ForceComparison:
    """Return each foot estimated beside the plates of the other, against its own.

    The trial's plates were withheld.
    """
    assert trial.withheld is not None and trial.measured is not None
    human, motion, (forces, _) = trial.fit.human, trial.motion, trial.withheld
    assert motion.qacc is not None
    feet, found = [], None
    for k, side in enumerate(SIDES):
        told = np.array(forces.valid_side)
        told[:, k] = False
        if not np.any(forces.force[told[:, 1 - k], 1 - k]):
            continue
        seen = replace(forces, valid_side=told, valid=told.all(axis=1))
        ground = estimate_forces(human, motion, measured=seen)
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


def _judged(half: str, found: Mapping[str, float]) -> list[Row]:
    """Return the means of a half of the people beside the goals."""
    rows = []
    for prefix in PREFIXES:
        for figure in (*FIGURES, TIME):
            value = found.get(prefix + figure.name)
            if value is None:
                continue
            row = Row(half, prefix + figure.name, value, figure.unit)
            if figure.goal is not None:
                met = value >= figure.goal if figure.least else value <= figure.goal
                sign = ">=" if figure.least else "<="
                row = replace(row, goal=f"{sign} {figure.goal:g}", met=bool(met))
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
            (f"Joint moments{words}", (*MOMENTS, *(() if prefix else (TIME,)))),
            (f"Measured values in the 90 % bands [%]{words}", BANDS),
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
    return f"{'>=' if figure.least else '<='} {figure.goal:g}"


def _shown(value: float | None, digits: int) -> str:
    return "–" if value is None or not np.isfinite(value) else f"{value:.{digits}f}"


def _number(value: float | None) -> float:
    return float("nan") if value is None else float(value)

"""Keypoints of video against the laboratory: recordings degraded to what cameras see.

Each recording is fitted to its markers. The joint centres of that body, with noise, gaps and the
rate of a camera, are fitted again as keypoints, without plates and above an unknown floor. Angles
are held against those of the markers, ground reactions against the plates. Constants were settled
on one half of the people.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from experiments.fit_accuracy import SETTLING_PEOPLE, WALKS
from experiments.table import ResultTable, Row, at_most, between, mean_rows, over_trials, sheets_of
from experiments.video_recording import Video, as_video
from plantigrade.analyze.gait_forces import compare_forces
from plantigrade.analyze.trial import Trial, analyse
from plantigrade.errors import PlantigradeError
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.ground_level import moving_ground
from plantigrade.models import Person
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import FitSettings

CONDITIONS = {
    "10 mm, 60 Hz": Video(noise=0.010),
    "15 mm, 60 Hz": Video(noise=0.015),
    "25 mm, 30 Hz": Video(noise=0.025, rate=30.0),
    "15 mm, no feet": Video(noise=0.015, keypoints="COCO"),
}
"""What the cameras do; the noise is the RMS distance of a keypoint from its place."""
QUICK_TRIALS = ("c3d/HC032A03.c3d",)
QUICK_CONDITIONS = ("15 mm, 60 Hz",)
ANGLES = {"hip_flexion": "hip flexion", "knee_angle": "knee", "ankle_angle": "ankle"}
MAX_ANGLE = 5.0  # [deg] goal of the RMS error of sagittal angles
MAX_FORCE = 9.0  # [% of body weight] goal of the mean absolute error of the vertical force
BAND_COVERAGE_RANGE = (85.0, 95.0)  # [%] goal of what is in the 90 % band
CURVE_SUFFIX = ", without its mean error"
RMS_SUFFIX = ", RMS error"
FORCE_FIGURE = "vertical force, mean absolute error"
BAND_FIGURE = "vertical force in the 90 % band"
NOTES = (
    "Angles: RMS difference from the fit to the markers, mean of both sides. Forces: frames of "
    "stance on a plate (above a twentieth of body weight).",
    "Noise: RMS distance in space, its correlation decays to 1/e in 0.2 s; besides, 3 mm of noise "
    "from frame to frame, and 3 % of the samples missing in gaps of 0.15 s.",
    "Hip keypoints do not show the tilt of the pelvis, in which people (and marker sets) differ by "
    "a standard deviation of 7 to 8 degrees: hip flexion has a constant error of that size.",
    f"Settled half: {', '.join(SETTLING_PEOPLE[:-1])}; constants were settled there.",
)


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over the walks with force plates of a data folder."""
    conditions = QUICK_CONDITIONS if quick else tuple(CONDITIONS)

    def rows(path: Path, name: str) -> list[Row]:
        return list(trial_rows(path, name, conditions))

    title = "Keypoints of video against markers and force plates"
    table = over_trials(title, data, QUICK_TRIALS if quick else WALKS, rows, say=say, notes=NOTES)
    settled = [row for row in table.rows if any(who in row.subject for who in SETTLING_PEOPLE)]
    rest = [row for row in table.rows if row not in settled]
    means = [*_means("mean, settled half", settled), *_means("mean, other half", rest)]
    sheets = sheets_of("All recordings", table.rows) + sheets_of("Means", means)
    return replace(table, rows=[*table.rows, *means], sheets=sheets)


def trial_rows(path: Path, name: str, conditions: tuple[str, ...]) -> Iterator[Row]:
    """Yield the rows of one recording under some conditions."""
    clean = fit_trial(path, FitSettings())[1]
    mass = clean.fit.human.mass
    true = analyse(clean.fit, mass=mass, without_plates=True)
    human = clean.fit.human
    sex = "female" if human.sex == "female" else "male"
    person = Person(height=human.height, mass=mass, sex=sex)
    for words in conditions:
        try:
            seen = analyse(fit_markers(as_video(clean.fit, CONDITIONS[words]), person), mass=mass)
        except PlantigradeError as error:
            yield Row(name, f"{words}: {FORCE_FIGURE}", None, note=str(error))
            continue
        for quantity, value, unit in (*angle_errors(seen, clean), *force_errors(seen, true)):
            yield Row(name, f"{words}: {quantity}", value, unit)


def angle_errors(seen: Trial, clean: Trial) -> Iterator[tuple[str, float, str]]:
    """Yield the errors of the sagittal angles: quantity, value, unit."""
    time, human = seen.motion.time, clean.fit.human
    for joint, words in ANGLES.items():
        errors, curves = [], []
        for side in "rl":
            k = 7 + human.hinge(f"{joint}_{side}")
            true = np.interp(time, clean.motion.time, clean.motion.qpos[:, k])
            off = np.rad2deg(
                seen.motion.qpos[:, 7 + seen.fit.human.hinge(f"{joint}_{side}")] - true
            )
            errors.append(float(np.sqrt(np.mean(off**2))))
            curves.append(float(np.std(off)))
        yield words + RMS_SUFFIX, float(np.mean(errors)), "deg"
        yield words + RMS_SUFFIX + CURVE_SUFFIX, float(np.mean(curves)), "deg"


def force_errors(seen: Trial, true: Trial) -> Iterator[tuple[str, float | None, str]]:
    """Yield error and coverage of the vertical force: quantity, value, unit."""
    if seen.ground is None or true.measured is None:
        yield FORCE_FIGURE, None, "% of body weight"
        return
    belt = moving_ground(true.motion.time, true.feet.heel, true.feet.toe)
    found = compare_forces(seen.record(), true.measured, belt=belt)
    off = [
        float(np.mean(np.abs(foot.simulated - foot.measured)[foot.stance, 2]))
        for foot in found.feet
    ]
    yield FORCE_FIGURE, 100.0 * float(np.mean(off)), "% of body weight"
    yield BAND_FIGURE, 100.0 * found.covered["vertical_force"], "%"


def _means(half: str, rows: list[Row]) -> list[Row]:
    """Return the means over some recordings, beside the goals."""
    found = []
    for row in mean_rows(half, rows):
        if row.value is None:
            continue
        quantity = row.quantity.partition(": ")[2]
        if quantity.endswith(RMS_SUFFIX):
            row = at_most(half, row.quantity, row.value, MAX_ANGLE, row.unit, row.note)
        elif quantity == FORCE_FIGURE:
            row = at_most(half, row.quantity, row.value, MAX_FORCE, row.unit, row.note)
        elif quantity == BAND_FIGURE:
            row = between(half, row.quantity, row.value, *BAND_COVERAGE_RANGE, unit=row.unit)
        found.append(row)
    return found

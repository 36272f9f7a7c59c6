"""The foot pose controller against the Oxford Foot Model: what the ankle's path tells of the foot.

Each walk is fitted as if the foot were one piece. Of that fit the controller gets where the ankle
is, when heel, ball and toes rest (heights and speeds of the sole), and how the shank stands; of the
foot's own direction nothing: it is taken to point along the way, level. What the controller makes
of it is held against the angles the Oxford Foot Model stored in the file, in stance, beside those
of today's fit of a multi-segment foot to all markers.

The hallux is held against its markers, too: the stored angle, which hangs on a marker of the first
metatarsal head that these files do not have, does not bend at push off where the toe's line does.

Where the folder has published mean curves of the Oxford Foot Model, controller and stored angles
are both held against those, too, over the mean stance: people differ from one another as well.

Nothing was settled on these walks: the two numbers beside Park's equations (how far toes bend
before they roll onto their tips, and how the midfoot goes with the ankle) are those of published
mean curves.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from experiments.foot_segments import STORED
from experiments.stored_angles import on_clock
from experiments.table import ResultTable, Row, at_least, over_trials, sheets_of
from plantigrade.analyze.foot_angles import FOOT_ANGLES, joint_angles
from plantigrade.analyze.statistics import compare_curves
from plantigrade.analyze.trial import Trial
from plantigrade.constants import SIDES
from plantigrade.kinematics.foot_bones import NONE, foot_path, pressing, standing_height
from plantigrade.kinematics.foot_pose import FootPoser
from plantigrade.kinematics.ground_normal import hinge_turn
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.sole_rests import ContactFrames, find_rests
from plantigrade.kinematics.state import body_paths
from plantigrade.models import Human
from plantigrade.motion import Recording
from plantigrade.motion.filters import runs
from plantigrade.motion.recording import rate_of
from plantigrade.workflows.fit import fit_trial
from plantigrade.workflows.settings import FitSettings

WALKS = ("c3d/HC032A03.c3d", "c3d/HC038A11.c3d", "c3d/HC038A27.c3d")
QUICK_TRIALS = WALKS[:1]
PAIRS = ("hindfoot", "forefoot", "hallux")
MIN_CORRELATION = 0.8
"""Goal of the correlation over stance of :data:`PRESSURE_ANGLES` [1]."""
PRESSURE_ANGLES = ("hindfoot_dorsiflexion", "forefoot_dorsiflexion", "hallux_dorsiflexion")
ADULT_REPEATABILITY = 2.45
"""Largest standard error of the Oxford Foot Model in one session with markers put on anew, stance
taken as zero [Wright2011]_ [deg]."""
CHILD_REPEATABILITY = 4.61
"""Mean standard error of all its angles over two sessions in children [Mahaffey2013]_ [deg]."""


TOE_LINE = ("P1M", "TOE", "HLX")
"""Markers of the Oxford Foot Model from the first metatarsal to the hallux, after the side."""
MIN_ANGLE_RANGE = 0.5  # an angle that moves less than this has no course to correlate [deg]
STRIDE = 0.5  # the way is the ankle's path smoothed by a bell of this width [s]
PUBLISHED = "normative/oxford_foot_model"
MEAN_CURVE_FILES = {
    "hindfoot": "AHindfootTibiaDorsiflexion",
    "forefoot": "AForefootHindfootDorsiflexion",
    "hallux": "AHalluxForefootDorsiflexion",
}
"""Files of published mean curves, by percent of the cycle [deg]."""
TOE_OFF = 62.0  # in those curves [% of the cycle]
ANGLE_SOURCES = ("controller", "fit to markers")
FIGURES = ("r", "RMSE without offset", "RMSE")


def run(
    data: Path, *, quick: bool = False, say: Callable[[str], None] = lambda _: None
) -> ResultTable:
    """Return the table over the walks with stored Oxford Foot Model angles in a data folder."""
    notes = (
        "controller: from the ankle's path, the shank and what rests; it takes the foot to point "
        "along the way. fit to markers: all of them, on a multi-segment foot. Angles in deg.",
        f"Repeatability of the Oxford Foot Model itself: {ADULT_REPEATABILITY} deg at most in "
        f"adults, markers put on anew (Wright 2011); {CHILD_REPEATABILITY} deg on the mean in "
        "children (Mahaffey 2013).",
        "Two numbers of the controller were taken from the published means: agreement with them is "
        "no test of these two.",
        "What presses tells nothing of frontal and transverse angles: they are printed to show it. "
        "The stored angle of the hallux does not follow its marker: at push off it stays or turns "
        "down, while the lines between the markers bend up by 20 to 47 deg, as published means do "
        "(34 deg). Both are printed.",
    )
    title = "Foot pose from the ankle's path against the Oxford Foot Model, stance"
    names = QUICK_TRIALS if quick else WALKS
    table = over_trials(title, data, names, trial_rows, say=say, notes=notes)
    return replace(table, sheets=sheets_of("Angles in stance [deg]", table.rows))


def trial_rows(path: Path, name: str) -> list[Row]:
    """Return all rows of one trial."""
    recording, boxed = fit_trial(path, FitSettings(feet="rigid"))
    _, fitted = fit_trial(path, FitSettings(feet="multi-segment"))
    means = path.parents[len(Path(name).parts) - 1] / PUBLISHED
    return list(angle_rows(name, recording, boxed, fitted, means))


def angle_rows(
    name: str, recording: Recording, boxed: Trial, fitted: Trial, means: Path | None = None
) -> Iterator[Row]:
    """Hold every angle of controller and fit against the stored one, in stance.

    Args:
        name: Of the trial.
        recording: The recording as it was read.
        boxed: Its fit on rigid feet, of which the controller sees a part.
        fitted: Its fit on multi-segment feet.
        means: Folder of published mean curves, if it is there.
    """
    assert recording.markers is not None
    time = boxed.fit.time
    rests = find_rests(sole_paths(boxed.fit.human, boxed.fit.qpos), rate_of(time))
    for side in SIDES:
        segments = of_controller(boxed, side, rests), of_fit(fitted, side)
        stands = _stance(boxed, side)
        toes = [np.rad2deg(joint_angles(each[2], each[3], side)[:, 0]) for each in segments]
        yield from _beside_markers(name, side, toes, recording, time, stands)
        for k, pair in enumerate(PAIRS):
            stored = recording.outputs.get(side.upper() + STORED[pair])
            if stored is None:
                continue
            angles = [joint_angles(each[k], each[k + 1], side) for each in segments]
            for i, what in enumerate(FOOT_ANGLES[pair]):
                oxford = on_clock(recording.markers.time, stored[:, i], time)
                oxford = np.where(stands, oxford, np.nan)
                angle = f"{pair}_{what}"
                if (
                    i == 0
                    and means is not None
                    and (means / f"{MEAN_CURVE_FILES[pair]}.txt").exists()
                ):
                    table = np.loadtxt(means / f"{MEAN_CURVE_FILES[pair]}.txt")
                    both = {"controller": np.rad2deg(angles[0][:, 0]), "stored": oxford}
                    yield from _beside_means(name, f"{angle}_{side}", both, table, stands)
                span = float(np.nanmax(oxford) - np.nanmin(oxford))
                yield Row(name, f"{angle}_{side}, span", span, "deg")
                for who, ours in zip(ANGLE_SOURCES, angles, strict=True):
                    mine = np.rad2deg(ours[:, i])
                    moves = np.ptp(mine[np.isfinite(oxford)]) > MIN_ANGLE_RANGE
                    found = compare_curves(mine, oxford)
                    r = found.correlation if moves else np.nan
                    row = Row(name, f"{angle}_{side}, {who}, r", r if moves else None)
                    if who == ANGLE_SOURCES[0] and angle in PRESSURE_ANGLES:
                        row = at_least(name, row.quantity, r, MIN_CORRELATION)
                    yield row
                    values = (found.rmse_offset_removed, found.rmse)
                    for figure, value in zip(FIGURES[1:], values, strict=True):
                        quantity = f"{angle}_{side}, {who}, {figure}"
                        yield Row(name, quantity, value, "deg")


def of_controller(boxed: Trial, side: str, rests: Sequence[ContactFrames]) -> list[np.ndarray]:
    """Return rotations of tibia, heel, forefoot and toes as the controller has them.

    Args:
        boxed: The fit on rigid feet; it gives the ankle's path, the shank and what rests.
        side: ``"r"`` or ``"l"``.
        rests: When which region of the soles rests.
    """
    human, time, qpos = boxed.fit.human, boxed.fit.time, boxed.fit.qpos
    person = Human.from_dict({**human.to_dict(), "feet": "multi-segment", "soles": {}})
    poser = FootPoser(person, side)
    foot, shank = human.body(f"foot_{side}"), human.body(f"tibia_{side}")
    origins, rotations = body_paths(human, qpos, (foot, shank))
    ankle, tibia = origins[:, 0], rotations[:, 1]
    height = ankle[:, 2].copy()
    standing = standing_height(rests, side, height, poser.standing)
    ankle[:, 2] += poser.standing - standing
    presses = pressing(rests, side, height, standing)
    down = np.flatnonzero(presses != NONE)
    if len(down):  # swing tells nothing here: what pressed last, or will first
        presses = presses[down[np.abs(np.arange(len(time))[:, None] - down).argmin(axis=1)]]
    walked = gaussian_filter1d(ankle[:, :2], STRIDE * rate_of(time), axis=0, mode="nearest")
    way = np.gradient(walked, axis=0)
    facing = Rotation.from_euler("z", np.arctan2(way[:, 1:], way[:, :1])).as_matrix()
    path = foot_path(poser, time, ankle, facing, tibia, presses)
    heel, _, toes, _ = (
        path.rotation @ hinge_turn(path.angles[:, k : k + 3], poser.sign) for k in range(0, 12, 3)
    )
    return [tibia, heel, path.rotation, toes]


def of_fit(fitted: Trial, side: str) -> list[np.ndarray]:
    """Return rotations of tibia, heel, forefoot and toes of a fit on multi-segment feet."""
    human = fitted.fit.human
    bodies = [human.body(f"{n}_{side}") for n in ("tibia", "heel", "foot", "medial_phalanges")]
    _, rotations = body_paths(human, fitted.fit.qpos, bodies)
    return list(np.moveaxis(rotations, 1, 0))


def _beside_markers(
    name: str, side: str, angles: Sequence[np.ndarray], recording: Recording, time, stands
) -> Iterator[Row]:
    """Hold the hallux against its markers: the toe's line against the first metatarsal's.

    The elevation of the line from between the heads of the second and third metatarsals to the
    hallux, less that of the line from the base of the first metatarsal to those heads [deg]. It
    needs no virtual marker and no axes.
    """
    markers = recording.markers
    assert markers is not None
    if not {side.upper() + n for n in TOE_LINE} <= set(markers.names):
        return
    base, head, hallux = (
        markers.positions[:, markers.names.index(side.upper() + n)] for n in TOE_LINE
    )
    lines = np.array([head - base, hallux - head])
    rise = np.rad2deg(np.arcsin(lines[..., 2] / np.linalg.norm(lines, axis=2)))
    seen = np.where(stands, on_clock(markers.time, rise[1] - rise[0], time), np.nan)
    angle = f"hallux_by_markers_{side}"
    yield Row(name, f"{angle}, span", float(np.nanmax(seen) - np.nanmin(seen)), "deg")
    for who, ours in zip(ANGLE_SOURCES, angles, strict=True):
        found = compare_curves(ours, seen)
        r = found.correlation
        row = Row(name, f"{angle}, {who}, r", r)
        yield at_least(name, row.quantity, r, MIN_CORRELATION) if who == ANGLE_SOURCES[0] else row
        yield Row(name, f"{angle}, {who}, RMSE without offset", found.rmse_offset_removed, "deg")


def _beside_means(name: str, angle: str, curves, table, stands) -> Iterator[Row]:
    """Hold the mean stance of a curve against a published one, the offset removed."""
    over = np.linspace(0.0, 1.0, 101)
    published = np.interp(TOE_OFF * over, table[:, 0], table[:, 2])
    for who, curve in curves.items():
        whole = [r for r in runs(stands) if np.isfinite(curve[r]).all()]
        if whole:
            steps = [
                np.interp(over * (r.stop - r.start - 1), range(r.stop - r.start), curve[r])
                for r in whole
            ]
            mean, of = np.mean(steps, axis=0), f"{angle}, {who} against published mean"
            found = compare_curves(mean, published)
            yield Row(name, f"{of}, r", found.correlation)
            yield Row(name, f"{of}, RMSE without offset", found.rmse_offset_removed, "deg")


def _stance(trial: Trial, side: str) -> np.ndarray:
    """Return in which frames a foot stands, from a heel strike to the next toe off."""
    time, out, landed = trial.fit.time, np.zeros(len(trial.fit.time), bool), None
    for event in sorted(trial.motion.events, key=lambda e: e.time):
        if event.side == side and event.kind == "heel_strike":
            landed = event.time
        elif event.side == side and event.kind == "toe_off" and landed is not None:
            out |= (time >= landed) & (time <= event.time)
            landed = None
    return out

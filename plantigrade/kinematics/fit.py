"""Fit of a marker recording: scale the person, solve every frame, detect outliers.

:func:`fit_markers` is the whole path: turn the recording so that the person faces x, choose
frames, scale with :func:`plantigrade.kinematics.calibrate.calibrate`, solve every frame with
:class:`plantigrade.kinematics.inverse.InverseKinematics`, exclude outliers, and report problems.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.arm_tracking import track_arms
from plantigrade.kinematics.calibrator import noise_factor
from plantigrade.kinematics.flat_feet import with_resting_soles
from plantigrade.kinematics.given_ground import GivenGround
from plantigrade.kinematics.inverse import InverseKinematics
from plantigrade.kinematics.joint_distances import late_notes
from plantigrade.kinematics.keypoints import TILT_OF_VIDEO, BonesOfVideo, force_band_factor
from plantigrade.kinematics.knee_height import knee_notes
from plantigrade.kinematics.marker_doubts import (
    error_notes,
    scale_notes,
    slip_notes,
    twin_notes,
    unseen_notes,
)
from plantigrade.kinematics.plausibility import lean_notes
from plantigrade.kinematics.posture import pelvis_notes, posture_figures
from plantigrade.kinematics.posture_prior import PosturePrior
from plantigrade.kinematics.prepare import Prepared, columns, prepare
from plantigrade.kinematics.result import Fit
from plantigrade.kinematics.scaled_body import ScaledBody, scale
from plantigrade.kinematics.side_doubts import side_notes
from plantigrade.kinematics.spine_doubts import sideways_notes, spine_notes, tilt_notes
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.unmeasured_joints import (
    follow_the_legs,
    measured_hinges,
    note,
    unmeasured,
)
from plantigrade.kinematics.unmeasured_toes import (
    toes_on_ground,
    unseen_toes_follow,
    with_flat_feet,
)
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment
from plantigrade.models.markers import MarkerSet, landmark_names, landmarks_of
from plantigrade.models.person import Person
from plantigrade.motion import Markers, Recording
from plantigrade.printable import listed
from plantigrade.spatial.conventions import rotation_matrix

MIN_OUTLIER_ERROR = 0.05  # [m] minimum error of an outlier …
MIN_OUTLIER_RATIO = 6.0  # [1] … and its minimum ratio to the marker's usual error
MIN_KNEE_RANGE = np.deg2rad(15.0)
"""Smallest motion of the knees that shows the segment of a marker of unknown name [rad]."""
MAX_SWAP_RATIO = 0.4  # [1] maximum ratio of errors after and before swapping two markers


def fit_markers(
    recording: Recording,
    person: Person | None = None,
    *,
    static: Recording | None = None,
    marker_set: MarkerSet | None = None,
    ground: GivenGround | None = None,
    body: ScaledBody | None = None,
) -> Fit:
    """Fit a scaled person to a marker recording.

    Args:
        recording: The recording; it must have markers.
        person: Known properties of the person; the recording's metadata supply others.
        static: A standing trial of the same person with the same markers, if there is one.
        marker_set: Marker positions; by default the built-in set with the most known names.
        ground: Slope or steps on which the feet stand; by default level at the plates' height.
        body: Scaled body shared by the person's trials; by default scaled to this one alone.

    Raises:
        FitError: If the recording has no markers, too few known ones, or no usable frame, or the
            feet do not stand on the given ground.
    """
    trial = prepare(recording, person, static=static, marker_set=marker_set, ground=ground)
    body = body or scale([trial], marker_set=marker_set)
    recording, own, window = trial.recording, trial.markers, trial.window
    fitted, places = _tracked(trial, body)
    solver = _solver(body.human, places, trial.video)
    qpos, residual, kept, repairs = _follow(solver, fitted, body.start(recording.source))
    human, qpos, assumed = _on_ground(trial, body, fitted, places, qpos, solver.points)
    figures = _marker_figures(trial, body, human, residual, kept)
    posture = _without_assumed(posture_figures(human, qpos, body.standing), assumed)
    error = 1e-3 * figures["marker_rms_mean_mm"]
    wrong = [] if trial.video else _doubts(fitted, places, body, human, qpos, marker_set, error)
    faults = _faults(trial, fitted, places, body, human, qpos)
    others = [*repairs, *note(assumed, "no marker"), *lean_notes(rotation_matrix(qpos[:, 3:7]))]
    others += _marker_notes(trial, body)
    band = force_band_factor(trial.video.noise, fitted.names) if trial.video else 1.0
    return Fit(
        human=human,
        time=fitted.time,
        qpos=qpos,
        recording=replace(
            recording, markers=Markers(own.names, fitted.time, own.positions[window])
        ),
        source_kind="markers",
        markers=fitted,
        places=places,
        residual=residual,
        kept=kept,
        attached=dict(body.attached),
        heading=trial.heading,
        metrics={**figures, **posture},
        assumed=assumed,
        force_band_factor=band,
        ground=body.floor(recording),
        warnings=(*recording.warnings, *wrong, *faults, *body.notes, *trial.notes, *others),
        doubts=tuple(wrong),
    )


def _tracked(trial: Prepared, body: ScaledBody) -> tuple[Markers, tuple[Attachment, ...]]:
    """Return the markers of the body that the trial has, in its window, and their places."""
    markers, own = trial.markers, set(trial.names) & set(trial.markers.names)
    which = [i for i, n in enumerate(body.names) if n in own]
    names = tuple(body.names[i] for i in which)
    samples = columns(markers, names)[trial.window].copy()
    return Markers(names, markers.time[trial.window], samples), tuple(body.places[i] for i in which)


def _solver(
    human: Human, places: Sequence[Attachment], video: BonesOfVideo | None
) -> InverseKinematics:
    """Return inverse kinematics that weigh each marker by its noise, with a prior for video."""
    weights = np.array([1 / noise_factor(p) ** 2 for p in places])
    solver = InverseKinematics(PointSet.of(human, places), weights)
    if video is not None:
        PosturePrior.of(human, video).set_on(solver)
    return solver


def _on_ground(
    trial: Prepared,
    body: ScaledBody,
    fitted: Markers,
    places: Sequence[Attachment],
    qpos: Float[Array, "n_frames nq"],
    points: PointSet,
) -> tuple[Human, Float[Array, "n_frames nq"], tuple[str, ...]]:
    """Return person and poses with soles on the ground, and coordinates that no marker shows."""
    human, floor = body.human, body.floor(trial.recording)
    if body.grounded:
        human = with_resting_soles(human, places, fitted.time, qpos, ground=floor)
    if trial.video is not None:
        qpos = with_flat_feet(human, fitted.names, fitted.time, qpos)
    qpos = toes_on_ground(human, places, qpos, ground=floor)
    qpos = unseen_toes_follow(human, places, qpos)
    seen = measured_hinges(points)
    return human, follow_the_legs(human, fitted.time, qpos, seen), unmeasured(human, seen)


def _doubts(
    fitted: Markers,
    places: Sequence[Attachment],
    body: ScaledBody,
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    marker_set: MarkerSet | None,
    error: float,
) -> list[str]:
    """Return what in the markers speaks against the fit: scale, lag, spine, sides, knees, tilt."""
    known, marks = landmarks_of(fitted.names, marker_set), landmark_names(fitted.names, marker_set)
    bent = qpos[:, [7 + human.hinge(f"knee_angle_{side}") for side in SIDES]]
    walks = np.ptp(bent, axis=0).min() > MIN_KNEE_RANGE
    return [
        *scale_notes(places, fitted.positions),
        *late_notes(places, fitted.rate, fitted.positions),
        *spine_notes(fitted, marks, places),
        *side_notes(fitted, known, human, qpos),
        *knee_notes(fitted, known, places, human, qpos),
        *tilt_notes(human, qpos, body.standing),
        *sideways_notes(fitted, marks, human, qpos),
        *(twin_notes(body.attached, fitted.names) if walks else ()),
        *error_notes(error),
    ]


def _faults(
    trial: Prepared,
    fitted: Markers,
    places: Sequence[Attachment],
    body: ScaledBody,
    human: Human,
    qpos: Float[Array, "n_frames nq"],
) -> list[str]:
    """Return what limits the fit: an uncertain tilt of the pelvis, gaps, markers that slip."""
    gaps = unseen_notes(places, fitted.time, fitted.positions)
    if trial.video:
        return [TILT_OF_VIDEO, *gaps]
    slips = slip_notes(human, fitted.names, places, fitted.time, qpos, fitted.positions)
    return [*pelvis_notes(human, places, body.attached), *gaps, *slips]


def _marker_notes(trial: Prepared, body: ScaledBody) -> list[str]:
    """Return notes on markers of unknown name, and on unused ones with the reason."""
    notes, own = [], trial.markers.names
    unknown = [n for n in body.attached if n in own and n in trial.names]
    if unknown:
        notes.append(
            f"{len(unknown)} markers with unknown names were assigned to the segment they move "
            "with: " + listed([f"{n} on {body.attached[n]}" for n in unknown], 12) + "."
        )
    loose = {n: "moves with no segment of the body" for n in trial.names if n not in body.names}
    lost = {n: why for n, why in {**trial.ignored, **loose}.items() if n in own}
    if lost:
        notes.append(
            f"{len(lost)} markers were not used: "
            + listed([f"{n} ({why})" for n, why in lost.items()], between="; ")
            + "."
        )
    return notes


def _without_assumed(figures: dict[str, Any], assumed: Sequence[str]) -> dict[str, Any]:
    """Return figures of posture without those of unmeasured trunk, head and arms."""
    of = {"trunk": "lumbar_extension", "neck": "neck_extension", "arms": "elbow_flex_r"}
    hidden = tuple(f"{part}_" for part, joint in of.items() if joint in assumed)
    return {name: value for name, value in figures.items() if not name.startswith(hidden)}


def _follow(solver: InverseKinematics, fitted: Markers, first: Float[Array, " nq"]):
    """Solve all frames, correct swapped markers, exclude outliers, and solve again."""
    samples, names = fitted.positions, fitted.names
    qpos, residual = track_arms(solver, samples, first)
    suspects = _suspects(residual)
    if not suspects.any():
        return qpos, residual, np.isfinite(residual), []
    swapped: Counter[tuple[str, str]] = Counter()
    for _ in range(2):
        # solve the affected frames without the suspects
        clean = np.where(suspects[..., None], np.nan, samples)
        for f in np.flatnonzero(suspects.any(axis=1)):
            model = solver.values(solver.solve(clean[f], qpos[max(f - 1, 0)]).qpos)
            _unswap(samples[f], model, names, suspects[f], swapped)
            suspects[f] &= ~(np.linalg.norm(samples[f] - model, axis=1) < MIN_OUTLIER_ERROR)
        qpos, _ = track_arms(solver, np.where(suspects[..., None], np.nan, samples), first)
        residual = np.linalg.norm(samples - solver.points.path(qpos), axis=2)
        again = _suspects(residual)
        if not (again & ~suspects).any():
            break
        suspects |= again
    notes = [
        f"markers {a} and {b} are swapped in {count} frames; this was corrected."
        for (a, b), count in swapped.items()
    ]
    left_out = {name: int(k) for name, k in zip(names, suspects.sum(axis=0), strict=True) if k}
    if left_out:
        frames = ", ".join(f"{name} in {k} frames" for name, k in left_out.items())
        notes.append(f"outlier samples were discarded: {frames}.")
    return qpos, residual, np.isfinite(residual) & ~suspects, notes


def _suspects(residual: Float[Array, "n_frames n_markers"]) -> Bool[Array, "n_frames n_markers"]:
    usual = np.nanmedian(residual, axis=0)
    usual = np.where(np.isfinite(usual), usual, 0.0)
    floor = np.nanmedian(usual)
    limit = np.maximum(MIN_OUTLIER_ERROR, MIN_OUTLIER_RATIO * np.minimum(usual, 2 * floor))
    return np.nan_to_num(residual) > limit


def _unswap(frame, model, names, suspects, swapped) -> None:
    """Exchange pairs of markers of one frame that fit far better when swapped."""
    distance = np.linalg.norm(frame[:, None] - model[None], axis=2)  # sample i to place j
    for i in np.flatnonzero(suspects):
        for j in range(len(names)):
            if j == i or not np.isfinite(distance[j, j]):
                continue
            now = distance[i, i] + distance[j, j]
            other = distance[i, j] + distance[j, i]
            if other < MAX_SWAP_RATIO * now and other < 2 * MIN_OUTLIER_ERROR:
                frame[[i, j]] = frame[[j, i]]
                distance[[i, j]] = distance[[j, i]]
                swapped[min(names[i], names[j]), max(names[i], names[j])] += 1
                break


def _marker_figures(
    trial: Prepared,
    body: ScaledBody,
    human: Human,
    residual: Float[Array, "n_frames n_markers"],
    kept: Bool[Array, "n_frames n_markers"],
) -> dict[str, Any]:
    """Return figures of the marker errors, of the person's lengths, and of what was corrected."""
    used = np.where(kept, residual, np.nan)
    shown, seen = np.isfinite(used), np.isfinite(residual)
    per_frame = np.sqrt(np.nanmean(used[shown.any(axis=1)] ** 2, axis=1))
    per_marker = np.sqrt(np.nanmean(used[:, shown.any(axis=0)] ** 2, axis=0))
    d = human.dimensions
    return {
        "marker_rms_mean_mm": 1e3 * float(np.nanmean(per_frame)),
        "marker_rms_worst_frame_mm": 1e3 * float(np.nanmax(per_frame)),
        "marker_rms_worst_marker_mm": 1e3 * float(np.nanmax(per_marker)),
        "marker_error_max_mm": 1e3 * float(np.nanmax(used)),
        "markers_used": int(used.shape[1]),
        "samples_left_out": int((seen & ~kept).sum()),
        "height_m": human.height,
        **{f"length_{n}_m": getattr(d, n) for n in d.names()},
        **({"standing_rms_mm": 1e3 * body.standing_rms} if len(body.standing) else {}),
        "height_estimated": trial.person.height is None,
        "labels_exchanged": [list(cycle) for cycle in trial.exchanged],
    }

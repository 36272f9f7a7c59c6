"""Fit of a marker recording: scale the person, solve every frame, detect outliers.

:func:`fit_markers` is the whole path: turn the recording so that the person faces x, choose
frames, scale with :func:`plantigrade.kinematics.calibrate.calibrate`, solve every frame with
:class:`plantigrade.kinematics.inverse.InverseKinematics`, exclude outliers, and report problems.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.arm_tracking import track_arms
from plantigrade.kinematics.axis_scale import scale_notes
from plantigrade.kinematics.calibrator import noise_factor
from plantigrade.kinematics.flat_feet import with_resting_soles
from plantigrade.kinematics.given_ground import GivenGround
from plantigrade.kinematics.inverse import InverseKinematics
from plantigrade.kinematics.joint_distances import late_notes
from plantigrade.kinematics.keypoints import TILT_OF_VIDEO, force_band_factor
from plantigrade.kinematics.knee_height import knee_notes
from plantigrade.kinematics.marker_doubts import error_notes, slip_notes, twin_notes, unseen_notes
from plantigrade.kinematics.plausibility import lean_notes
from plantigrade.kinematics.posture import pelvis_notes, posture_figures
from plantigrade.kinematics.posture_prior import PosturePrior
from plantigrade.kinematics.prepare import columns, prepare
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
from plantigrade.kinematics.unmeasured_toes import toes_on_ground, unseen_toes_follow
from plantigrade.kinematics.unseen_feet import with_flat_feet
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
        ground: Slope or steps on which the feet stand; level at the height of the plates if not
            given.
        body: Scaled body shared by trials of this person; by default scaled to this recording
            alone.

    Raises:
        FitError: If the recording has no markers, too few known ones, or no usable frame, or the
            feet do not stand on the given ground.
    """
    trial = prepare(recording, person, static=static, marker_set=marker_set, ground=ground)
    body = body or scale([trial], marker_set=marker_set)
    recording, markers, window = trial.recording, trial.markers, trial.window
    notes = [*body.notes, *trial.notes]
    ignored = {
        **trial.ignored,
        **{n: "moves with no segment of the body" for n in trial.names if n not in body.names},
    }
    floor = body.floor(recording)
    own = set(trial.names) & set(markers.names)
    in_trial = [i for i, n in enumerate(body.names) if n in own]
    tracked = [body.names[i] for i in in_trial]
    samples = columns(markers, tracked)[window]
    human, places = body.human, tuple(body.places[i] for i in in_trial)
    solver = InverseKinematics(
        PointSet.of(human, places), np.array([1 / noise_factor(p) ** 2 for p in places])
    )
    if trial.video is not None:
        PosturePrior.of(human, trial.video).set_on(solver)
    start = body.start(recording.source)
    qpos, residual, kept, more = _follow(solver, samples, tracked, start)
    notes += more
    if body.grounded:
        human = with_resting_soles(human, places, markers.time[window], qpos, ground=floor)
    if trial.video is not None:
        qpos = with_flat_feet(human, tracked, markers.time[window], qpos)
    qpos = toes_on_ground(human, places, qpos, ground=floor)
    qpos = unseen_toes_follow(human, places, qpos)
    seen = measured_hinges(solver.points)
    assumed = unmeasured(human, seen)
    qpos = follow_the_legs(human, markers.time[window], qpos, seen)
    notes += note(assumed, "no marker")
    tilt = [TILT_OF_VIDEO] if trial.video else pelvis_notes(human, places, body.attached)
    slips = (
        []
        if trial.video
        else slip_notes(human, tracked, places, markers.time[window], qpos, samples)
    )
    gaps = unseen_notes(places, markers.time[window], samples)
    used = np.where(kept, residual, np.nan)
    figures = _metrics(used, human, kept, np.isfinite(residual))
    fitted = Markers(tuple(tracked), markers.time[window], samples)
    wrong: list[str] = []
    if trial.video is None:
        wrong = _doubts(fitted, places, body, human, qpos, marker_set)
        wrong += error_notes(1e-3 * figures["marker_rms_mean_mm"])
    notes = wrong + tilt + gaps + slips + notes
    notes += lean_notes(rotation_matrix(qpos[:, 3:7]))
    cut = replace(
        recording, markers=Markers(markers.names, markers.time[window], markers.positions[window])
    )
    _add_marker_notes(
        notes, body.attached, tracked, {n: w for n, w in ignored.items() if n in markers.names}
    )
    posture = posture_figures(human, qpos, body.standing)
    return Fit(
        human=human,
        time=markers.time[window],
        qpos=qpos,
        recording=cut,
        source_kind="markers",
        markers=fitted,
        places=places,
        residual=residual,
        kept=kept,
        attached=dict(body.attached),
        heading=trial.heading,
        metrics={
            **figures,
            **({"standing_rms_mm": 1e3 * body.standing_rms} if len(body.standing) else {}),
            **_without_assumed(posture, assumed),
            "height_estimated": trial.person.height is None,
            "labels_exchanged": [list(cycle) for cycle in trial.exchanged],
        },
        assumed=assumed,
        force_band_factor=force_band_factor(trial.video.noise, tracked) if trial.video else 1.0,
        ground=floor,
        warnings=tuple(recording.warnings) + tuple(notes),
        doubts=tuple(wrong),
    )


def _doubts(
    fitted: Markers,
    places: Sequence[Attachment],
    body: ScaledBody,
    human: Human,
    qpos: Float[Array, "n_frames nq"],
    marker_set: MarkerSet | None,
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
    ]


def _add_marker_notes(
    notes: list[str], attached: Mapping[str, str], tracked: Sequence[str], lost: Mapping[str, str]
) -> None:
    """Add notes on markers of unknown name, and on unused ones with the reason."""
    unknown = [n for n in attached if n in tracked]
    if unknown:
        notes.append(
            f"{len(unknown)} markers with unknown names were assigned to the segment they move "
            "with: " + listed([f"{n} on {attached[n]}" for n in unknown], 12) + "."
        )
    if lost:
        notes.append(
            f"{len(lost)} markers were not used: "
            + listed([f"{n} ({why})" for n, why in lost.items()], between="; ")
            + "."
        )


def _without_assumed(figures: dict[str, Any], assumed: Sequence[str]) -> dict[str, Any]:
    """Return figures of posture without those of unmeasured trunk, head and arms."""
    of = {"trunk": "lumbar_extension", "neck": "neck_extension", "arms": "elbow_flex_r"}
    hidden = tuple(f"{part}_" for part, joint in of.items() if joint in assumed)
    return {name: value for name, value in figures.items() if not name.startswith(hidden)}


def _follow(
    solver: InverseKinematics,
    samples: Float[Array, "n_frames n_markers 3"],
    names: Sequence[str],
    first: Float[Array, " nq"],
):
    """Solve all frames, correct swapped markers, exclude outliers, and solve again."""
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


def _metrics(used, human: Human, kept, seen) -> dict:
    shown = np.isfinite(used)
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
    }

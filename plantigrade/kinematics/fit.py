"""Fit a marker recording: scale the person, solve every frame, detect wrong samples.

:func:`fit_markers` is the whole path: turn the recording so that the person faces x, choose
frames, scale with :func:`plantigrade.kinematics.calibrate.calibrate`, solve every frame with
:class:`plantigrade.kinematics.inverse.InverseKinematics`, leave out samples that cannot be right,
and say what was noticed.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.ground import Ground
from plantigrade.errors import FitError
from plantigrade.kinematics.calibrate import (
    Calibration,
    calibrate,
    require_known,
    softness,
)
from plantigrade.kinematics.flat_feet import set_flat, settled
from plantigrade.kinematics.given_ground import GivenGround, below_feet
from plantigrade.kinematics.ground_level import ground_height
from plantigrade.kinematics.inverse import InverseKinematics, track
from plantigrade.kinematics.label_repair import relabelled
from plantigrade.kinematics.plausible import (
    lean_notes,
    require_human_size,
    require_one_person,
    without_far_samples,
)
from plantigrade.kinematics.posture import pelvis_notes, posture_figures
from plantigrade.kinematics.result import Fit, Progress, counter, filled, human_of, listed
from plantigrade.kinematics.standing_poses import standing_poses
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.unknown_size import with_unknown_size
from plantigrade.kinematics.unmeasured import follow_the_legs, note, seen_hinges, unmeasured
from plantigrade.kinematics.unseen_toes import toes_on_ground, unseen_toes_follow
from plantigrade.models.markers import MarkerSet, place_markers
from plantigrade.models.person import Person
from plantigrade.motion import Markers, Recording
from plantigrade.motion.filters import runs
from plantigrade.motion.turning import quarter_turn_to_face_x, turn
from plantigrade.spatial.conventions import rotation_matrix

USUAL_HEIGHT = 1.72  # where none is given: the start of the calibration [m]
CALIBRATION_FRAMES = 24  # of the trial; enough to see each joint through its range
STATIC_FRAMES = 6  # of a standing trial, evenly spread
VISIBLE = 0.75  # share of the markers a frame must show to be fitted
FLYING = 0.05  # a sample this far off its place [m] is looked at …
FLYING_FACTOR = 6.0  # … and left out if it also is this many times the marker's usual error
FEWEST_SHARED = 6  # known markers a standing trial must have in common with the recording
SWAP_GAIN = 0.4  # two markers were swapped where swapping leaves less than this of their error


def fit_markers(
    recording: Recording,
    person: Person | None = None,
    *,
    static: Recording | None = None,
    marker_set: MarkerSet | None = None,
    ground: GivenGround | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Fit a scaled person to a marker recording.

    Args:
        recording: The recording; it must have markers.
        person: What is known about who was recorded; the recording's own words fill the rest.
        static: A standing trial of the same person with the same markers, if there is one.
        marker_set: Where markers sit; the built-in set that knows most names if not given.
        ground: Slope or steps on which the feet stand; level at the height of the plates if not
            given.
        progress: Called with (what, done, total).

    Raises:
        FitError: If the recording has no markers, too few known ones, or no usable frame, or the
            feet do not stand on the given ground.
    """
    if static is not None:
        beside = replace(static.subject, date=None)  # that of another recording
        recording = replace(recording, subject=filled(recording.subject, beside))
    person = filled(person or Person(), recording.subject)
    markers = recording.markers
    if markers is None or not markers.names:
        raise FitError(f"{recording.source} has no markers to fit")
    notes: list[str] = []
    names, ignored = _usable(markers)
    if static is not None and static.markers is not None:
        seen = np.any(np.isfinite(static.markers.positions[..., 0]), axis=0)
        shown = zip(static.markers.names, seen, strict=True)
        names += [n for n, ever in shown if ever and n not in markers.names]
    start, stop = _longest_visible(markers, [n for n in names if n in markers.names])
    if start > 0 or stop < markers.n_frames:
        notes.append(
            f"markers are missing at the ends: {stop - start} of {markers.n_frames} frames were "
            f"fitted, {markers.time[start]:.2f} to {markers.time[stop - 1]:.2f} s."
        )
    age = recording.subject.age
    human = human_of(person, person.height or USUAL_HEIGHT, age=age)
    placed = place_markers(names, human, marker_set)
    known = [n for n in names if placed[n] is not None and n in markers.names]
    require_known([n for n in names if n in markers.names], placed)
    require_one_person(known, recording.source)
    require_human_size(_columns(markers, known)[start:stop], recording.source)
    right = relabelled(recording, static, human, names, placed)
    recording, static, markers = right.recording, right.static, right.recording.markers
    assert markers is not None
    notes += right.notes
    recording, far = without_far_samples(recording)
    if far:
        notes.append(f"{far} samples metres away from the person were discarded.")
    markers = recording.markers
    assert markers is not None
    angle = quarter_turn_to_face_x(_facing(human, known, placed, markers, start, stop))
    angle -= 0.0 if ground is None else ground.heading
    recording = turn(recording, angle)
    markers = recording.markers
    assert markers is not None
    still = _static_frames(static, names, human, known, placed)
    measured = _columns(markers, names)
    chosen = _choose_frames(measured, start, stop, CALIBRATION_FRAMES)
    calibration = calibrate(
        human,
        names,
        placed,
        np.concatenate([still, measured[chosen]]),
        height=person.height,
        standing=np.arange(len(still) + len(chosen)) < len(still),
        progress=counter(progress, "scaling the body", 25),
    )
    human, more = with_unknown_size(calibration.human, calibration.places, person, age)
    calibration = replace(calibration, human=human)
    notes += more
    for name in names:
        if name not in calibration.names:
            ignored[name] = "moves with no segment of the body"
    window = slice(start, stop)
    where = [names.index(n) for n in calibration.names]
    first = calibration.qpos[len(still)]
    if ground is None:
        floor = Ground(height=ground_height(recording))
    else:
        solver = InverseKinematics(PointSet.of(calibration.human, calibration.places))
        followed, _ = track(solver, measured[window][:, where], first)
        floor = below_feet(ground.shape, calibration.human, markers.time[window], followed)
    feet = set_flat(
        calibration.human,
        calibration.places,
        measured[window][:, where],
        still[:, where],
        markers.rate,
        first,
        ground=floor,
    )
    calibration = replace(calibration, human=feet.human, places=feet.places)
    notes += feet.notes
    in_trial = [i for i, n in enumerate(calibration.names) if n in markers.names]
    tracked = [calibration.names[i] for i in in_trial]
    samples = _columns(markers, tracked)[window]
    places = tuple(calibration.places[i] for i in in_trial)
    solver = InverseKinematics(
        PointSet.of(calibration.human, places), np.array([1 / softness(p) ** 2 for p in places])
    )
    qpos, residual, kept, more = _follow(solver, samples, tracked, first, progress)
    notes += more
    if feet.grounded:
        human = settled(calibration.human, places, markers.time[window], qpos, ground=floor)
        calibration = replace(calibration, human=human)
    qpos = toes_on_ground(calibration.human, places, qpos, ground=floor)
    qpos = unseen_toes_follow(calibration.human, places, qpos)
    seen = seen_hinges(solver.points)
    assumed = unmeasured(calibration.human, seen)
    qpos = follow_the_legs(calibration.human, markers.time[window], qpos, seen)
    notes += note(assumed, "no marker")
    notes += pelvis_notes(calibration.human, places)
    notes += lean_notes(rotation_matrix(qpos[:, 3:7]))
    cut = replace(
        recording,
        markers=Markers(markers.names, markers.time[window], markers.positions[window]),
    )
    unknown = [n for n in calibration.attached if n in tracked]
    if unknown:
        notes.append(
            f"{len(unknown)} markers with unknown names were assigned to the segment they move "
            "with: " + listed([f"{n} on {calibration.attached[n]}" for n in unknown], 12) + "."
        )
    lost = [n for n in ignored if n in markers.names]
    if lost:
        notes.append(
            f"{len(lost)} markers were not used: "
            + listed([f"{n} ({ignored[n]})" for n in lost], between="; ")
            + "."
        )
    used = np.where(kept, residual, np.nan)
    return Fit(
        human=calibration.human,
        time=markers.time[window],
        qpos=qpos,
        recording=cut,
        source_kind="markers",
        markers=Markers(tuple(tracked), markers.time[window], samples),
        places=places,
        residual=residual,
        kept=kept,
        attached=calibration.attached,
        heading=angle,
        metrics={
            **_metrics(used, calibration, kept, np.isfinite(residual)),
            **_without_assumed(
                posture_figures(calibration.human, qpos, calibration.qpos[: len(still)]), assumed
            ),
            "height_estimated": person.height is None,
            "labels_exchanged": [list(cycle) for cycle in right.exchanged],
        },
        assumed=assumed,
        ground=floor,
        warnings=tuple(recording.warnings) + tuple(notes),
    )


def _without_assumed(figures: dict[str, Any], assumed: Sequence[str]) -> dict[str, Any]:
    """Return figures of posture without those of trunk, head and arms that nothing showed."""
    of = {"trunk": "lumbar_extension", "neck": "neck_extension", "arms": "elbow_flex_r"}
    hidden = tuple(f"{part}_" for part, joint in of.items() if joint in assumed)
    return {name: value for name, value in figures.items() if not name.startswith(hidden)}


def _usable(markers: Markers) -> tuple[list[str], dict[str, str]]:
    """Return the markers worth fitting and the reason for each that is not."""
    names, ignored = [], {}
    for i, name in enumerate(markers.names):
        x = markers.positions[:, i]
        seen = np.isfinite(x[:, 0])
        if not seen.any():
            ignored[name] = "never seen"
        elif any(
            np.array_equal(x, markers.positions[:, markers.index(n)], equal_nan=True) for n in names
        ):
            ignored[name] = "the same trajectory as another marker"
        else:
            names.append(name)
    return names, ignored


def _columns(markers: Markers, names: Sequence[str]) -> Float[Array, "n_frames n_names 3"]:
    """Return the positions of ``names``; NaN where the recording lacks the marker."""
    out = np.full((markers.n_frames, len(names), 3), np.nan)
    for k, name in enumerate(names):
        if name in markers.names:
            out[:, k] = markers.positions[:, markers.index(name)]
    return out


def _longest_visible(markers: Markers, names: Sequence[str]) -> tuple[int, int]:
    """Return the longest run of frames that show enough of the markers."""
    x = _columns(markers, names)
    ever = np.isfinite(x[..., 0]).mean(axis=0) > 0.3
    share = np.isfinite(x[:, ever, 0]).mean(axis=1) if ever.any() else np.zeros(len(x))
    good = share >= VISIBLE
    if not good.any():
        raise FitError(
            f"no frame shows {VISIBLE:.0%} of the markers (best {share.max():.0%}); "
            "fill the gaps first, or give a marker set for the visible markers"
        )
    inner = slice(good.argmax(), len(good) - good[::-1].argmax())
    for gap in runs(~good[inner]):  # inverse kinematics tolerates short ones
        if gap.stop - gap.start <= 0.25 * markers.rate:
            good[inner][gap] = True
    longest = max(runs(good), key=lambda run: run.stop - run.start)
    count = longest.stop - longest.start
    if count < 3:
        raise FitError(
            f"only {count} of {markers.n_frames} frames in a row show enough markers; at "
            "least 3 are needed: record longer, or fill the gaps"
        )
    return longest.start, longest.stop


def _facing(human, known, placed, markers, start, stop) -> float:
    """Return the median direction the pelvis and trunk face, from x towards y [rad]."""
    frames = np.unique(np.linspace(start, stop - 1, 15).astype(int))
    q = standing_poses(human, [placed[n] for n in known], _columns(markers, known)[frames])
    return float(np.angle(np.mean((q[:, 3] + 1j * q[:, 6]) ** 2)))


def _static_frames(static, names, human, known, placed):
    """Return the markers of some standing frames, turned to face x."""
    if static is None or static.markers is None:
        return np.empty((0, len(names), 3))
    markers = static.markers
    common = [n for n in known if n in markers.names]
    if len(common) < FEWEST_SHARED:
        raise FitError(
            f"the standing trial {static.source} shares {len(common)} known markers with the "
            f"recording; {FEWEST_SHARED} are needed: name one with the same markers"
        )
    start, stop = _longest_visible(markers, [n for n in names if n in markers.names])
    angle = quarter_turn_to_face_x(_facing(human, common, placed, markers, start, stop))
    turned = turn(static, angle).markers
    assert turned is not None
    frames = np.unique(np.linspace(start, stop - 1, STATIC_FRAMES).astype(int))
    return _columns(turned, names)[frames]


def _choose_frames(measured, start: int, stop: int, count: int) -> np.ndarray:
    """Return frames spread over the trial, each the best seen one of its stretch."""
    share = np.isfinite(measured[..., 0]).mean(axis=1)
    stretches = np.array_split(np.arange(start, stop), min(count, stop - start))
    # The middle of the stretch unless another frame of it is seen better.
    return np.array(
        [min(s, key=lambda f, s=s: (-share[f], abs(f - s[len(s) // 2]))) for s in stretches]
    )


def _follow(
    solver: InverseKinematics,
    samples: Float[Array, "n_frames n_markers 3"],
    names: Sequence[str],
    first: Float[Array, " nq"],
    progress: Progress | None,
):
    """Solve all frames; put back swapped markers and leave out flying ones, then solve again."""
    report = counter(progress, "following the markers", len(samples))
    qpos, residual = track(solver, samples, first, report)
    suspects = _suspects(residual)
    if not suspects.any():
        return qpos, residual, np.isfinite(residual), []
    swapped: Counter[tuple[str, str]] = Counter()
    for _ in range(2):
        # What the others say: solve the frames concerned without the suspects.
        clean = np.where(suspects[..., None], np.nan, samples)
        for f in np.flatnonzero(suspects.any(axis=1)):
            model = solver.values(solver.solve(clean[f], qpos[max(f - 1, 0)]).qpos)
            _unswap(samples[f], model, names, suspects[f], swapped)
            suspects[f] &= ~(np.linalg.norm(samples[f] - model, axis=1) < FLYING)
        qpos, _ = track(solver, np.where(suspects[..., None], np.nan, samples), first)
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
    limit = np.maximum(FLYING, FLYING_FACTOR * np.minimum(usual, 2 * floor))
    return np.nan_to_num(residual) > limit


def _unswap(frame, model, names, suspects, swapped) -> None:
    """Exchange pairs of markers of one frame that fit far better the other way round."""
    distance = np.linalg.norm(frame[:, None] - model[None], axis=2)  # sample i to place j
    for i in np.flatnonzero(suspects):
        for j in range(len(names)):
            if j == i or not np.isfinite(distance[j, j]):
                continue
            now = distance[i, i] + distance[j, j]
            other = distance[i, j] + distance[j, i]
            if other < SWAP_GAIN * now and other < 2 * FLYING:
                frame[[i, j]] = frame[[j, i]]
                distance[[i, j]] = distance[[j, i]]
                swapped[min(names[i], names[j]), max(names[i], names[j])] += 1
                break


def _metrics(used, calibration: Calibration, kept, seen) -> dict:
    shown = np.isfinite(used)
    per_frame = np.sqrt(np.nanmean(used[shown.any(axis=1)] ** 2, axis=1))
    per_marker = np.sqrt(np.nanmean(used[:, shown.any(axis=0)] ** 2, axis=0))
    d = calibration.human.dimensions
    return {
        "marker_rms_mean_mm": 1e3 * float(np.nanmean(per_frame)),
        "marker_rms_worst_frame_mm": 1e3 * float(np.nanmax(per_frame)),
        "marker_rms_worst_marker_mm": 1e3 * float(np.nanmax(per_marker)),
        "marker_error_max_mm": 1e3 * float(np.nanmax(used)),
        "markers_used": int(used.shape[1]),
        "samples_left_out": int((seen & ~kept).sum()),
        "height_m": calibration.human.height,
        **{f"length_{n}_m": getattr(d, n) for n in d.names()},
    }

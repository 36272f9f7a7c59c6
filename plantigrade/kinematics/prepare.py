"""A marker recording made ready to be scaled and followed.

Exchanged labels are corrected, samples metres away are left out, and the recording is turned so
that the person faces x. A recording that cannot be of a person is refused.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FitError
from plantigrade.kinematics.calibrate import require_known
from plantigrade.kinematics.faulty_samples import glued, without_faulty_samples
from plantigrade.kinematics.given_ground import GivenGround
from plantigrade.kinematics.keypoints import BonesOfVideo, bones_of_video, levelled, of_video
from plantigrade.kinematics.label_repair import corrected_labels, with_continuous_labels
from plantigrade.kinematics.plausibility import (
    require_human_size,
    require_one_person,
    without_far_samples,
)
from plantigrade.kinematics.result import filled, human_of
from plantigrade.kinematics.standing_poses import standing_poses
from plantigrade.models import Human
from plantigrade.models.keypoints import KEYPOINTS, are_keypoints, is_without_landmark
from plantigrade.models.landmarks import Attachment
from plantigrade.models.markers import MarkerSet, landmark_names, place_markers
from plantigrade.models.person import Person
from plantigrade.models.spellings import is_regressed, landmark_of
from plantigrade.motion import Markers, Recording
from plantigrade.motion.filters import runs
from plantigrade.motion.turning import quarter_turn_to_face_x, turn

USUAL_HEIGHT = 1.72  # [m] initial stature of the calibration without a given one
STATIC_FRAMES = 6  # [1] evenly spread frames of a standing trial
MIN_VISIBLE_SHARE = 0.75  # [1] minimum share of visible markers of a fitted frame
MIN_SHARED_MARKERS = 6  # [1] minimum number of known markers shared with the standing trial


@dataclass(frozen=True)
class Prepared:
    """A marker recording that can be scaled and followed."""

    recording: Recording  #: The recording, turned so that the person faces x, labels put right
    static: Recording | None  #: Its standing trial, labels put right, not turned
    person: Person  #: Known properties of the person
    human: Human  #: A person of about the size, to start from
    names: tuple[str, ...]  #: The markers worth fitting, of the recording and of the standing trial
    placed: Mapping[str, Attachment | None]  #: Where each of them sits; None for an unknown name
    ignored: Mapping[str, str]  #: Markers that are not worth fitting, and why
    window: slice  #: The frames that show enough of the markers
    heading: float  #: Angle by which the recording was turned about the vertical [rad]
    #: Slope or steps on which the feet stand, where they are given
    ground: GivenGround | None = None
    video: BonesOfVideo | None = None  #: Noise and bones of keypoints; None for markers
    exchanged: tuple[tuple[str, ...], ...] = ()  #: Labels that were exchanged with each other
    notes: tuple[str, ...] = ()  #: Corrections, one sentence each

    @property
    def markers(self) -> Markers:
        """The markers of the recording."""
        assert self.recording.markers is not None
        return self.recording.markers

    @property
    def known(self) -> list[str]:
        """Markers of the recording with a known place."""
        own = self.markers.names
        return [n for n in self.names if self.placed[n] is not None and n in own]


def prepare(
    recording: Recording,
    person: Person | None = None,
    *,
    static: Recording | None = None,
    marker_set: MarkerSet | None = None,
    ground: GivenGround | None = None,
) -> Prepared:
    """Make a marker recording ready to be fitted.

    Args:
        recording: The recording; it must have markers.
        person: Known properties of the person; the recording's metadata supply others.
        static: A standing trial of the same person with the same markers, if there is one.
        marker_set: Where markers sit; by default the built-in set that knows most names.
    """
    if static is not None:
        known = replace(static.subject, date=None)  # the date is that of another recording
        recording = replace(recording, subject=filled(recording.subject, known))
    person = filled(person or Person(), recording.subject)
    markers = recording.markers
    if markers is None or not markers.names:
        raise FitError(f"{recording.source} has no markers to fit")
    markers, notes = with_continuous_labels(markers)
    names, ignored = _usable(markers)
    names += [n for n in _seen_in(static) if n not in markers.names]
    human = human_of(person, person.height or USUAL_HEIGHT, age=recording.subject.age)
    placed = place_markers(names, human, marker_set)
    markers, faults = without_faulty_samples(markers, placed)
    start, stop, ends = _window(markers, names)
    own = [n for n in names if n in markers.names]
    known = [n for n in own if placed[n] is not None]
    require_known(own, placed)
    require_one_person(known, recording.source)
    require_human_size(columns(markers, known)[start:stop], recording.source)
    right = corrected_labels(replace(recording, markers=markers), static, human, names, placed)
    recording, far = without_far_samples(right.recording)
    notes = [*notes, *faults, *ends, *right.notes]
    notes += [f"{far} samples metres away from the person were discarded."] if far else []
    markers = recording.markers
    assert markers is not None
    markers, video, said = _of_keypoints(markers, recording, known, human, ground)
    recording = replace(recording, markers=markers)
    facing = _facing(human, known, placed, markers, start, stop)
    angle = quarter_turn_to_face_x(facing) - (0.0 if ground is None else ground.heading)
    return Prepared(
        recording=turn(recording, angle),
        static=right.static,
        person=person,
        human=human,
        names=tuple(names),
        placed=placed,
        ignored=ignored,
        window=slice(start, stop),
        heading=angle,
        ground=ground,
        video=video,
        exchanged=right.exchanged,
        notes=(*notes, *said),
    )


def _seen_in(static: Recording | None) -> list[str]:
    """Return the markers that a standing trial shows."""
    if static is None or static.markers is None:
        return []
    seen = np.any(np.isfinite(static.markers.positions[..., 0]), axis=0)
    return [n for n, ever in zip(static.markers.names, seen, strict=True) if ever]


def _window(markers: Markers, names: Sequence[str]) -> tuple[int, int, list[str]]:
    """Return the frames that show enough of the markers, from and to, and what was left out."""
    start, stop = _longest_visible(markers, [n for n in names if n in markers.names])
    if start == 0 and stop == markers.n_frames:
        return start, stop, []
    note = (
        f"markers are missing at the ends: {stop - start} of {markers.n_frames} frames were "
        f"fitted, {markers.time[start]:.2f} to {markers.time[stop - 1]:.2f} s."
    )
    return start, stop, [note]


def _of_keypoints(
    markers: Markers,
    recording: Recording,
    known: Sequence[str],
    human: Human,
    ground: GivenGround | None,
) -> tuple[Markers, BonesOfVideo | None, list[str]]:
    """Return keypoints levelled and smoothed, the bones of their video, and what was done.

    Markers that are no keypoints are unchanged.
    """
    notes: list[str] = []
    if are_keypoints(markers.names) and not recording.plates and ground is None:
        markers, notes = levelled(markers)
    video = bones_of_video(markers) if are_keypoints(known) else None
    if video is not None:
        markers, said = of_video(markers, human, video.noise, grounded=bool(recording.plates))
        notes = [*notes, *said]
    return markers, video, notes


def _usable(markers: Markers) -> tuple[list[str], dict[str, str]]:
    """Return the markers worth fitting and the reason for each that is not.

    OpenCap writes keypoints beside the markers that its network computes from them. Fingers and
    the outline of the face are left out too.

    If a joint has two centres, that of a regression is left out: a functional one is nearer the
    joint where the range of motion is sufficient ([Kainz2015]_).
    """
    names, ignored = [], {}
    video = are_keypoints(markers.names)
    for i, name in enumerate(markers.names):
        x = markers.positions[:, i]
        seen = np.isfinite(x[:, 0])
        if not seen.any():
            ignored[name] = "never seen"
        elif video and is_without_landmark(name):
            ignored[name] = "a detail of hands or face"
        elif any(
            np.array_equal(x, markers.positions[:, markers.index(n)], equal_nan=True) for n in names
        ):
            ignored[name] = "the same trajectory as another marker"
        else:
            names.append(name)
    marks = landmark_names(names)
    if video and any(mark and mark.startswith("asis_") for mark in marks.values()):
        for name in [n for n in names if n in KEYPOINTS]:
            names.remove(name)
            ignored[name] = "a keypoint from which the other markers were computed"
    for name in [] if video else glued(markers, names, marks):
        names.remove(name)
        ignored[name] = "within a marker's width of another one throughout"
    measured = {landmark_of(name): name for name in names if not is_regressed(name)}
    for name in [n for n in names if is_regressed(n) and landmark_of(n) in measured]:
        names.remove(name)
        ignored[name] = (
            f"a regression's estimate of what {measured[landmark_of(name)]} gives without one"
        )
    return names, ignored


def columns(markers: Markers, names: Sequence[str]) -> Float[Array, "n_frames n_names 3"]:
    """Return the positions of ``names``; NaN where the recording lacks the marker."""
    out = np.full((markers.n_frames, len(names), 3), np.nan)
    for k, name in enumerate(names):
        if name in markers.names:
            out[:, k] = markers.positions[:, markers.index(name)]
    return out


def _longest_visible(markers: Markers, names: Sequence[str]) -> tuple[int, int]:
    """Return the longest run of frames that show enough of the markers."""
    x = columns(markers, names)
    ever = np.isfinite(x[..., 0]).mean(axis=0) > 0.3
    share = np.isfinite(x[:, ever, 0]).mean(axis=1) if ever.any() else np.zeros(len(x))
    good = share >= MIN_VISIBLE_SHARE
    if not good.any():
        raise FitError(
            f"no frame shows {MIN_VISIBLE_SHARE:.0%} of the markers (best {share.max():.0%}); "
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
    q = standing_poses(human, [placed[n] for n in known], columns(markers, known)[frames])
    return float(np.angle(np.mean((q[:, 3] + 1j * q[:, 6]) ** 2)))


def static_frames(static, names, human, known, placed):
    """Return the markers of some standing frames, turned to face x."""
    if static is None or static.markers is None:
        return np.empty((0, len(names), 3))
    markers = static.markers
    common = [n for n in known if n in markers.names]
    if len(common) < MIN_SHARED_MARKERS:
        raise FitError(
            f"the standing trial {static.source} shares {len(common)} known markers with the "
            f"recording; {MIN_SHARED_MARKERS} are needed: name one with the same markers"
        )
    start, stop = _longest_visible(markers, [n for n in names if n in markers.names])
    angle = quarter_turn_to_face_x(_facing(human, common, placed, markers, start, stop))
    turned = turn(static, angle).markers
    assert turned is not None
    frames = np.unique(np.linspace(start, stop - 1, STATIC_FRAMES).astype(int))
    return columns(turned, names)[frames]


def choose_frames(measured, start: int, stop: int, count: int) -> np.ndarray:
    """Return frames spread over the trial, each the best seen one of its stretch."""
    share = np.isfinite(measured[..., 0]).mean(axis=1)
    stretches = np.array_split(np.arange(start, stop), min(count, stop - start))
    # The middle of the stretch unless another frame of it is seen better.
    return np.array(
        [min(s, key=lambda f, s=s: (-share[f], abs(f - s[len(s) // 2]))) for s in stretches]
    )

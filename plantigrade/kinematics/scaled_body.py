"""One body for one or several trials of a person: lengths, marker places, soles.

All trials of a person with the same markers, and their standing trials, enter one
calibration. The body does not depend on the order of the trials.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.contact.ground import Ground
from plantigrade.kinematics.calibrate import Calibration, calibrate
from plantigrade.kinematics.flat_feet import set_flat
from plantigrade.kinematics.given_ground import below_feet
from plantigrade.kinematics.ground_level import ground_height
from plantigrade.kinematics.inverse import InverseKinematics, track
from plantigrade.kinematics.posture_prior import PosturePrior
from plantigrade.kinematics.prepare import (
    USUAL_HEIGHT,
    Prepared,
    choose_frames,
    columns,
    static_frames,
)
from plantigrade.kinematics.result import human_of
from plantigrade.kinematics.spine_doubts import standing_notes
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.stature_estimate import stature_warnings, with_unknown_size
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment
from plantigrade.models.markers import MarkerSet, place_markers
from plantigrade.motion import Recording, Subject
from plantigrade.printable import listed

CALIBRATION_FRAMES = 24  # [1] frames of all trials together, which cover the range of each joint
MIN_TRIAL_FRAMES = 4  # [1] minimum number of frames per trial
MAX_STANDING_KNEE = np.deg2rad(15.0)
"""Largest flexion of a knee in a standing trial [rad]. Pulled to zero, the knees of sound ones have
up to 4 degrees, those of a frame of walking 16 to 53."""


@dataclass(frozen=True)
class ScaledBody:
    """A person scaled to the markers of trials."""

    human: Human  #: The person
    names: tuple[str, ...]  #: Marker names, in the order of ``places``
    places: tuple[Attachment, ...]  #: Where each marker sits
    attached: Mapping[str, str]  #: Markers of unknown name → the body they were put on
    first: Mapping[str, Float[Array, " nq"]]  #: Source of a trial → a pose near its first frame
    standing: Float[Array, "n_frames nq"]  #: Poses in frames of the standing trials
    #: Root-mean-square marker error in these frames [m]; NaN without
    standing_rms: float = float("nan")
    #: Source of a trial → the ground on which its feet stand
    floors: Mapping[str, Ground] = field(default_factory=dict)
    grounded: bool = False  #: Whether a foot was seen to stand flat on the ground
    notes: tuple[str, ...] = ()  #: Assumptions, one sentence each

    def start(self, source: object) -> Float[Array, " nq"]:
        """Return a pose near the first frame of a trial, or of a standing trial."""
        other = self.standing[0] if len(self.standing) else self.human.standing()
        return self.first.get(str(source), other)

    def floor(self, recording: Recording) -> Ground:
        """Return the ground of a trial, or of a standing trial."""
        level = Ground(height=ground_height(recording))
        return self.floors.get(str(recording.source), level)


def scale(trials: Sequence[Prepared], *, marker_set: MarkerSet | None = None) -> ScaledBody:
    """Scale one body to all trials of a person.

    Args:
        trials: The trials, at least one; what is known of the person is that of the first by name.
        marker_set: Where markers sit; the built-in set that knows most names if not given.

    Raises:
        FitError: If the markers contradict the stature that is given, a standing trial has too few
            markers in common with its trial, or feet do not stand on the given ground.
    """
    trials = sorted(trials, key=lambda trial: str(trial.recording.source))
    one = trials[0]
    samples = _samples(trials, marker_set)
    scaled = samples.scaled(one.human, samples.placed, one.person.height)
    said = _bent_notes(scaled, samples.standing, samples.statics)
    if said:  # frames of the person like others, which show no zero of knees and feet
        samples.standing[:] = False
        scaled = samples.scaled(one.human, samples.placed, one.person.height)
    which = [samples.names.index(n) for n in scaled.names]
    frames = samples.frames[:, which]
    said += standing_notes(
        scaled.human, scaled.places, scaled.names, scaled.qpos, frames, samples.standing
    )
    doubts = stature_warnings(
        one.person,
        scaled.human,
        scaled.places,
        float(np.sqrt(np.nanmean(scaled.residual**2))),
        lambda: samples.free(marker_set),
        one.recording.source,
    )
    age = one.recording.subject.age
    human, notes = with_unknown_size(scaled.human, scaled.places, one.person, age)
    poses = scaled.qpos[samples.first]
    seen = [columns(t.markers, scaled.names)[t.window] for t in trials]
    sources = [str(t.recording.source) for t in trials]
    floors = {
        source: _floor(t, human, scaled.places, x, q)
        for source, t, x, q in zip(sources, trials, seen, poses, strict=True)
    }
    still, ground = frames[samples.standing], floors[sources[0]]
    every, rate = _on_one_ground(trials, seen), one.markers.rate
    feet = set_flat(human, scaled.places, every, still, rate, poses[0], ground=ground)
    above = feet.above_ground
    if above and not any(t.ground or t.recording.plates for t in trials):
        ground = Ground(height=above)
        floors = dict.fromkeys(sources, ground)
        feet = set_flat(human, scaled.places, every, still, rate, poses[0], ground=ground)
        where = f"{1e3 * abs(above):.0f} mm {'above' if above > 0.0 else 'below'}"
        notes = (*notes, f"the feet stand {where} the origin of the file: the floor was put there.")
    return ScaledBody(
        human=feet.human,
        names=scaled.names,
        places=feet.places,
        attached=scaled.attached,
        first=dict(zip(sources, poses, strict=True)),
        standing=scaled.qpos[samples.standing],
        standing_rms=root_mean_square(scaled.residual[: len(still)]),
        floors=floors,
        grounded=feet.grounded,
        notes=(*said, *doubts, *notes, *feet.notes),
    )


@dataclass(frozen=True, eq=False)
class _Samples:
    """What a body is scaled to: frames of the standing trials, then chosen ones of the trials."""

    one: Prepared  # the first trial by name
    names: list[str]  # of all trials
    placed: Mapping[str, Attachment | None]
    statics: Iterable[str]  # sources of the standing trials
    frames: Float[Array, "n_frames n_markers 3"]
    standing: Bool[Array, " n_frames"]  # which frames are of standing trials
    first: Int[Array, " n_trials"]  # the first frame of each trial

    def scaled(
        self, start: Human, placed: Mapping[str, Attachment | None], height: float | None
    ) -> Calibration:
        """Return the calibration from a person to start from."""
        video = self.one.video
        return calibrate(
            start,
            self.names,
            dict(placed),
            self.frames,
            height=height,
            standing=self.standing,
            prior=None if video is None else PosturePrior.of(start, video),
        )

    def free(self, marker_set: MarkerSet | None) -> Human:
        """Return the person scaled to the markers alone."""
        usual = human_of(self.one.person, USUAL_HEIGHT, age=self.one.recording.subject.age)
        return self.scaled(usual, place_markers(self.names, usual, marker_set), None).human


def _samples(trials: Sequence[Prepared], marker_set: MarkerSet | None) -> _Samples:
    """Return frames of trials, sorted by name, that show the range of each joint."""
    one = trials[0]
    names = list(dict.fromkeys(chain.from_iterable(trial.names for trial in trials)))
    placed = one.placed if len(trials) == 1 else place_markers(names, one.human, marker_set)
    statics = {str(t.static.source): t for t in trials if t.static is not None}
    calm = [static_frames(t.static, names, t.human, t.known, placed) for t in statics.values()]
    still = np.concatenate([np.empty((0, len(names), 3)), *calm])
    each = max(CALIBRATION_FRAMES // len(trials), MIN_TRIAL_FRAMES)
    chosen = []
    for trial in trials:
        x = columns(trial.markers, names)
        chosen.append(x[choose_frames(x, trial.window.start, trial.window.stop, each)])
    frames = np.concatenate([still, *chosen])
    first = np.cumsum([len(still), *map(len, chosen)])[:-1]
    return _Samples(one, names, placed, statics, frames, np.arange(len(frames)) < len(still), first)


def _bent_notes(
    calibration: Calibration, standing: Bool[Array, " n_frames"], statics: Iterable[str]
) -> list[str]:
    """Return a sentence where knees are bent in a standing trial although pulled to zero."""
    human = calibration.human
    hinges = [human.hinge(f"knee_angle_{side}") for side in SIDES]
    bent = float(calibration.qpos[standing, 7:][:, hinges].max(initial=0.0))
    if bent <= MAX_STANDING_KNEE:
        return []
    return [
        f"a knee is bent by {np.rad2deg(bent):.0f}° in the standing trial "
        f"({listed([Path(name).name for name in statics])}): it was taken in mid-step, or the "
        "person stands on bent knees. It shows where markers sit, but not the zero of knees and "
        "ankles, whose offsets may be some degrees."
    ]


def _floor(
    trial: Prepared,
    human: Human,
    places: Sequence[Attachment],
    samples: Float[Array, "n_frames n_markers 3"],
    start: Float[Array, " nq"],
) -> Ground:
    """Return the ground of a trial: level at the height of the plates, or as it was given."""
    if trial.ground is None:
        return Ground(height=ground_height(trial.recording))
    followed, _ = track(InverseKinematics(PointSet.of(human, places)), samples, start)
    return below_feet(trial.ground.shape, human, trial.markers.time[trial.window], followed)


def _on_one_ground(
    trials: Sequence[Prepared], seen: Sequence[Float[Array, "n_frames n_markers 3"]]
) -> Float[Array, "n_all n_markers 3"]:
    """Return the markers of all trials at the first one's rate, above the first one's ground.

    Slopes and steps differ between trials: with a given one, only the first trial counts.
    """
    one = trials[0]
    if one.ground is not None:
        return seen[0]
    rows = []
    for trial, x in zip(trials, seen, strict=True):
        if abs(trial.markers.rate - one.markers.rate) < 0.01 * one.markers.rate:
            higher = ground_height(trial.recording) - ground_height(one.recording)
            rows.append(x - [0.0, 0.0, higher])
    return np.concatenate(rows)


@dataclass(frozen=True)
class Shared:
    """Body and body mass that the trials of one subject have in common."""

    body: ScaledBody  #: Lengths, marker places, soles
    subject: Subject  #: What their files say of the subject; the mass is that of all trials
    files: tuple[Path, ...]  #: The trials, by name
    notes: tuple[str, ...] = ()  #: What the user should know, one sentence each

    def into(self, recording: Recording) -> Recording:
        """Return one of the recordings as one of this subject's."""
        others = tuple(path for path in self.files if path != recording.source)
        own = replace(self.subject, date=recording.subject.date)
        return replace(
            recording,
            subject=own,
            companions=(*recording.companions, *others),
            warnings=(*recording.warnings, *self.notes),
        )

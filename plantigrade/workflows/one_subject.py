"""Trials of one subject: one body for all, and one body mass."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from plantigrade.analyze.body_mass import WEIGHINGS, MeasuredMass
from plantigrade.analyze.trial import analyse
from plantigrade.arrays import spread
from plantigrade.errors import FitError, PlantigradeError
from plantigrade.io import read
from plantigrade.io.subjects import MAX_DIFFERENCE, difference, same_size, subjects
from plantigrade.kinematics.fit import fit_markers
from plantigrade.kinematics.prepare import Prepared, prepare
from plantigrade.kinematics.result import filled
from plantigrade.kinematics.scaled_body import ScaledBody, Shared, scale
from plantigrade.models.markers import read_marker_set
from plantigrade.models.person import Person
from plantigrade.motion import Recording, Subject
from plantigrade.motion.distances import MAX_FRAMES
from plantigrade.notes import Info
from plantigrade.record.jobs import Workers
from plantigrade.workflows.fit import given_ground, load
from plantigrade.workflows.settings import FitSettings

MAX_STANDING_ERROR = 0.015
"""Largest marker error of a standing trial on the body of the moving trials [m]; 4 to 8 mm where
they are of one session."""


def by_subject(paths: Sequence[Path], workers: Workers | None = None) -> list[tuple[int, ...]]:
    """Return which recordings are of one subject, as indices; files that cannot be read are not.

    Args:
        workers: Where they are read; here if absent.
    """
    found = {
        i: done.result
        for i, done in enumerate((workers or Workers()).run(_looked_at, paths))
        if done.result is not None
    }
    at = list(found)
    groups = [tuple(at[k] for k in group) for group in subjects(list(found.values()))]
    return [group for group in groups if len(group) > 1]


def _looked_at(path: Path) -> Recording | None:
    """Return the part of a marker recording that identifies the subject: frames, subject data."""
    try:
        recording = read(path)
    except PlantigradeError:
        return None
    markers = recording.markers
    if markers is None or not markers.names:
        return None
    frames = spread(markers.n_frames, MAX_FRAMES)
    few = replace(markers, time=markers.time[frames], positions=markers.positions[frames])
    return Recording(recording.source, few, subject=recording.subject)


def share(paths: Sequence[Path], settings: FitSettings) -> Shared | None:
    """Scale one body to the trials of a subject and weigh it on all their plates.

    Trials that cannot be fitted are left aside; None where fewer than two remain.
    """
    chosen = read_marker_set(settings.marker_set) if settings.marker_set else None
    recordings: list[Recording] = []
    for path in sorted(paths, key=str):
        try:
            recording = load(path, settings)
            prepare(recording, static=recording.static, marker_set=chosen)
        except PlantigradeError:
            continue  # the fit of this file reports the error
        recordings.append(recording)
    if len(recordings) < 2:
        return None
    for other in recordings[1:]:
        if not same_size(recordings[0], other):
            raise FitError(
                f"{recordings[0].source.name} and {other.source.name} give other heights or masses "
                "of one subject: correct them in the files, or fit with --subject each"
            )
    subject, ground = _subject(recordings, settings), given_ground(settings)
    person = Person(**settings.known)
    trials: list[Prepared] = []
    for recording in recordings:
        one = replace(recording, subject=replace(subject, date=recording.subject.date))
        trials.append(prepare(one, person, static=one.static, marker_set=chosen, ground=ground))
    body = scale(trials, marker_set=chosen)
    files = tuple(recording.source for recording in recordings)
    shared = Shared(body, subject, files, _notes(body, recordings))
    if settings.mass is None and subject.mass is None and not settings.without_plates:
        shared = _weighed(shared, recordings, person, settings)
    return shared


def _notes(body: ScaledBody, recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Return what trials share, and what speaks against one person with the same markers."""
    names = [recording.source.name for recording in recordings]
    notes: list[str] = [
        Info(
            f"{len(names)} trials of one subject share lengths, marker places and mass: "
            f"{', '.join(names[:4])}{' …' if len(names) > 4 else ''} (apart with --subject each)."
        )
    ]
    if body.standing_rms > MAX_STANDING_ERROR:
        notes.append(
            f"the standing trial is {1e3 * body.standing_rms:.0f} mm off the body of these trials; "
            f"{1e3 * MAX_STANDING_ERROR:.0f} mm is the limit: markers were moved between them. Fit "
            "the trials with --subject each, or name their standing trial with --static."
        )
    for other in recordings[1:]:
        if MAX_DIFFERENCE < (off := difference(recordings[0], other)) < float("inf"):
            notes.append(
                f"marker distances of {other.source.name} differ by {100 * off:.0f} % from those "
                f"of {names[0]}: another person, or markers put on anew. Fit them with --subject "
                "each if their marker errors are larger that way."
            )
    return tuple(notes)


def _subject(recordings: Sequence[Recording], settings: FitSettings) -> Subject:
    """Return the subject that the files describe; median of heights and masses."""
    known = [r.subject for r in recordings] + [r.static.subject for r in recordings if r.static]
    subject = Subject(age=settings.age)
    for each in known:
        subject = filled(subject, replace(each, date=None))
    middle = {
        name: float(np.median(values))
        for name in ("height", "mass")
        if (values := [v for each in known if (v := getattr(each, name)) is not None])
    }
    return replace(subject, **middle)


def _weighed(
    shared: Shared, recordings: Sequence[Recording], person: Person, settings: FitSettings
) -> Shared:
    """Return the shared body with the mass that the plates of all trials measured, if any did."""
    found: list[MeasuredMass] = []
    calm = {r.static.source for r in recordings if r.static is not None}
    for recording in _with_plates(recordings, settings):
        ground = None if recording.source in calm else given_ground(settings)
        fit = fit_markers(
            shared.into(recording), person, static=recording.static, ground=ground, body=shared.body
        )
        weighed = analyse(fit, cutoff=settings.cutoff or "usual").weighed
        found += [] if weighed is None else [weighed]
    if not found:
        return shared
    best = min((each.method for each in found), key=list(WEIGHINGS).index)
    found = [each for each in found if each.method == best]
    seconds = sum(each.seconds for each in found)
    mass = sum(each.mass * each.seconds for each in found) / seconds
    note = Info(
        f"the files give no body mass; the force plates measured {mass:.1f} kg over "
        f"{seconds:.1f} s of {WEIGHINGS[best]} in {len(found)} trials of this subject."
    )
    body = replace(shared.body, human=shared.body.human.with_mass(mass))
    subject = replace(shared.subject, mass=mass)
    return replace(shared, body=body, subject=subject, notes=(*shared.notes, note))


def _with_plates(recordings: Sequence[Recording], settings: FitSettings) -> list[Recording]:
    """Return the trials that plates measured, and such standing trials."""
    found = [recording for recording in recordings if recording.plates]
    calm = {r.static.source for r in recordings if r.static is not None}
    plain = replace(settings, static=None, forces=None)
    for source in sorted(calm - {r.source for r in recordings}, key=str):
        static = load(source, plain)
        found += [static] if static.plates else []
    return found

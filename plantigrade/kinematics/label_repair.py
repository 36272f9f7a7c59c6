"""Markers under their own labels: exchanged labels are corrected, with a note."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.kinematics.exchanged_labels import Exchange, Landmarks, exchanged_by_anatomy
from plantigrade.kinematics.standing_trial import exchanged_by_standing, require_same_person
from plantigrade.kinematics.wrists import exchanged_wrists
from plantigrade.models import Human
from plantigrade.models.landmarks import Attachment, attachments
from plantigrade.motion import Recording


@dataclass(frozen=True)
class CorrectedLabels:
    """A recording and its standing trial with every marker under its own label."""

    recording: Recording  #: The recording
    static: Recording | None  #: Its standing trial, if there is one
    #: Labels of the recording that were exchanged with each other, mostly pairs
    exchanged: tuple[tuple[str, ...], ...] = ()
    notes: tuple[str, ...] = ()  #: Corrections, one sentence each


def corrected_labels(
    recording: Recording,
    static: Recording | None,
    human: Human,
    names: Sequence[str],
    placed: Mapping[str, Attachment | None],
) -> CorrectedLabels:
    """Put exchanged labels back: by anatomy, rigidity and the standing trial.

    Args:
        static: Its standing trial, if there is one.
        human: A person of about the size.
        placed: Where they sit; None where unknown.

    Raises:
        FitError: If the person is mirrored, or the standing trial is of another person.
    """
    notes: list[str] = []
    if static is not None and static.markers is not None:
        static, found = _as_anatomy_has_it(static, human, names, placed)
        notes += _said(found, f"the standing trial {static.source.name}")
        static, found = _thumbs_in_front(static, human, placed)
        notes += _said(found, f"the standing trial {static.source.name}")
    recording, found = _as_anatomy_has_it(recording, human, names, placed)
    exchanged = list(found.cycles)
    notes += _said(found, "the whole recording")
    recording, found = _thumbs_in_front(recording, human, placed)
    exchanged += found.cycles
    notes += _said(found, "the whole recording")
    if static is not None and static.markers is not None and recording.markers is not None:
        used = [n for n in recording.markers.names if n in names]
        markers = recording.markers.select(used)
        segments = {n: p.body for n in used if (p := placed[n]) is not None}
        found = exchanged_by_standing(markers, static.markers, list(segments))
        exchanged += found.cycles
        notes += _said(found, "the whole recording, as its standing trial shows")
        recording = replace(recording, markers=found.undone(recording.markers))
        markers = found.undone(markers)
        require_same_person(markers, static.markers, segments, static.source)
    return CorrectedLabels(recording, static, tuple(exchanged), tuple(notes))


def _as_anatomy_has_it(
    recording: Recording,
    human: Human,
    names: Sequence[str],
    placed: Mapping[str, Attachment | None],
) -> tuple[Recording, Exchange]:
    markers = recording.markers
    assert markers is not None
    own = {n: p for n in names if (p := placed[n]) is not None and n in markers.names}
    seen = {
        n: p for n, p in own.items() if np.isfinite(markers.positions[:, markers.index(n), 0]).any()
    }
    if not seen:
        return recording, Exchange({})
    known = Landmarks(human, tuple(seen), tuple(seen.values()))
    samples = markers.select(list(seen)).positions
    found = exchanged_by_anatomy(known, samples, recording.source)
    return replace(recording, markers=found.undone(markers)), found


def _thumbs_in_front(
    recording: Recording, human: Human, placed: Mapping[str, Attachment | None]
) -> tuple[Recording, Exchange]:
    assert recording.markers is not None
    table = {(a.body, tuple(a.position)): mark for mark, a in attachments(human).items()}
    marks = {n: table.get((p.body, tuple(p.position))) for n, p in placed.items() if p is not None}
    found = exchanged_wrists(recording.markers, marks)
    return replace(recording, markers=found.undone(recording.markers)), found


def _said(found: Exchange, where: str) -> list[str]:
    if not found:
        return []
    pairs = "; ".join(" and ".join(cycle) for cycle in found.cycles)
    return [f"labels are swapped throughout {where}: {pairs}; this was corrected."]

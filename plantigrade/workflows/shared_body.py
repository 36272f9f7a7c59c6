"""Body and body mass that the trials of one subject have in common."""

from dataclasses import dataclass, replace
from pathlib import Path

from plantigrade.kinematics.scaled_body import ScaledBody
from plantigrade.motion import Recording, Subject


@dataclass(frozen=True)
class Shared:
    """Body and body mass that the trials of one subject have in common.

    Attributes:
        body: Lengths, marker places, soles.
        subject: What their files say of the subject; the mass is that of all trials.
        files: The trials, by name.
        notes: What the user should know, one sentence each.
    """

    body: ScaledBody
    subject: Subject
    files: tuple[Path, ...]
    notes: tuple[str, ...] = ()

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

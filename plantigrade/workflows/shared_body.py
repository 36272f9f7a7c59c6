"""Body and body mass that the trials of one subject have in common."""

from dataclasses import dataclass, replace
from pathlib import Path

from plantigrade.kinematics.scaled_body import ScaledBody
from plantigrade.motion import Recording, Subject


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

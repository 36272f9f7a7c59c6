"""List the recordings in a folder and what each of them holds."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress
from plantigrade.errors import FileError, ParameterError, UnsupportedFormat

if TYPE_CHECKING:
    from plantigrade.motion import Recording


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions):
    """List the recordings in a folder and what each of them holds."""

    folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="FOLDER")] = Path(".")
    """Folder to look in, with its subfolders; or one file."""

    def run(self) -> Outcome:
        """Return one line per recording.

        Raises:
            ParameterError: If there is no such folder.
        """
        from plantigrade.io import read

        if not self.folder.exists():
            raise ParameterError(f"{self.folder} does not exist; name a folder or a file")
        paths = [self.folder]
        if self.folder.is_dir():
            paths = sorted(path for path in self.folder.rglob("*") if path.is_file())
        progress = Progress(quiet=self.quiet)
        found: list[dict[str, Any]] = []
        others = 0
        for path in progress.track(paths, "reading"):
            try:
                found.append({"file": path} | describe(read(path)))
            except UnsupportedFormat:
                others += 1
            except FileError as error:
                found.append({"file": path, "error": str(error)})
        lines = [_line(entry, self.folder) for entry in found]
        lines.append(f"{len(found)} recordings, {others} other files in {self.folder}")
        return Outcome(
            text="\n".join(lines),
            metrics={
                "status": "ok",
                "command": "data",
                "folder": self.folder,
                "n_recordings": len(found),
                "n_unreadable": sum("error" in entry for entry in found),
                "n_other_files": others,
                "recordings": found,
            },
        )


def describe(recording: "Recording") -> dict[str, Any]:
    """Return what ``recording`` holds, as flat figures with units; what it lacks is left out."""
    holds: dict[str, Any] = {}
    for kind, part, names in (
        ("markers", recording.markers, "names"),
        ("joints", recording.skeleton, "names"),
        ("coordinates", recording.coordinates, "names"),
    ):
        if part is not None:
            holds[f"n_{kind}"] = len(getattr(part, names))
            if "n_frames" not in holds:
                holds["n_frames"] = len(part.time)
                holds["duration_s"] = float(part.time[-1] - part.time[0]) if len(part.time) else 0.0
    for kind in ("plates", "events", "outputs", "warnings"):
        if len(getattr(recording, kind)):
            holds[f"n_{kind}"] = len(getattr(recording, kind))
    subject = recording.subject
    for key, value in (
        ("height_m", subject.height),
        ("mass_kg", subject.mass),
        ("sex", subject.sex),
    ):
        if value is not None:
            holds[key] = value
    return holds


def _line(entry: dict[str, Any], folder: Path) -> str:
    path = entry["file"]
    name = str(path.relative_to(folder)) if folder.is_dir() else str(path)
    if "error" in entry:
        return f"{name}\n    cannot be read: {entry['error']}"
    parts = [
        f"{entry[f'n_{kind}']} {word}"
        for kind, word in (
            ("markers", "markers"),
            ("joints", "joints of another skeleton"),
            ("coordinates", "coordinates"),
            ("plates", "force plates"),
            ("events", "events"),
            ("outputs", "model outputs"),
        )
        if f"n_{kind}" in entry
    ]
    if "n_frames" in entry:
        parts.append(f"{entry['n_frames']} frames in {entry['duration_s']:.2f} s")
    if "height_m" in entry:
        parts.append(f"{entry['height_m']:.2f} m")
    if "mass_kg" in entry:
        parts.append(f"{entry['mass_kg']:.1f} kg")
    return f"{name}\n    " + ", ".join(parts or ["nothing that moves"])

"""List the recordings in a folder and what each one contains, or download public ones."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from plantigrade.commands import parsing
from plantigrade.commands.data_get import Get
from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress
from plantigrade.errors import ParameterError, UnsupportedFormat
from plantigrade.printable import printable

if TYPE_CHECKING:
    from plantigrade.motion import Recording

_COUNTED = {
    "n_bodies": "bodies",
    "n_markers": "markers",
    "n_joints": "joints of another skeleton",
    "n_coordinates": "coordinates",
    "n_plates": "force plates",
    "n_events": "events",
    "n_outputs": "model outputs",
}


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions):
    """List the recordings in a folder and their contents, or download public ones.

    Every file is read; one that cannot be read is listed with the reason. `plantigrade data get`
    lists public recordings and downloads those that are named.
    """

    folder: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="FOLDER")] = Path(".")
    """Folder to search, including its subfolders; or a single file."""

    def run(self) -> Outcome:
        """Return one line per recording.

        Raises:
            ParameterError: If there is no such folder.
        """
        from plantigrade.record.jobs import run_jobs

        if not self.folder.exists():
            raise ParameterError(f"{self.folder} does not exist; name a folder or a file")
        paths = [self.folder]
        if self.folder.is_dir():
            paths = sorted(path for path in self.folder.rglob("*") if path.is_file())
        held: list[dict[str, Any]] = []
        faulty: list[dict[str, Any]] = []
        n_others = 0
        jobs = run_jobs(_read, paths)
        for done in Progress(quiet=self.quiet).track(jobs, "reading", total=len(paths)):
            path = done.item
            name = str(path.relative_to(self.folder) if self.folder.is_dir() else path)
            if done.problem:
                faulty.append({"file": name, "problem": done.problem.removeprefix(f"{path}: ")})
            elif done.result is None:
                n_others += 1
            else:
                held.append({"file": name} | done.result)
        total = (
            f"{self.folder}: {len(held)} recordings, {len(faulty)} that cannot be read, "
            f"{n_others} other files"
        )
        lines = [*_lines(held, faulty), total]
        if not held:
            lines.append("  public recordings    plantigrade data get")
        return Outcome(
            text="\n".join(lines),
            metrics={
                "status": "ok",
                "command": "data",
                "folder": self.folder,
                "n_recordings": len(held),
                "n_unreadable": len(faulty),
                "n_other_files": n_others,
                "recordings": held,
                "unreadable": faulty,
            },
        )


SUBCOMMANDS: dict[str, type] = {"list": Command, "get": Get}
"""Name of what is done with data → its command; without one, a folder is listed."""


def parse(words: Sequence[str]) -> Any:
    """Return the command that words say; a folder called ``get`` is written ``./get``.

    Raises:
        SystemExit: If the parser has printed its help (code 0) or its complaint (code 2).
    """
    first = words[0] if words else ""
    if first in SUBCOMMANDS:
        return parsing.parse(SUBCOMMANDS[first], f"plantigrade data {first}", words[1:])
    return parsing.parse(Command, "plantigrade data", words)


def _read(path: Path) -> dict[str, Any] | None:
    """Return what a file holds; None for one that is no recording."""
    from plantigrade.io import format_of, read

    if path.suffix.lower() == ".osim":
        return _model(path)
    try:
        kind = format_of(path).name
    except UnsupportedFormat:
        return None
    return {"format": kind} | describe(read(path))


def _model(path: Path) -> dict[str, Any]:
    """Return what an OpenSim model holds."""
    from plantigrade.io.osim import read_osim

    model = read_osim(path)
    return {
        "format": "OpenSim model",
        "n_bodies": len(model.segments),
        "n_coordinates": sum(len(joint.coordinates) for joint in model.joints),
        "n_markers": len(model.markers),
        "mass_kg": sum(segment.mass for segment in model.segments.values()),
    }


def describe(recording: "Recording") -> dict[str, Any]:
    """Return what ``recording`` holds, as flat figures with units; what it lacks is left out."""
    holds: dict[str, Any] = {}
    clock = None
    for key, part in (
        ("n_markers", recording.markers),
        ("n_joints", recording.skeleton),
        ("n_coordinates", recording.coordinates),
    ):
        if part is not None:
            holds[key] = len(part.names)
            clock = part.time if clock is None else clock
    if recording.plates and clock is None:
        clock = recording.plates[0].time
    for key in ("n_plates", "n_events", "n_outputs", "n_warnings"):
        if count := len(getattr(recording, key.removeprefix("n_"))):
            holds[key] = count
    if clock is not None and len(clock) > 0:
        holds["n_frames"] = len(clock)
        holds["duration_s"] = float(clock[-1] - clock[0])
    subject = recording.subject
    person = {"height_m": subject.height, "mass_kg": subject.mass, "sex": subject.sex}
    return holds | {key: value for key, value in person.items() if value is not None}


def _lines(held: list[dict[str, Any]], faulty: list[dict[str, Any]]) -> list[str]:
    """Return the listing: the readable files as a table, then the others with the reason."""
    named = [printable(entry["file"], lines=False) for entry in held]
    width = max(map(len, named), default=0)
    kinds = max((len(entry["format"]) for entry in held), default=0)
    lines = []
    for name, entry in zip(named, held, strict=True):
        parts = [f"{entry[key]} {word}" for key, word in _COUNTED.items() if key in entry]
        if "n_frames" in entry:
            parts.append(f"{entry['n_frames']} frames, {entry['duration_s']:.2f} s")
        parts += [f"{entry['height_m']:.2f} m"] if "height_m" in entry else []
        parts += [f"{entry['mass_kg']:.1f} kg"] if "mass_kg" in entry else []
        what = ", ".join(parts) or "nothing that moves"
        lines.append(f"{name:{width}}  {entry['format']:{kinds}}  {what}")
    for entry in faulty:
        problem = textwrap.shorten(entry["problem"], 160, placeholder=" …")
        lines.append(f"{printable(entry['file'], lines=False)}: cannot be read: {problem}")
    return lines

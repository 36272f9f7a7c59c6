"""List the recordings in a folder and what each one contains, or download public ones."""

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from plantigrade.commands import parsing
from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress
from plantigrade.errors import ParameterError, UnsupportedFormat
from plantigrade.options import Flag, optional
from plantigrade.printable import printable

if TYPE_CHECKING:
    from plantigrade.datasets import DataSet

_MB = 1e6  # [bytes]


@dataclass(frozen=True, kw_only=True)
class Get(PrintOptions):
    """Download public recordings by name; without a name, list them.

    Every file is checked by its SHA-256 before it gets its name. Files that are there are not
    downloaded again, and an interrupted download continues where it ended.
    """

    names: Annotated[tyro.conf.Positional[tuple[str, ...]], optional("[NAME ...]")] = ()
    """Data sets; without a name, all are listed and nothing is downloaded."""
    all: Flag = False
    """Download every data set."""
    to: Path = Path("data")
    """Folder of the data; each set has its place in it."""
    addresses: Flag = False
    """Download nothing; print address, length, SHA-256 and place of every file."""
    mirror: Annotated[str | None, optional("URL")] = None
    """Server with the paths of raw.githubusercontent.com; by default PLANTIGRADE_MIRROR."""
    overwrite: Flag = False
    """Replace files of other contents under the same names."""

    def run(self) -> Outcome:
        """List or download data sets.

        Raises:
            ParameterError: If there is no such data set, or the mirror is not HTTPS.
            DownloadError: If a file cannot be downloaded.
            FileError: If a file of other contents is in the way, or cannot be written.
        """
        from plantigrade.datasets import data_set, data_sets
        from plantigrade.datasets.get import mirror_of

        if self.all and self.names:
            raise ParameterError("--all takes no names: give either")
        chosen = [data_set(name) for name in dict.fromkeys(self.names)]
        if self.all:
            chosen = list(data_sets().values())
        mirror = mirror_of(self.mirror)
        if self.addresses:
            return _addresses(chosen or list(data_sets().values()), self.to, mirror)
        if not chosen:
            return _listing(list(data_sets().values()))
        downloads = [self._download(each, mirror) for each in chosen]
        lines = [
            f"{each['folder']}: {each['name']}, {each['n_files']} files, {each['megabytes']:.1f} MB"
            f" ({each['n_downloaded']} downloaded)"
            for each in downloads
        ]
        listed = self.to / chosen[0].folder if len(chosen) == 1 else self.to
        lines.append(f"  list them      plantigrade data {listed}")
        metrics = {"status": "ok", "command": "data get", "folder": str(self.to), "sets": downloads}
        return Outcome("\n".join(lines), metrics)

    def _download(self, chosen: "DataSet", mirror: str) -> dict[str, Any]:
        """Download one set and return what became of it."""
        from plantigrade.datasets.get import fetch

        progress = Progress(quiet=self.quiet)
        for line in _about(chosen):
            progress.say(line)
        how = {"overwrite": self.overwrite, "mirror": mirror, "shown": progress.transfer}
        try:
            files = [
                {"file": file.to, "bytes": file.n_bytes, "sha256": file.sha256, "downloaded": new}
                for file, new in fetch(chosen, self.to, **how)
            ]
        except KeyboardInterrupt:  # SIGTERM too
            progress.say("what has arrived is kept; the same command continues")
            raise
        return _described(chosen) | {
            "folder": str(self.to / chosen.folder),
            "n_downloaded": sum(each["downloaded"] for each in files),
            "files": files,
        }


def _about(chosen: "DataSet") -> list[str]:
    """Return what to read before a download: contents, licence, source and citation."""
    lines = [
        f"{chosen.name}: {chosen.about}; {len(chosen.files)} files, {chosen.n_bytes / _MB:.1f} MB",
        f"  licence  {chosen.licence}",
    ]
    lines += [f"           {url}" for url in chosen.licence_urls]
    lines += [f"  source   {page}" for page in chosen.pages]
    return [*lines, f"  cite     {chosen.cite}"]


def _described(each: "DataSet") -> dict[str, Any]:
    """Return a set in figures and words."""
    return {
        "name": each.name,
        "about": each.about,
        "use": each.use,
        "n_files": len(each.files),
        "megabytes": each.n_bytes / _MB,
        "licence": each.licence,
        "licence_urls": list(each.licence_urls),
        "sources": list(each.pages),
        "cite": each.cite,
    }


def _listing(sets: list["DataSet"]) -> Outcome:
    """Return the table of all sets."""
    width = max(len(each.name) for each in sets)
    licence = max(len(each.licence) for each in sets)
    lines = [f"{'name':{width}}  files    MB  {'licence':{licence}}  good for"]
    for each in sets:
        figures = f"{len(each.files):5}  {each.n_bytes / _MB:4.1f}"
        lines.append(f"{each.name:{width}}  {figures}  {each.licence:{licence}}  {each.use}")
        lines.append(f"    {each.about}")
    lines.append("\nplantigrade data get NAME downloads one of them; --all downloads every one.")
    metrics = {"status": "ok", "command": "data get", "sets": [_described(s) for s in sets]}
    return Outcome("\n".join(lines), metrics)


def _addresses(sets: list["DataSet"], to: Path, mirror: str) -> Outcome:
    """Return address, length, checksum and place of every file."""
    files = {
        file.to: {
            "url": file.url(mirror),
            "bytes": file.n_bytes,
            "sha256": file.sha256,
            "to": str(to / file.to),
        }
        for each in sets
        for file in each.files
    }
    lines = [f"{e['sha256']}  {e['bytes']:8}  {e['url']}  {e['to']}" for e in files.values()]
    metrics = {"status": "ok", "command": "data get", "files": list(files.values())}
    return Outcome("\n".join(lines), metrics)


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

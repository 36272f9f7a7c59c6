"""Download public recordings: the licence and the source first, then file by file."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress
from plantigrade.errors import ParameterError
from plantigrade.options import Flag, optional

if TYPE_CHECKING:
    from plantigrade.datasets import DataSet

_MB = 1e6  # [bytes]


@dataclass(frozen=True, kw_only=True)
class Get(PrintOptions):
    """Download public recordings by name; without a name, list them.

    Every file is checked by its SHA-256 before it gets its name. Files that are there are not
    downloaded again, and an interrupted download continues where it ended.
    """

    names: Annotated[
        tyro.conf.Positional[tuple[str, ...]],
        tyro.conf.arg(metavar="[NAME ...]", help_behavior_hint=""),
    ] = ()
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

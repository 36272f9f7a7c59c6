"""Convert a motion file to another format."""

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.bounds import Bounded
from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress
from plantigrade.errors import FileError, RunExists
from plantigrade.options import Flag, OptionalPath, optional


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions, Bounded):
    """Convert a motion file to another format.

    What the target's format has no place for is left out and named; force plates then go beside it,
    into NAME_grf.mot.
    """

    activity = "a recording"
    ranges = {"rate": (1, 10_000, "Hz")}

    source: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="IN")]
    """File to read."""
    target: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="OUT")]
    """File to write; its ending says the format."""
    skeleton: OptionalPath = None
    """Skeleton (.asf) of an AMC file, where it does not lie beside it."""
    rate: Annotated[float | None, optional("HZ")] = None
    """Frames per second of an AMC file, which does not say it."""
    overwrite: Flag = False
    """Replace files that exist."""

    def run(self) -> Outcome:
        """Write the target, whole or not at all.

        Raises:
            RunExists: If a file that would be written exists and is not to be replaced.
            FileError: If the source cannot be read, or the target's format cannot hold it.
        """
        from plantigrade.io import convert

        self._refuse(self.target)
        if self.target.exists() and self.target.samefile(self.source):
            # A format keeps less than what was read: the recording itself would be lost.
            raise RunExists(f"{self.target} is the file to read; name another file to write")
        folder = self.target.parent
        if not folder.is_dir():
            raise FileError(self.target, f"there is no folder {folder}", remedy="make it first")
        given = {"skeleton": self.skeleton, "rate": self.rate}
        options = {name: value for name, value in given.items() if value is not None}
        try:
            # Inside the target's folder: renaming works inside one file system only.
            with tempfile.TemporaryDirectory(prefix=".plantigrade-", dir=folder) as part:
                written = Path(part) / self.target.name
                notes = convert(self.source, written, **options)
                paths = sorted(Path(part).iterdir())  # the target and, maybe, its force plates
                for path in paths:
                    self._refuse(folder / path.name)
                    if (folder / path.name).is_dir():
                        raise RunExists(f"{folder / path.name} is a folder; name another file")
                for path in paths:
                    os.replace(path, folder / path.name)
        except FileError as error:
            if error.path.parent.name.startswith(".plantigrade-"):  # name the file as the user did
                raise type(error)(
                    folder / error.path.name, error.problem, where=error.where, remedy=error.remedy
                ) from error
            raise
        progress = Progress(quiet=self.quiet)
        for note in notes:
            progress.warn(note)
        files = [folder / path.name for path in paths]
        return Outcome(
            text=f"wrote {' and '.join(map(str, files))}",
            metrics={
                "status": "ok",
                "command": "convert",
                "source_file": self.source,
                "target_files": files,
                "warnings": notes,
            },
        )

    def _refuse(self, path: Path) -> None:
        if path.exists() and not self.overwrite:
            raise RunExists(f"{path} exists; name another file or add --overwrite")

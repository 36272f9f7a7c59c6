"""Convert a motion file to another format."""

import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.commands.options import Flag, PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import RunExists


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions):
    """Convert a motion file to another format."""

    source: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="IN")]
    """File to read; its ending says the format."""
    target: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="OUT")]
    """File to write; its ending says the format."""
    overwrite: Flag = False
    """Replace the target if it exists."""

    def run(self) -> Outcome:
        """Write the target, whole or not at all.

        Raises:
            RunExists: If the target exists and is not to be replaced.
            FileError: If the source cannot be read, or the target's format cannot hold it.
        """
        from plantigrade.io import convert

        if self.target.exists() and not self.overwrite:
            raise RunExists(f"{self.target} exists; name another file or add --overwrite")
        self.target.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=".plantigrade-", dir=self.target.parent) as folder:
            written = Path(folder) / self.target.name  # renaming works inside one file system only
            convert(self.source, written)
            for path in sorted(Path(folder).iterdir()):  # a format may need companions
                os.replace(path, self.target.parent / path.name)
        size = self.target.stat().st_size
        return Outcome(
            text=f"wrote {self.target} ({size / 1e3:.0f} kB)",
            metrics={
                "status": "ok",
                "command": "convert",
                "source_file": self.source,
                "target_file": self.target,
                "target_size_bytes": size,
            },
        )

"""Where a result comes from: the command, the settings that decide it, the files that were read."""

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from plantigrade.errors import FileError


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from.

    Attributes:
        command: The command line.
        settings: Every setting that decides the result.
        source_files: SHA-256 of every file that was read, by name.
        seed: Of random numbers.
    """

    command: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict)
    source_files: Mapping[str, str] = field(default_factory=dict)
    seed: int | None = None


def source_files(paths: Iterable[str | Path]) -> dict[str, str]:
    """Return the SHA-256 of each file, by its name; equal names get their folder in front.

    Raises:
        FileError: If a file cannot be read.
    """
    paths = list(dict.fromkeys(Path(path) for path in paths))
    names = [path.name for path in paths]
    sums: dict[str, str] = {}
    for path in paths:
        name = (
            path.name
            if names.count(path.name) == 1
            else f"{path.absolute().parent.name}/{path.name}"
        )
        try:
            with path.open("rb") as stream:
                sums[name] = hashlib.file_digest(stream, "sha256").hexdigest()
        except OSError as error:
            raise FileError(path, f"cannot be read ({error.strerror})") from error
    return sums

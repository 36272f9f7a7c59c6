"""Provenance: the command, the settings that decide its result, and the files it read."""

import hashlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from plantigrade.io.text import reading


@dataclass(frozen=True)
class Provenance:
    """Where a result comes from."""

    command: str = ""  #: The command line
    #: Every setting that decides the result
    settings: Mapping[str, Any] = field(default_factory=dict)
    #: SHA-256 of every file that was read, by name
    source_files: Mapping[str, str] = field(default_factory=dict)
    seed: int | None = None  #: Seed of the random numbers


def source_files(paths: Iterable[str | Path]) -> dict[str, str]:
    """Return the SHA-256 of each file by its name, with as many folders as make the name unique.

    Raises:
        FileError: If a file cannot be read.
    """
    files = list(dict.fromkeys(Path(path).absolute() for path in paths))
    sums: dict[str, str] = {}
    for path in files:
        length, name = 1, path.name
        while length < len(path.parts) and sum(_tail(p, length) == name for p in files) > 1:
            length += 1
            name = _tail(path, length)
        sums[name] = sha256_of(path)
    return sums


def sha256_of(path: Path) -> str:
    """Return the SHA-256 of a file.

    Raises:
        FileError: If it cannot be read.
    """
    with reading(path), path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def _tail(path: Path, length: int) -> str:
    """Return the last parts of a path."""
    return "/".join(path.parts[-length:])

"""A journal: lines of JSON that are only ever appended, so that what was done stays done.

Whatever ends the process between two lines loses nothing; a last line that was cut off is written
over, and a damaged one is passed over. A later line of a name replaces an earlier one.
"""

import contextlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

from plantigrade.errors import FileError
from plantigrade.io.writing import not_written
from plantigrade.locks import lock
from plantigrade.record.metrics import plain

NAME = "name"  # Key by which a line replaces an earlier one


class Journal:
    """The lines of a file by name; only where they stand is kept in memory.

    Args:
        path: The file; it is made with the first line.
    """

    def __init__(self, path: Path):
        self.path = path
        self._places: dict[str, int] = {}
        self._end = self._size = 0
        self._stream: BinaryIO | None = None
        if path.is_file():
            self._find()

    def __contains__(self, name: str) -> bool:
        return name in self._places

    def __len__(self) -> int:
        return len(self._places)

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """Yield the lines that hold, in the order in which their names came first."""
        return self.lines(self._places)

    def lines(self, names: Iterable[str]) -> Iterator[dict[str, Any]]:
        """Yield the lines of these names; a name without a line is passed over."""
        if not self._places:
            return
        with self.path.open("rb") as stream:
            for place in [self._places[name] for name in names if name in self._places]:
                stream.seek(place)
                yield json.loads(stream.readline())

    def open(self) -> BinaryIO:
        """Open the journal for writing; other processes are kept from it until it is closed."""
        if self._stream is not None:
            return self._stream
        try:
            self.path.touch()
            stream = self.path.open("r+b")
        except OSError as error:
            raise not_written(self.path, error) from error
        if not lock(stream) or stream.seek(0, os.SEEK_END) != self._size:
            stream.close()
            problem = "another process writes to this batch"
            raise FileError(self.path, problem, remedy="wait for it, or choose another folder")
        stream.seek(self._end)
        stream.truncate()  # what was cut off
        self._stream = stream
        return stream

    def close(self) -> None:
        """Let other processes write to it."""
        if self._stream is not None:
            self._stream.close()
            self._stream, self._size = None, self._end

    def append(self, line: Mapping[str, Any]) -> None:
        """Write a line.

        Raises:
            FileError: If it cannot be written; what is there stays.
        """
        raw = json.dumps(plain(line), allow_nan=False).encode() + b"\n"
        stream = self.open()
        try:
            stream.seek(self._end)
            stream.write(raw)
            stream.flush()
        except OSError as error:
            raise not_written(self.path, error) from error
        self._places[str(line[NAME])] = self._end
        self._end += len(raw)

    def _find(self) -> None:
        """Find where each line stands; what follows the last whole line is written over."""
        try:
            self._size = self.path.stat().st_size
            with self.path.open("rb") as stream:
                for raw in stream:
                    if not raw.endswith(b"\n"):  # cut off: written over by the next line
                        break
                    with contextlib.suppress(ValueError, KeyError, TypeError, RecursionError):
                        name = json.loads(raw)[NAME]
                        if isinstance(name, str):
                            self._places[name] = self._end
                    self._end += len(raw)
        except OSError as error:
            raise FileError(self.path, f"cannot be read ({error.strerror or error})") from error

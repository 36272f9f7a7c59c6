"""Files written whole or not at all, and small tables of comma-separated values."""

import csv
import io
import os
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from plantigrade.errors import FileError
from plantigrade.printable import cell


@contextmanager
def whole_file(path: str | Path) -> Iterator[Path]:
    """Yield the path of a temporary file that takes the place of ``path`` once it is complete.

    A link stays, and the file that it names is replaced. A pipe or device is written to directly.

    Raises:
        FileError: If the file cannot be written; what was there stays.
    """
    target = Path(os.path.realpath(path))
    special = target.exists() and not target.is_file() and not target.is_dir()
    part = target if special else target.with_name(f".{target.name[:40]}-{os.getpid()}.part")
    try:
        yield part
        if not special:
            os.replace(part, target)
    except OSError as error:
        raise not_written(path, error) from error
    finally:
        if not special:
            part.unlink(missing_ok=True)


def write_bytes(path: str | Path, content: bytes) -> None:
    """Write a file, whole or not at all.

    Raises:
        FileError: If the file cannot be written.
    """
    with whole_file(path) as part:
        part.write_bytes(content)


def write_text(path: str | Path, text: str) -> None:
    r"""Write ``text`` as UTF-8 with ``\n`` line ends; what UTF-8 lacks is escaped, as ``\udcff``.

    Raises:
        FileError: If the file cannot be written.
    """
    write_bytes(path, text.encode("utf-8", "backslashreplace"))


def csv_text(header: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    r"""Return a small table as comma-separated values: six digits, nothing for NaN and None.

    Example:
        >>> csv_text(["name", "value"], [["a", 1 / 3], ["b", None]])
        'name,value\na,0.333333\nb,\n'
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([cell(value) for value in row] for row in rows)
    return stream.getvalue()


def not_written(path: str | Path, error: OSError) -> FileError:
    """Return the error of a file that cannot be written."""
    parent = Path(path).parent
    if not parent.is_dir():
        problem = f"cannot be written (there is no folder {parent})"
        return FileError(path, problem, remedy="create it first")
    return FileError(
        path,
        f"cannot be written ({error.strerror or error})",
        remedy="check that the folder exists and may be written to",
    )

"""Text files read safely: size, encoding, and numbers with errors that name the line.

Every text reader of the package goes through :func:`read_text` and, for its table of numbers,
through :func:`numbers`, so that a broken file gives the same error in every format.
"""

import codecs
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError, not_ordinary
from plantigrade.printable import listed

LIMIT_BYTES = 200e6  # Default maximum size of a text file [bytes], about an hour of 60 markers

ROWS_AT_ONCE = 2000  # Rows of a table that are parsed in one pass, few enough to limit memory

# Words for missing values in exported tables, besides an empty field.
MISSING_WORDS = frozenset(
    {"", "nan", "+nan", "-nan", "na", "n/a", "#n/a", "null", "none", "-", "--", "missing"}
    | {"inf", "+inf", "-inf", "infinity", "-infinity", "1.#ind", "-1.#ind", "1.#qnan", "-1.#qnan"}
    | {"nan(ind)", "-nan(ind)", "1.#inf", "-1.#inf"}
)

_BYTE_ORDER_MARKS = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)


@contextmanager
def reading(path: str | Path) -> Iterator[None]:
    """Convert errors of reading a file to a FileError."""
    try:
        if "\0" in str(path):
            raise OSError("a zero byte in its name")
        if Path(path).is_dir():
            raise FileError(path, "is a folder, not a file", remedy="name the file inside it")
        if Path(path).exists() and not Path(path).is_file():
            raise not_ordinary(path)
        yield
    except FileNotFoundError:
        remedy = "check the name and the folder"
        raise FileError(path, "there is no such file", remedy=remedy) from None
    except OSError as error:
        problem = f"cannot be read ({error.strerror or error})"
        raise FileError(path, problem, remedy="check its permissions") from error


def read_bytes(path: str | Path, limit_bytes: float = LIMIT_BYTES) -> bytes:
    """Return the bytes of a file of limited size."""
    path = Path(path)
    with reading(path):
        size = path.stat().st_size
        if size > limit_bytes:
            raise FileError(
                path,
                f"has {size / 1e6:.0f} MB; the limit is {limit_bytes / 1e6:.0f} MB",
                remedy="cut the recording to the relevant part, or raise limit_bytes",
            )
        with open(path, "rb") as file:
            raw = file.read(int(limit_bytes) + 1)
    if len(raw) > limit_bytes:
        raise FileError(path, "never ends", remedy="give an ordinary file")
    if not raw.strip(b" \t\r\n\0"):
        raise FileError(path, "is empty", remedy="export the recording again")
    return raw


def read_text(path: str | Path, limit_bytes: float = LIMIT_BYTES) -> str:
    r"""Return the text of a file with ``\n`` line ends.

    UTF-8, UTF-16 and UTF-32 (by their byte order mark, UTF-16 also without one) and, where bytes
    are not UTF-8, Latin-1, in which every byte is a letter.
    """
    raw = read_bytes(path, limit_bytes)
    encoding = _encoding_of(raw)
    try:
        text = raw.decode(encoding)
    except UnicodeDecodeError as error:
        if encoding != "utf-8":
            raise FileError(
                path,
                f"starts as {encoding} text, but byte {error.start} does not continue it",
                where=f"byte {error.start}",
                remedy="save it again as UTF-8",
            ) from None
        text = raw.decode("latin-1")
    except UnicodeError as error:
        raise FileError(path, f"is not text ({error})", remedy="save it again as UTF-8") from None
    null = text.find("\0")
    if null >= 0:
        raise FileError(
            path,
            "contains zero bytes, so it is not a text file",
            where=f"line {text.count(chr(10), 0, null) + 1}",
            remedy="check that its extension matches its format",
        )
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text


def numbers(
    lines: Sequence[str],
    path: str | Path,
    *,
    count: int | None = None,
    first_line: int = 1,
    delimiter: str | None = None,
    decimal: str = ".",
    short: bool = False,
    names: Sequence[str] | None = None,
) -> Float[Array, "n_rows n_columns"]:
    r"""Return a table of numbers; NaN where a field is empty or marked as missing.

    Regular rows are parsed many at once; only a row with an empty field, a word or a wrong number
    of fields is parsed on its own.

    Args:
        lines: Rows, without line ends. Blank rows are skipped.
        count: Fields per row; by default as many as the first row has.
        first_line: Line number of ``lines[0]`` in the file, from 1.
        delimiter: A tab, ``","``, ``";"`` or None for any white space. Only with a delimiter can
            a field be empty.
        decimal: ``","`` if the file writes 1,5 for 1.5.
        short: Whether a row may have fewer fields than ``count``; the rest is NaN.

    Raises:
        FileError: With line and field, if a field is not a number or a row has the wrong length.
    """
    kept = [(n, line) for n, line in enumerate(lines, start=first_line) if not _blank(line)]
    if not kept:
        return np.empty((0, count or 0))
    if count is None:
        count = len(_fields(_with_point(kept[0][1], decimal), delimiter))
    values = np.full((len(kept), count), np.nan)
    for start in range(0, len(kept), ROWS_AT_ONCE):
        part = kept[start : start + ROWS_AT_ONCE]
        rows, out = (
            [_with_point(row, decimal) for _, row in part],
            values[start : start + len(part)],
        )
        plain = _token_counts(rows, delimiter) == count
        text = "\n".join(row for row, good in zip(rows, plain, strict=True) if good)
        if delimiter is not None and not delimiter.isspace():
            text = text.replace(delimiter, " ")
        flat = parse_numbers(text)
        if flat is None or flat.size != count * int(plain.sum()):
            plain[:] = False
        else:
            out[plain] = flat.reshape(-1, count)
        for i in np.flatnonzero(~plain):
            out[i] = _parse_row(rows[i], path, part[i][0], count, delimiter, short, names)
        out[~np.isfinite(out)] = np.nan
    return values


def _with_point(row: str, decimal: str) -> str:
    return row.replace(",", ".") if decimal == "," else row


def check_time(
    time: Float[Array, " n_rows"], rows: Sequence[str], path: str | Path, *, first_line: int
) -> None:
    """Raise a FileError unless every row of a table has a time [s] and it increases.

    Args:
        time: Time of each row that is not blank [s].
        rows: The rows as text, blank ones among them.
        first_line: Line number of ``rows[0]`` in the file, from 1.
    """
    bad = ~np.isfinite(time)
    bad[1:] |= ~(np.diff(time) > 0)
    if not bad.any():
        return
    k = int(np.argmax(bad))
    kept = [n for n, row in enumerate(rows, start=first_line) if not _blank(row)]
    what = (
        f"has time {time[k]:g} s after {time[k - 1]:g} s" if np.isfinite(time[k]) else "has no time"
    )
    raise FileError(
        path,
        f"this row {what}; time must increase",
        where=f"line {kept[k]}",
        remedy="sort the rows by time and remove repeated ones",
    )


def count_of(word: str) -> int | None:
    """Return a count of a header, None if the word is not one."""
    return int(word) if word.isascii() and word.isdigit() and len(word) < 10 else None


def parse_numbers(text: str) -> Float[Array, " n"] | None:
    """Return all numbers of a text in one pass, None if it holds anything else."""
    if not text.strip():
        return np.empty(0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            return np.fromstring(text, sep=" ")
        except (DeprecationWarning, ValueError, UnicodeError):
            return None


def number(word: str, path: str | Path, *, where: str, what: str) -> float:
    """Return one number of a header."""
    try:
        value = float(word)
    except ValueError:
        value = float("nan")
    if not np.isfinite(value):
        raise FileError(
            path,
            f"{what} is {word[:40]!r}, not a number",
            where=where,
            remedy="correct the header or export the file again",
        )
    return value


def unique_labels(labels: Sequence[str], warnings: list[str]) -> tuple[str, ...]:
    """Return unique labels, with numbers for repeated ones, and add a warning if there are any.

    Example:
        >>> unique_labels(["LKNE", "RKNE", "LKNE"], [])
        ('LKNE', 'RKNE', 'LKNE_2')
    """
    taken, used = set(labels), set[str]()
    following: dict[str, int] = {}  # next number of each repeated label
    names = []
    for label in labels:
        new = label
        if label in used:
            k = following.get(label, 2)
            while (new := f"{label}_{k}") in taken or new in used:
                k += 1
            following[label] = k + 1
        used.add(new)
        names.append(new)
    if following:
        warnings.append(f"repeated labels were numbered: {listed(list(following))}")
    return tuple(names)


def _encoding_of(raw: bytes) -> str:
    for mark, encoding in _BYTE_ORDER_MARKS:
        if raw.startswith(mark):
            return encoding
    head = np.frombuffer(raw[: min(4096, len(raw) - len(raw) % 2)], dtype=np.uint8)
    if len(head) == 0:
        return "utf-8"
    zero_even, zero_odd = (head[0::2] == 0).mean(), (head[1::2] == 0).mean()
    if zero_odd > 0.8 and zero_even < 0.1:
        return "utf-16-le"
    if zero_even > 0.8 and zero_odd < 0.1:
        return "utf-16-be"
    return "utf-8"


def _blank(line: str) -> bool:
    return not line or line.isspace()


def _fields(row: str, delimiter: str | None) -> list[str]:
    if delimiter is None:
        return row.split()
    return [field.strip() for field in row.rstrip("\n\r ").split(delimiter)]


def _token_counts(rows: list[str], delimiter: str | None) -> np.ndarray:
    """Return the number of non-empty fields of each row, counted on bytes."""
    lengths = np.fromiter((len(row) for row in rows), dtype=np.int64, count=len(rows))
    data = np.frombuffer(
        ("\n".join(rows) + "\n").encode("latin-1", errors="replace"), dtype=np.uint8
    )
    gap = data <= 32
    if delimiter is not None:
        gap |= data == ord(delimiter)
    starts = ~gap
    starts[1:] &= gap[:-1]
    ends = np.concatenate([[0], np.cumsum(lengths + 1)[:-1]])
    return np.add.reduceat(starts.astype(np.int64), ends)


def _parse_row(row, path, line, count, delimiter, short, names) -> np.ndarray:
    fields = _fields(row, delimiter)
    if len(fields) > count and not any(fields[count:]):  # rows that end in delimiters
        fields = fields[:count]
    if len(fields) > count or (len(fields) < count and not short):
        raise FileError(
            path,
            f"this row has {len(fields)} fields where {count} are expected",
            where=f"line {line}",
            remedy="export the file again, or delete the row if the file was truncated there",
        )
    values = np.full(count, np.nan)
    for column, field in enumerate(fields):
        try:
            values[column] = float(field)
        except ValueError:
            if field.strip("\"'").lower() in MISSING_WORDS:
                continue
            name = f" ({names[column]})" if names is not None and column < len(names) else ""
            raise FileError(
                path,
                f"{field[:40]!r} is not a number",
                where=f"line {line}, field {column + 1}{name}",
                remedy="write a number, or leave the field empty if the value is missing",
            ) from None
    return values

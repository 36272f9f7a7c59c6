"""Large tables, a piece at a time: Parquet where pyarrow is installed, and CSV.

Rows are read twice, once for the columns and once to be written, and never held together.
"""

import csv
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from importlib.util import find_spec
from itertools import islice
from pathlib import Path
from typing import Any, Literal

from plantigrade.io.writing import whole_file
from plantigrade.printable import cell

CHUNK_ROWS = 5_000
"""Rows that are written at a time, a row group of Parquet: some MB of a table of 200 columns."""

Kind = Literal["bool", "int", "float", "word"]
"""Type of the values of a column; any value may be absent."""
Row = Mapping[str, Any]


def has_parquet() -> bool:
    """Return whether the library that writes Parquet is installed (extra ``tables``)."""
    return find_spec("pyarrow") is not None


def columns_of(rows: Iterable[Row], first: Sequence[str] = ()) -> dict[str, Kind]:
    """Return the columns of rows in the order in which they come, and what each holds.

    Args:
        rows: The rows; values are words, numbers, booleans or None.
        first: Columns that come first, in this order; words where no row has them.
    """
    found: dict[str, Kind | None] = dict.fromkeys(first)
    for row in rows:
        for name, value in row.items():
            if value is None:
                found.setdefault(name, None)
                continue
            here, before = kind_of(value), found.get(name)
            if before is None or before == here:
                found[name] = here
            else:
                found[name] = "float" if {before, here} == {"int", "float"} else "word"
    columns: dict[str, Kind] = {name: kind or "word" for name, kind in found.items()}
    return columns


def kind_of(value: Any) -> Kind:
    """Return what kind of column a value is of.

    Example:
        >>> [kind_of(value) for value in (True, 1, 0.5, "ok")]
        ['bool', 'int', 'float', 'word']
    """
    if isinstance(value, bool):
        return "bool"
    if isinstance(value, int) and abs(value) < 2**63:
        return "int"
    return "float" if isinstance(value, int | float) else "word"


def write_tables(
    folder: Path, name: str, rows: Callable[[], Iterator[Row]], columns: Mapping[str, Kind],
    *, also_csv: bool = True, repeating: Sequence[str] = (),
) -> list[str]:  # fmt: skip
    """Write rows as ``NAME.parquet`` and ``NAME.csv``, each whole or not at all.

    Args:
        name: Name of the files without ending.
        rows: Returns the rows anew.
        columns: As :func:`columns_of` returns them.
        also_csv: Whether there is a CSV file beside Parquet; without pyarrow there always is.
        repeating: Columns of words of which few differ; Parquet keeps each word once.

    Returns:
        Names of the files.

    Raises:
        FileError: If one cannot be written.
    """
    written = []
    if has_parquet():
        written.append(_whole(folder / f"{name}.parquet", lambda path: _parquet(
            path, rows(), columns, repeating)))  # fmt: skip
    if also_csv or not written:
        written.append(_whole(folder / f"{name}.csv", lambda path: _csv(path, rows(), columns)))
    return written


def _whole(path: Path, write: Callable[[Path], None]) -> str:
    with whole_file(path) as part:
        write(part)
    return path.name


def _csv(path: Path, rows: Iterable[Row], columns: Mapping[str, Kind]) -> None:
    with path.open("w", encoding="utf-8", errors="backslashreplace", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(columns)
        for row in rows:
            writer.writerow([cell(row.get(name)) for name in columns])


def _parquet(
    path: Path, rows: Iterable[Row], columns: Mapping[str, Kind], repeating: Sequence[str]
) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    types = {"bool": pa.bool_(), "int": pa.int64(), "float": pa.float64(), "word": pa.string()}
    word = pa.dictionary(pa.int32(), pa.string())
    schema = pa.schema(
        [(name, word if name in repeating else types[kind]) for name, kind in columns.items()]
    )
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        source = iter(rows)
        while chunk := list(islice(source, CHUNK_ROWS)):
            arrays = [
                pa.array([_as(kind, row.get(name)) for row in chunk], schema.field(name).type)
                for name, kind in columns.items()
            ]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))


def _as(kind: Kind, value: Any) -> Any:
    """Return a value as its column holds it."""
    if value is None:
        return None
    if kind == "word":
        return str(value).encode("utf-8", "backslashreplace").decode()
    return float(value) if kind == "float" else value

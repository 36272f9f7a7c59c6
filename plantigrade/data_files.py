"""Data files of the package beside the modules that read them: tables as CSV, trees as TOML."""

import csv
import tomllib
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, TypeVar, get_type_hints

Row = TypeVar("Row")


def csv_rows(package: str, name: str, row: type[Row]) -> tuple[Row, ...]:
    """Return the rows of a table, each as an instance of a dataclass.

    Args:
        name: Name of the file; its first line names fields of ``row``, lines with ``#`` before it
            explain the table.
        row: Dataclass whose fields are words and numbers; an empty number is its default.
    """
    kinds = get_type_hints(row)
    table = csv.DictReader(_lines(package, name))
    return tuple(
        row(**{k: _value(text, kinds[k]) for k, text in cells.items() if text or kinds[k] is str})
        for cells in table
    )


def number_table(package: str, name: str, count: int = 1) -> dict[str, tuple[float, ...]]:
    """Return the numbers of a table by the name at the beginning of the row.

    Args:
        name: Name of the file; lines with ``#`` explain the table, the first other has headings.
        count: Columns of numbers; those after them, in words, are for the reader of the file.
    """
    rows = list(csv.reader(_lines(package, name)))[1:]
    return {row[0]: tuple(float(cell) for cell in row[1 : 1 + count]) for row in rows}


def named_numbers(package: str, name: str) -> dict[str, float]:
    """Return the numbers of a table with one number a row, by name; see :func:`number_table`."""
    return {key: value for key, (value,) in number_table(package, name).items()}


def _lines(package: str, name: str) -> list[str]:
    """Return the lines of a file without those that explain it."""
    lines = (files(package) / name).read_text("utf-8").splitlines()
    return [line for line in lines if not line.startswith("#")]


def _value(text: str, kind: Any) -> str | int | float:
    return kind(text) if kind in (int, float) else text


@dataclass(frozen=True)
class _Spellings:
    name: str
    midline: str
    spellings: str


def spelling_tables(
    name: str,
) -> tuple[dict[str, tuple[str, ...]], dict[str, tuple[str, ...]]]:
    """Return name → spellings, of what has a side and of what lies on the midline.

    Args:
        name: Name of the file, a table of names, of ``x`` on the midline, and of spellings.
    """
    rows = csv_rows("plantigrade.models", name, _Spellings)
    sided, midline = (
        {row.name: tuple(row.spellings.split()) for row in rows if bool(row.midline) == middle}
        for middle in (False, True)
    )
    return sided, midline


def toml_tree(package: str, name: str) -> dict[str, Any]:
    """Return the contents of a TOML file of a package."""
    return tomllib.loads((files(package) / name).read_text("utf-8"))

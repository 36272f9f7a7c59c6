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
    lines = (files(package) / name).read_text("utf-8").splitlines()
    kinds = get_type_hints(row)
    table = csv.DictReader(line for line in lines if not line.startswith("#"))
    return tuple(
        row(**{k: _value(text, kinds[k]) for k, text in cells.items() if text or kinds[k] is str})
        for cells in table
    )


def _value(text: str, kind: Any) -> str | int | float:
    return kind(text) if kind in (int, float) else text


@dataclass(frozen=True)
class _Spellings:
    name: str
    midline: str
    spellings: str


def spelling_tables(
    package: str, name: str
) -> tuple[dict[str, tuple[str, ...]], dict[str, tuple[str, ...]]]:
    """Return name → spellings, of what has a side and of what lies on the midline.

    Args:
        name: Name of the file, a table of names, of ``x`` on the midline, and of spellings.
    """
    rows = csv_rows(package, name, _Spellings)
    sided, midline = (
        {row.name: tuple(row.spellings.split()) for row in rows if bool(row.midline) == middle}
        for middle in (False, True)
    )
    return sided, midline


def toml_tree(package: str, name: str) -> dict[str, Any]:
    """Return the contents of a TOML file of a package."""
    return tomllib.loads((files(package) / name).read_text("utf-8"))

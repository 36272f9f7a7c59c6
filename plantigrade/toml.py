"""TOML files of users, read safely: of limited size and depth, with numbers that fit in 64 bits."""

import tomllib
from pathlib import Path
from typing import Any

from plantigrade.errors import FileError, not_ordinary

MAX_BYTES = 2**20  # Maximum size of a file [bytes]; files written by hand have some kilobytes
MAX_DEPTH = 32  # Maximum depth of nested tables and lists; task files have three


def read_toml(path: str | Path) -> str:
    """Return the text of a TOML file."""
    path = Path(path)
    try:
        if path.exists() and not path.is_file() and not path.is_dir():
            raise not_ordinary(path)
        with open(path, "rb") as file:
            raw = file.read(MAX_BYTES + 1)
        text = raw.decode("utf-8")
    except OSError as error:
        raise FileError(path, f"cannot be read ({error.strerror})") from error
    except FileError:
        raise
    except ValueError as error:  # no UTF-8, or a zero byte in the name
        raise FileError(path, f"is not a TOML file: {error}", remedy="save it as UTF-8") from error
    if len(raw) > MAX_BYTES:
        remedy = "name a file written by hand"
        raise FileError(path, f"is larger than {MAX_BYTES // 2**20} MiB", remedy=remedy)
    return text


def parse_toml(text: str, path: str | Path, remedy: str = "") -> dict[str, Any]:
    """Return the contents of a TOML text."""
    try:
        document = tomllib.loads(text)
    except RecursionError as error:
        raise FileError(path, "is nested too deeply", remedy=remedy) from error
    except ValueError as error:
        raise FileError(path, f"is not a TOML file: {error}", remedy=remedy) from error
    _check(document, path, "", 0)
    return document


def _check(value: Any, path: str | Path, where: str, depth: int) -> None:
    if depth > MAX_DEPTH:
        remedy = "write tables one after the other"
        raise FileError(path, "is nested too deeply", where=where[:80], remedy=remedy)
    if isinstance(value, int) and not -(2**63) <= value < 2**63:
        raise FileError(path, "holds a number of too many digits", where=where, remedy="shorten it")
    if isinstance(value, dict):
        for key, inside in value.items():
            _check(inside, path, f"{where}.{key}".lstrip("."), depth + 1)
    elif isinstance(value, list):
        for inside in value:
            _check(inside, path, where, depth + 1)

"""``metrics.json`` of a folder of results: figures and settings as JSON that every parser reads."""

import json
import math
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from plantigrade.errors import FileError
from plantigrade.io.text import read_text
from plantigrade.printable import UNSAFE

METRICS = "metrics.json"
MAX_DEPTH = 32
"""Largest depth of lists and objects within each other; nothing that is written is deeper."""
_SIZE_LIMIT = 20 * 2**20  # [bytes] the figures of the largest batch are a twentieth of it


def metrics_json(metrics: Mapping[str, Any]) -> str:
    """Return ``metrics`` as JSON that every parser reads: NaN and infinity become null.

    Control characters, and bytes of file names that are no UTF-8, are escaped.

    Example:
        >>> print(metrics_json({"status": "ok", "speed_m_s": float("nan")}))
        {
          "status": "ok",
          "speed_m_s": null
        }
    """
    text = json.dumps(plain(metrics), indent=2, allow_nan=False, ensure_ascii=False)
    return UNSAFE.sub(lambda found: f"\\u{ord(found[0]):04x}", text)  # JSON has them in words only


def read_metrics(folder: str | Path) -> dict[str, Any]:
    """Return the contents of ``metrics.json`` of a folder of results."""
    folder = Path(folder).expanduser()
    if not folder.is_dir():
        what = "is not a folder" if folder.exists() else "there is no such folder"
        raise FileError(folder, what, remedy="name a run folder, as --out made it")
    path = folder / METRICS
    if not path.is_file():
        problem = f"is not a run folder: {METRICS} is missing"
        raise FileError(folder, problem, remedy="name a folder that a plantigrade command wrote")
    text = read_text(path, _SIZE_LIMIT)
    broken = partial(FileError, path, remedy="run the command again")
    try:
        metrics = json.loads(text, parse_int=_whole)
        _check_depth(metrics)
    except (ValueError, RecursionError) as error:
        where = f"line {error.lineno}" if isinstance(error, json.JSONDecodeError) else ""
        raise broken(f"is not JSON ({error})", where=where) from error
    if not isinstance(metrics, dict):
        raise broken("holds no object of metrics", where="line 1")
    return metrics


def _whole(word: str) -> int | float:
    """Return a whole number as JSON's readers have it: a float where it has many digits."""
    value = int(word)
    return value if abs(value) < 2**63 else float(word)


def _check_depth(value: Any, depth: int = 0) -> None:
    """Refuse what is nested more deeply than anything that is ever written."""
    if depth > MAX_DEPTH:
        raise ValueError("nested too deeply")
    if isinstance(value, dict | list):
        for part in value.values() if isinstance(value, dict) else value:
            _check_depth(part, depth + 1)


def plain(value: Any) -> Any:
    """Return ``value`` for JSON: arrays as lists, NaN and infinity as null."""
    if isinstance(value, Mapping):
        return {str(key): plain(item) for key, item in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value if isinstance(value, str | int | float | bool | None) else str(value)

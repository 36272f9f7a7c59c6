"""Values of TOML as the fields of a dataclass need them, and back."""

from collections import abc
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, get_args, get_origin

import numpy as np

from plantigrade.bounds import shown
from plantigrade.contact.site import Point
from plantigrade.errors import ParameterError
from plantigrade.options import is_real

MAX_NUMBER = 1e300  # Maximum magnitude of a number; larger ones overflow in use
_POINT = {"body": str, "position": tuple[float, float, float], "radius": float}
_NEEDED = {bool: "true or false", str: "a word in quotes", float: "a number"}


def is_number(value: Any, *, nan: bool = False) -> bool:
    """Return whether a value is a number; NaN only where that is allowed."""
    if not is_real(value):
        return False
    if value != value:
        return nan
    return value in (float("inf"), -float("inf")) or -MAX_NUMBER <= value <= MAX_NUMBER  # type: ignore[operator]


def in_radians(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table whose keys with ``_deg`` behind them are in radians, and without it."""

    def turned(value: Any) -> Any:
        if isinstance(value, dict):
            return {k: turned(v) for k, v in value.items()}
        if isinstance(value, list):
            return [turned(v) for v in value]
        return float(np.deg2rad(value)) if is_number(value) else value

    return {
        k.removesuffix("_deg"): turned(v) if k.endswith("_deg") else v for k, v in given.items()
    }


def as_field(kind: Any, value: Any) -> Any:
    """Return a value as a field of that type needs it."""
    if kind in _NEEDED:
        if not (is_number(value) if kind is float else isinstance(value, kind)):
            raise ParameterError(f"is {shown(value)}; {_NEEDED[kind]} is needed")
        return kind(value)
    if kind is Point:
        if not isinstance(value, dict) or "body" not in value or set(value) - set(_POINT):
            raise ParameterError(
                'a point is written { body = "hand_r", position = [0.0, 0.0, -0.1] }'
            )
        return Point(**{key: as_field(_POINT[key], entry) for key, entry in value.items()})
    if get_origin(kind) is abc.Mapping:
        if not isinstance(value, dict):
            raise ParameterError(f"is {shown(value)}; a table {{ knee_angle = 1.0 }} is needed")
        out = {}
        for key, entry in value.items():
            try:
                out[key] = as_field(get_args(kind)[1], entry)
            except ParameterError as error:
                raise ParameterError(f"{key} {error}") from error
        return out
    n = len(get_args(kind))
    numbers = isinstance(value, list) and all(is_number(x, nan=True) for x in value)
    if not numbers or len(value) != n:
        raise ParameterError(f"is {shown(value)}; {n} numbers in brackets are needed")
    return tuple(float(v) for v in value)


def table(title: str, content: Mapping[str, Any]) -> str:
    """Return a table as text."""
    lines = [f"{key} = {_text(value)}" for key, value in content.items()]
    return "\n".join([title, *lines, ""])


def _text(value: Any) -> str:
    """Return a value as TOML."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return f'"{escaped}"'
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{k} = {_text(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_text(v) for v in value) + "]"
    if is_dataclass(value):
        return _text({f.name: getattr(value, f.name) for f in fields(value)})
    return repr(value)

"""The numbers of a controller's settings by dotted name, such as ``swing.clearance``.

Settings are frozen dataclasses of numbers, and of further settings, one per component.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from typing import Any

from plantigrade.errors import ParameterError
from plantigrade.options import number_of, refuse_unknown, shown
from plantigrade.signatures import meanings

SWITCH = {"true": True, "false": False}
MAX_FACTOR = 100.0  # by which a number may be greater than it is: beyond it units are confused
MAX_COUNT_FACTOR = 10  # the same of whole numbers, which multiply time and memory


@dataclass(frozen=True)
class Setting:
    """One number, word or switch."""

    name: str  #: Its dotted name
    value: Any  #: Its value
    meaning: str  #: Its meaning, unit and reason


def numbers_of(settings: Any, prefix: str = "") -> Iterator[Setting]:
    """Yield all numbers of settings, those of components after their own."""
    docs = meanings(type(settings))
    parts = []
    for each in fields(settings):
        value = getattr(settings, each.name)
        if is_dataclass(value):
            parts.append((each.name, value))
        else:
            yield Setting(prefix + each.name, value, docs.get(each.name, ""))
    for name, part in parts:
        yield from numbers_of(part, f"{prefix}{name}.")


def changed(settings: Any, values: Mapping[str, Any], what: str = "a controller") -> Any:
    """Return settings in which some numbers have other values.

    Args:
        settings: The settings.
        values: Value by dotted name; a word of the command line becomes what the setting takes.
        what: Name of their owner, for the message.

    Raises:
        ParameterError: If there is no such setting, or it cannot have such a value.
    """
    known = {each.name: each.value for each in numbers_of(settings)}
    refuse_unknown(what, values, known)
    for name, value in values.items():
        settings = _changed(settings, name.split("."), _typed(name, value, known[name]))
    return settings


def differences(settings: Any) -> dict[str, Any]:
    """Return the numbers that are not those of the class, by dotted name."""
    default = {each.name: each.value for each in numbers_of(type(settings)())}
    every = {each.name: each.value for each in numbers_of(settings)}
    return {name: value for name, value in every.items() if value != default[name]}


def _changed(settings: Any, path: list[str], value: Any) -> Any:
    name, *rest = path
    if rest:
        value = _changed(getattr(settings, name), rest, value)
    return replace(settings, **{name: value})


def _typed(name: str, value: Any, before: Any) -> Any:
    """Return a value of the type that a setting has; a word becomes one."""
    try:
        if isinstance(before, bool):
            given = SWITCH[value.lower()] if isinstance(value, str) else value
            if isinstance(given, bool):
                return given
        elif isinstance(before, str):
            if isinstance(value, str):
                return value
        elif isinstance(before, tuple):
            given = value.split(",") if isinstance(value, str) else value
            if len(given) == len(before):
                return tuple(_typed(name, *pair) for pair in zip(given, before, strict=True))
        elif not isinstance(value, bool):
            kind = int if isinstance(before, int) else float
            given = number_of(kind, value) if isinstance(value, str) else kind(value)
            if given == given and abs(given) != float("inf"):
                return _within(name, given, before)
    except ParameterError:
        raise
    except (ValueError, KeyError, TypeError, OverflowError):
        pass
    kinds = {bool: "true or false", str: "a word", tuple: "as many numbers", int: "a whole number"}
    allowed = kinds.get(type(before), "a finite number")
    raise ParameterError(f"{name} must be {allowed}, such as {shown(before)}, not {shown(value)}")


def _within(name: str, value: float, before: float) -> float:
    """Return a number of the order of magnitude and sign of the usual one, or zero."""
    far = before * (MAX_COUNT_FACTOR if isinstance(before, int) else MAX_FACTOR)
    low, high = min(far, 0.0), max(far, 0.0)
    if before and not low <= value <= high:
        raise ParameterError(f"{name} must be {low:g} to {high:g}, not {shown(value)}")
    return value

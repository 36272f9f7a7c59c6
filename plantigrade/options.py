"""Settings as options of the command line, and the types that they accept from Python.

Settings are dataclasses; a command inherits them, and each field becomes an option with the line
under it as its help. From Python the same fields are keywords.
"""

import difflib
import math
import os
from collections.abc import Iterable, Mapping
from dataclasses import fields
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, TypeGuard, Union, get_args, get_origin, get_type_hints

import tyro

from plantigrade.errors import ParameterError

LEARNED = "learned"
"""Controller that is a policy of the package."""
POLICY_SUFFIXES = (".npz", ".onnx")
"""Ends of the names of files of policies."""


def number_of(kind: type, word: str) -> Any:
    """Return the number that an argument of the command line spells."""
    try:
        return kind(word)
    except (ValueError, OverflowError):
        what = "whole number" if kind is int else "number"
        shown = word if len(word) <= 40 else f"{word[:40]}…"
        raise ValueError(f"{shown!r} is not a {what}") from None


def optional(metavar: str, text: str | None = None):
    """Return the annotation of an argument, or an option without default: its metavar and help.

    ``text`` is its help, in place of the line under the field.
    """
    return tyro.conf.arg(metavar=metavar, help_behavior_hint="", help=text)


Metres = Annotated[float | None, optional("METRES")]
Years = Annotated[float | None, optional("YEARS")]
Kilograms = Annotated[float | None, optional("KG")]
OptionalPath = Annotated[Path | None, optional("PATH")]
OutPath = Annotated[
    Path | None, tyro.conf.arg(metavar="PATH", help_behavior_hint="", aliases=("-o",))
]
"""What a command writes: ``--out``, or ``-o`` as elsewhere."""
OptionalWord = Annotated[str | None, optional("TEXT")]
Sex = Annotated[Literal["female", "male"] | None, optional("{female,male}")]
Feet = Annotated[
    Literal["rigid", "two-segment", "multi-segment"] | None,
    optional("{rigid,two-segment,multi-segment}"),
]
Joints = Annotated[Literal["42", "43", "58", "66"] | None, optional("{42,43,58,66}")]
Flag = Annotated[bool, tyro.conf.arg(help_behavior_hint="")]
Number = Annotated[float | None, optional("NUMBER")]
Seconds = Annotated[float | None, optional("S")]
Cadence = Annotated[float | None, optional("STEPS/MIN")]
Degrees = Annotated[
    float,
    tyro.constructors.PrimitiveConstructorSpec(
        nargs=1,
        metavar="DEG",
        instance_from_str=lambda words: math.radians(number_of(float, words[0])),
        is_instance=lambda value: isinstance(value, float),
        str_from_instance=lambda value: [f"{math.degrees(value):g}"],
    ),
]
"""Angle in radians; in degrees on the command line."""


@cache
def _hints(kind: type) -> dict[str, Any]:
    """Return the types of the fields of a dataclass, without the marks of the command line."""
    hints = get_type_hints(kind)
    return {f.name: hints[f.name] for f in fields(kind)}


def check_types(settings: Any) -> None:
    """Convert every field of a frozen dataclass to its annotated type.

    NumPy numbers, integers for floats, texts for paths and lists for tuples are converted.
    """
    for name, hint in _hints(type(settings)).items():
        value = getattr(settings, name)
        try:
            converted = _as(hint, value)
        except (TypeError, ValueError, OverflowError):
            raise ParameterError(f"{name} must be {_in_words(hint)}, not {shown(value)}") from None
        if converted is not value:
            object.__setattr__(settings, name, converted)


def as_path(value: Any, what: str) -> Path:
    """Return the path of a file or folder."""
    if isinstance(value, str | os.PathLike) and str(value):
        return Path(value)
    raise ParameterError(f"{what} must be the path of a file or folder, not {shown(value)}")


def refuse_unknown(what: str, given: Iterable[str], allowed: Iterable[str]) -> None:
    """Check that all given options exist."""
    names = list(allowed)
    for name in given:
        if name not in names:
            near = difflib.get_close_matches(name, names, n=1)
            hint = f"did you mean {near[0]!r}? " if near else ""
            has = f"it has {', '.join(names)}" if names else "it has none"
            raise ParameterError(f"{what} has no option {name!r}; {hint}{has}")


def _as(hint: Any, value: Any) -> Any:
    """Return a value converted to a type, or raise TypeError or ValueError."""
    kind, arguments = get_origin(hint), get_args(hint)
    if kind in (Union, UnionType):
        if value is None and NoneType in arguments:
            return None
        (hint,) = (each for each in arguments if each is not NoneType)
        return _as(hint, value)
    if kind is Literal:
        if isinstance(value, Integral) and not isinstance(value, bool):
            value = str(value)  # a joint set is named by its number of coordinates
        return _only(value, isinstance(value, str) and value in arguments)
    if kind is tuple:
        _only(value, not isinstance(value, str | bytes | Mapping))
        values = tuple(value)
        if len(arguments) == 2 and arguments[1] is Ellipsis:
            arguments = arguments[:1] * len(values)
        converted = tuple(_as(h, v) for h, v in zip(arguments, values, strict=True))
        return value if type(value) is tuple and converted == value else converted
    if hint is bool:
        return value if isinstance(value, bool) else _only(value, _is_numpy_bool(value)).item()
    if hint in (int, float):
        real = Integral if hint is int else Real
        return hint(_only(value, isinstance(value, real) and not isinstance(value, bool)))
    if hint is Path:
        return Path(_only(value, isinstance(value, str | os.PathLike) and str(value) != ""))
    return _only(value, hint is not str or isinstance(value, str))


def is_real(value: Any) -> TypeGuard[float]:
    """Return whether a value is a number, which true and false are not."""
    return isinstance(value, Real) and not isinstance(value, bool)


def _only(value: Any, allowed: bool) -> Any:
    if not allowed:
        raise TypeError
    return value


def shown(value: Any) -> str:
    """Return a value for a message: shortened, six digits.

    Example:
        >>> shown(0.1 + 0.2), shown(10**400), shown("x" * 99)
        ('0.3', 'a number of more than 300 digits', "'xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx …")
    """
    if is_real(value):
        if isinstance(value, Integral) and abs(int(value)) >= 10**300:
            return "a number of more than 300 digits"
        return f"{float(value):g}"
    text = repr(value)
    return text if len(text) <= 40 else f"{text[:38]} …"


def _is_numpy_bool(value: Any) -> bool:
    return type(value).__module__ == "numpy" and type(value).__name__ in ("bool", "bool_")


def _in_words(hint: Any) -> str:
    """Return the description of a type for a message.

    Example:
        >>> _in_words(float | None), _in_words(tuple[float, float, float])
        ('a number', '3 numbers')
    """
    kind, arguments = get_origin(hint), get_args(hint)
    if kind in (Union, UnionType):
        return " or ".join(_in_words(each) for each in arguments if each is not NoneType)
    if kind is Literal:
        return " or ".join(map(repr, arguments))
    if kind is tuple:
        return "numbers" if Ellipsis in arguments else f"{len(arguments)} numbers"
    words = {bool: "True or False", int: "a whole number", float: "a number", str: "a text"}
    return words.get(hint, "the path of a file or folder" if hint is Path else "another value")


def assignments(words: Iterable[str]) -> dict[str, str]:
    """Return value by name, of words such as ``swing.clearance=0.05``."""
    found: dict[str, str] = {}
    for word in words:
        name, equals, value = word.partition("=")
        if not (equals and name.strip() and value.strip()) or name.strip() in found:
            raise ParameterError(
                f"set={shown(word)}: give each setting once, as NAME=VALUE; the help of a "
                "controller lists them: plantigrade simulate --controller NAME --help"
            )
        found[name.strip()] = value.strip()
    return found


def is_policy(word: str | None) -> bool:
    """Return whether the word of a controller names a trained policy."""
    return word is not None and (word == LEARNED or word.endswith(POLICY_SUFFIXES))

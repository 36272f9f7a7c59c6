"""Functions that take the fields of settings classes as keywords, and show it.

``fit(path, height=1.80)`` passes ``height`` to :class:`FitSettings`. :func:`takes` gives such a
function the signature and the docstring it would have if every field were written out, for
``help``, for Tab, and for the documentation. Checkers of types and editors read the same from
``plantigrade/__init__.pyi``, which is made from these signatures.
"""

import ast
import inspect
import sys
import textwrap
from collections.abc import Callable, Iterable, Sequence
from dataclasses import MISSING, dataclass, fields, is_dataclass, replace
from functools import cache, reduce
from operator import or_
from pathlib import Path
from types import UnionType
from typing import Annotated, Any, Literal, TypeVar, Union, get_args, get_origin, get_type_hints

Function = TypeVar("Function", bound=Callable[..., Any])

OPTIONS = "options"
"""Name of the parameter ``**options``, and of the entry in the docstring that is replaced."""
IN_DEGREES = "DEG"
"""Mark of a field in radians that the command line takes, and documents, in degrees."""
VARIES = type("Varies", (), {"__repr__": lambda self: "..."})()
"""Default of an option that depends on other arguments."""
WIDTH = 96  # [characters] length of a line of a docstring


@dataclass(frozen=True)
class Option:
    """A keyword of a function."""

    name: str  #: Its name
    kind: Any  #: The type of what it takes
    default: Any  #: Its value where it is not given; :data:`VARIES` where that depends on others
    meaning: str  #: What it is, with its unit


def options_of(settings: type, without: Iterable[str] = ()) -> list[Option]:
    """Return the fields of a settings class as keywords of a function."""
    hints, docs = get_type_hints(settings, include_extras=True), meanings(settings)
    found = []
    for each in fields(settings):
        if each.name not in without:
            hint, meaning = hints[each.name], docs.get(each.name, "")
            if IN_DEGREES in {getattr(mark, "metavar", "") for mark in get_args(hint)[1:]}:
                meaning = meaning.replace("[deg]", "[rad]")
            default = VARIES if each.default is MISSING else each.default
            found.append(Option(each.name, accepted(hint), default, meaning))
    return found


def takes(
    *settings: type, without: Iterable[str] = (), more: Sequence[Option] = ()
) -> Callable[[Function], Function]:
    """Return a decorator of functions that end in ``**options``.

    Args:
        settings: Classes whose fields are the options.
        without: Fields that are no options.
        more: Further options.

    Returns:
        It replaces ``**options`` in the signature, and the entry ``options`` of the docstring, by
        the options that are not parameters already.
    """

    def decorated(function: Function) -> Function:
        signature = inspect.signature(function)
        own = [p for name, p in signature.parameters.items() if name != OPTIONS]
        taken = {p.name for p in own} | {*without}
        every = [option for kind in settings for option in options_of(kind)]
        chosen = {o.name: o for o in (*every, *more) if o.name not in taken}
        added = [
            inspect.Parameter(o.name, inspect.Parameter.KEYWORD_ONLY, default=o.default,
                              annotation=o.kind)
            for o in chosen.values()
        ]  # fmt: skip
        function.__signature__ = signature.replace(parameters=[*own, *added])  # type: ignore[attr-defined]
        if function.__doc__:
            function.__doc__ = _with_entries(function.__doc__, chosen.values())
        return function

    return decorated


def of_variants(variants: dict[str, type], without: Iterable[str] = ()) -> list[Option]:
    """Return the options of a function that takes one of several settings classes, by a word.

    An option has the default of all classes that have it, or else :data:`VARIES`; its meaning
    names the words.
    """
    found: dict[str, dict[Option, list[str]]] = {}
    for word, kind in variants.items():
        for option in options_of(kind, without):
            found.setdefault(option.name, {}).setdefault(option, []).append(word)
    return [_merged(each) for each in found.values()]


def keywords_of(function: Callable[..., Any], owner: str) -> list[Option]:
    """Return the parameters with defaults of a function, with what its docstring says of them.

    Args:
        function: A function whose docstring has entries for them.
        owner: What has these options, named before their meaning.
    """
    lines = (inspect.getdoc(function) or "").split("\n")
    found = []
    for each in inspect.signature(function).parameters.values():
        if each.default is not each.empty:
            start, stop = _entry(lines, each.name)
            meaning = " ".join(" ".join(lines[start:stop]).split()).partition(": ")[2]
            found.append(Option(each.name, each.annotation, each.default, f"{owner}: {meaning}"))
    return found


def _merged(variants: dict[Option, list[str]]) -> Option:
    first, *others = variants
    texts: dict[str, list[str]] = {}
    for option, words in variants.items():
        texts.setdefault(option.meaning, []).extend(words)
    parts = [f"{text.rstrip('.')} ({', '.join(words)})" for text, words in texts.items()]
    kind = first.kind
    for other in others:
        kind = kind | other.kind
        if other.default != first.default:
            first = replace(first, default=VARIES)
    return replace(first, kind=kind, meaning="; ".join(parts) + ".")


def accepted(hint: Any) -> Any:
    """Return the type of what a field takes: a path also as text, a tuple as any sequence.

    Example:
        >>> accepted(Path), accepted(tuple[float, ...]), accepted(Literal["42"])
        (str | pathlib.Path, collections.abc.Sequence[float], typing.Literal['42', 42])
    """
    kind, arguments = get_origin(hint), get_args(hint)
    if kind is Annotated:
        return accepted(arguments[0])
    if kind in (Union, UnionType):
        return reduce(or_, map(accepted, arguments))
    if kind is Literal and all(str(word).isdigit() for word in arguments):
        return Literal[(*arguments, *map(int, arguments))]
    if kind is tuple:
        return Sequence[accepted(arguments[0])]
    return str | Path if hint is Path else hint


@cache
def meanings(kind: type) -> dict[str, str]:
    """Return the string under each field of a dataclass and of those it inherits."""
    found: dict[str, str] = {}
    for each in reversed(kind.__mro__):
        body = _classes(each.__module__).get(each.__qualname__, []) if is_dataclass(each) else []
        for field, text in zip(body, body[1:], strict=False):
            if (
                isinstance(field, ast.AnnAssign)
                and isinstance(field.target, ast.Name)
                and isinstance(text, ast.Expr)
                and isinstance(text.value, ast.Constant)
            ):
                found[field.target.id] = " ".join(str(text.value.value).split())
    return found


@cache
def _classes(module: str) -> dict[str, list[ast.stmt]]:
    """Return the statements of each class of a module by name; none where there is no source."""
    try:
        tree = ast.parse(inspect.getsource(sys.modules[module]))
    except (KeyError, OSError, TypeError, SyntaxError):
        return {}
    return {node.name: node.body for node in tree.body if isinstance(node, ast.ClassDef)}


def _with_entries(docstring: str, options: Iterable[Option]) -> str:
    """Return a docstring in which the entry ``options`` is one entry for each option."""
    lines = docstring.split("\n")
    start, stop = _entry(lines, OPTIONS)
    if start == stop:
        return docstring
    margin = _margin(lines[start])
    entries = [
        textwrap.fill(
            f"{o.name}: {o.meaning}",
            WIDTH,
            initial_indent=" " * margin,
            subsequent_indent=" " * (margin + 4),
            break_long_words=False,
            break_on_hyphens=False,
        )
        for o in options
    ]
    return "\n".join([*lines[:start], *entries, *lines[stop:]])


def _entry(lines: Sequence[str], name: str) -> tuple[int, int]:
    """Return the first line of the entry of a parameter in a docstring, and the line after it."""
    for start, line in enumerate(lines):
        if line.strip().startswith(f"{name}:"):
            stop = start + 1
            while stop < len(lines) and _margin(lines[stop]) > _margin(line):
                stop += 1
            return start, stop
    return 0, 0


def _margin(line: str) -> int:
    return len(line) - len(line.lstrip())

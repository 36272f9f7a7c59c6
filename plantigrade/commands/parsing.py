"""Words of the command line as the dataclasses of commands, complaints in words; completion.

How a number, or an option that may be absent, is read is said here and not left to the parser,
whose complaints would name types of Python.
"""

import contextlib
import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import tyro
from tyro.constructors import ConstructorRegistry, PrimitiveConstructorSpec, PrimitiveTypeInfo

from plantigrade.errors import ParameterError
from plantigrade.options import number_of

SHELLS = ("bash", "zsh", "fish")
CONFIG = (tyro.conf.FlagCreatePairsOff, tyro.conf.OmitArgPrefixes)
REGISTRY = ConstructorRegistry()


def parse(kind: Any, prog: str, words: Sequence[str], **options: Any) -> Any:
    """Return the dataclass ``kind`` that words fill.

    Raises:
        SystemExit: If the parser has printed its help (code 0) or its complaint (code 2).
        ParameterError: If a value is not allowed.
    """
    args = list(words)
    return tyro.cli(kind, prog=prog, args=args, config=CONFIG, registry=REGISTRY, **options)


def completion(shell: str, commands: Mapping[str, tuple[str, Any]]) -> str:
    """Return the script that completes ``plantigrade`` in a shell: commands, options, choices.

    Args:
        shell: One of :data:`SHELLS`.
        commands: Name → what it does, and its dataclass or a mapping of the same kind.
    """
    if shell not in SHELLS:
        raise ParameterError(f"no completion for {shell!r}; there is one for {', '.join(SHELLS)}")
    script = io.StringIO()
    with contextlib.redirect_stdout(script), contextlib.suppress(SystemExit):
        parse(_union(commands), "plantigrade", ["--tyro-print-completion", shell])
    text = script.getvalue()
    # Where nothing else fits, a file does.
    for before, after in (
        ("complete -F ", "complete -o default -F "),
        ("completions' completion_array", "completions' completion_array || _files"),
        ("complete --no-files ", "complete "),
    ):
        text = text.replace(before, after)
    return text


def _union(commands: Mapping[str, tuple[str, Any]]) -> Any:
    """Return the type of one of several commands."""
    kinds = [
        Annotated[
            _union(kind) if isinstance(kind, Mapping) else kind,
            tyro.conf.subcommand(name, description=what, prefix_name=False),
        ]
        for name, (what, kind) in commands.items()
    ]
    return Union[tuple(kinds)]  # noqa: UP007


@REGISTRY.primitive_rule
def _rule(info: PrimitiveTypeInfo) -> PrimitiveConstructorSpec | None:
    """Return how an option is read; None where the parser's own way will do."""
    hint = info.type
    arguments = get_args(hint)
    absent = get_origin(hint) in (Union, UnionType) and NoneType in arguments
    if absent and len(arguments) == 2:
        (hint,) = (each for each in arguments if each is not NoneType)
    many = get_origin(hint) is tuple
    kinds = get_args(hint)
    if hint in (int, float, str, Path):
        return _spec(1, hint.__name__.upper(), lambda words: _read(hint, words[0]))
    if get_origin(hint) is Literal:
        metavar = "{" + ",".join(kinds) + "}"
        return _spec(1, metavar, lambda words: words[0], choices=kinds)
    if absent and many and kinds[1:] == (Ellipsis,):
        read = lambda words: tuple(_read(kinds[0], word) for word in words)  # noqa: E731
        return _spec("*", "NUMBERS", read)
    if absent and many:
        read = lambda words: tuple(map(_read, kinds, words))  # noqa: E731
        return _spec(len(kinds), "NUMBERS", read)
    return None


def _spec(nargs: Any, metavar: str, read: Any, **more: Any) -> PrimitiveConstructorSpec:
    def written(value: Any) -> list[str]:
        return [str(v) for v in (value if isinstance(value, tuple) else (value,))]

    return PrimitiveConstructorSpec(
        nargs, metavar, read, lambda value: True, written, choices=more.get("choices")
    )


def _read(kind: Any, word: str) -> Any:
    return number_of(kind, word) if kind in (int, float) else kind(word)

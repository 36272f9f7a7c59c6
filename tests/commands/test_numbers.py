"""Every numeric option of every command: bounds are stated, kept, and zero is a value like others.

The options are found by walking the dataclasses of all commands, so a new one joins by itself.
"""

import importlib
import math
from dataclasses import MISSING, fields
from functools import cache
from pathlib import Path
from typing import Any, get_args, get_origin, get_type_hints

import pytest

from plantigrade.bounds import RADIAN, Bounded
from plantigrade.commands import main as command_line
from plantigrade.commands.synthesize import SUBCOMMANDS
from plantigrade.errors import ParameterError

BY_HAND = {"heights", "target", "compare"}  # lists of numbers, checked one by one
WORDS = ["0", "-0", "-1", "nan", "inf", "-inf", "1e308", "1e-308", "1e999", "9" * 5000, "1_0", "٣"]
VALUES = [0, -1, math.nan, math.inf, -math.inf, 1e308, 10**400, -(10**400), True, "1", [1], None]
FILES = {"fit": ["a.c3d"], "reproduce": ["a.c3d"], "view": ["run"], "report": ["run"]}
FILES |= {"convert": ["a.c3d", "b.trc"], "synthesize track": ["--recording", "a.c3d"]}


@cache
def commands() -> dict[str, type]:
    """Return every command by its words."""
    found = {f"synthesize {name}": kind for name, kind in SUBCOMMANDS.items()}
    for name in command_line.COMMANDS:
        module = importlib.import_module(f"plantigrade.commands.{name}")
        if name != "synthesize":
            found[name] = module.Command
    return found


def numeric(hint: Any) -> bool:
    """Return whether a field of this type takes numbers."""
    arguments = get_args(hint)
    return hint in (int, float) or (get_origin(hint) is not None and any(map(numeric, arguments)))


OPTIONS = [
    (words, field.name)
    for words, kind in commands().items()
    for field in fields(kind)
    if numeric(get_type_hints(kind)[field.name]) and field.name not in BY_HAND
]


def bounds(kind: type, name: str) -> tuple[float, float]:
    """Return the bounds of an option as the class has it, in radians where that is its unit."""
    ranges = (vars(base).get("ranges", {}) for base in kind.__mro__)
    low, high, unit = next((r[name] for r in ranges if name in r), (math.inf, -math.inf, ""))
    return (low / RADIAN, high / RADIAN) if unit == "degrees" else (low, high)


def once() -> list[tuple[str, str]]:
    """Return each option with each of its bounds once: the parser takes its time."""
    alike = {}
    for words, name in OPTIONS:
        alike.setdefault((name, bounds(commands()[words], name)), (words, name))
    return list(alike.values())


def test_options_are_found():
    assert {("demo", "speed"), ("fit", "cutoff"), ("synthesize walk", "steps")} <= set(OPTIONS)
    assert {("view", "port"), ("reproduce", "jobs"), ("model", "height")} <= set(OPTIONS)


@pytest.mark.parametrize(("words", "name"), OPTIONS)
def test_every_number_has_bounds(words, name):
    low, high = bounds(commands()[words], name)
    assert -math.inf < low < high < math.inf


@pytest.mark.parametrize(("words", "name"), once())
def test_a_number_is_within_bounds_or_refused(capsys, words, name):
    """Zero, signs, what is no number, and what is too large or too small for one."""
    kind = commands()[words]
    low, high = bounds(kind, name)
    for word in WORDS:
        command, *rest = words.split()
        given = [*rest, f"--{name.replace('_', '-')}", word, *FILES.get(words, [])]
        try:
            value = getattr(command_line.parse(command, given), name)
        except SystemExit as stop:
            assert stop.code == 2 and capsys.readouterr().err
        except ParameterError as error:
            assert name in str(error) and len(str(error)) < 200
        else:
            assert low - 1e-9 <= value <= high + 1e-9, word


@pytest.mark.wrong_types
@pytest.mark.parametrize(("words", "name"), OPTIONS)
def test_the_same_from_python(words, name):
    """A number within bounds, or a ParameterError; never one that is silently ignored."""
    kind = commands()[words]
    low, high = bounds(kind, name)
    several = (Path("a.c3d"),)
    needed = {
        f.name: several if get_origin(get_type_hints(kind)[f.name]) is tuple else several[0]
        for f in fields(kind)
        if f.default is f.default_factory is MISSING
    }
    for value in VALUES:
        try:
            made = kind(**needed, **{name: value})
        except ParameterError as error:
            assert name in str(error)
        else:
            kept = getattr(made, name)
            assert kept == value
            assert kept is None or low - 1e-9 <= kept <= high + 1e-9


@pytest.mark.parametrize("words", ["demo --height 0", "fit a.c3d --height 0", "fit a.c3d --mass 0"])
def test_zero_is_refused_in_one_sentence(capsys, words):
    assert command_line.main(words.split()) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1 and "for a person, not 0" in err


def test_a_class_of_its_own_keeps_the_bounds_it_inherits():
    """Bounds of every base class hold, whichever comes first."""
    for kind in commands().values():
        numbers = [f.name for f in fields(kind) if numeric(get_type_hints(kind)[f.name])]
        assert not set(numbers) - BY_HAND or issubclass(kind, Bounded)

"""The settings that vary from simulation to simulation of a batch: combinations and names."""

import itertools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields
from functools import partial
from typing import Any, get_args, get_origin, get_type_hints

from plantigrade.bounds import SEEDS
from plantigrade.control.choices import having, typed_setting
from plantigrade.errors import ParameterError
from plantigrade.models.person import Person
from plantigrade.options import number_of, refuse_unknown
from plantigrade.workflows.controller_options import WORDS, WalkOptions
from plantigrade.workflows.settings import RecordingSettings
from plantigrade.workflows.simulate_settings import SimulateSettings
from plantigrade.world import Controller

MAX_SIMULATIONS = 100_000  # Most simulations of a batch
NOTHING = "none"  # Word for no push, no rope, nothing said
_FITTED = {f.name for f in fields(RecordingSettings)}
OWN = tuple(f.name for f in fields(SimulateSettings) if f.name not in _FITTED)
"""Options of a simulation alone; ``own`` are those of its controller."""
_PERSON = tuple(f.name for f in fields(Person))

Variant = dict[str, Any]  # Option → its value in one simulation


def variants(
    how: SimulateSettings, vary: Mapping[str, Sequence[Any]], seeds: int, *, standing: bool
) -> list[Variant]:
    """Return what every simulation has of its own, all combinations; words as their types."""
    allowed = (*OWN, *_PERSON, *WORDS) if standing else (*OWN, *WORDS)
    refuse_unknown("a batch", (name for name in vary if not having(name)), allowed)
    if not 1 <= seeds <= MAX_SIMULATIONS or ("seed" in vary and seeds > 1):
        allowed_seeds = f"from 1 to {MAX_SIMULATIONS}, and 1 where seed varies"
        raise ParameterError(f"seeds={seeds} must be {allowed_seeds}")
    if how.seed + seeds - 1 > SEEDS[1]:
        raise ParameterError(f"seeds must not be greater than {SEEDS[1]}")
    axes = {
        name: checked_values(name, values, partial(typed, name)) for name, values in vary.items()
    }
    if seeds > 1:
        axes["seed"] = [how.seed + i for i in range(seeds)]
    return combinations(axes, "simulations")


def checked_values(
    name: str, values: Sequence[Any], convert: Callable[[Any], Any] = lambda value: value
) -> list[Any]:
    """Return the values of an option that varies; refuse none, or one that is given twice."""
    if isinstance(values, str) or not len(values):
        raise ParameterError(f"{name} varies: give a list of its values, not {values!r:.40}")
    found = [convert(value) for value in values]
    if any(value in found[:i] for i, value in enumerate(found)):
        raise ParameterError(f"{name}: a value is given twice")
    return found


def combinations(axes: Mapping[str, Sequence[Any]], what: str) -> list[dict[str, Any]]:
    """Return every combination of values; refuse too many of what a batch holds."""
    count = math.prod(map(len, axes.values()))
    if count > MAX_SIMULATIONS:
        raise ParameterError(f"{count} {what} are too many; at most {MAX_SIMULATIONS} in one batch")
    return [dict(zip(axes, each, strict=True)) for each in itertools.product(*axes.values())]


def typed(name: str, value: Any) -> Any:
    """Return a value of an option; a word of the command line becomes what the option takes.

    Example:
        >>> typed("stiffness", "0.5"), typed("push", "none"), typed("ground", "flat")
        (0.5, (), 'flat')
    """
    if having(name):
        return typed_setting(having(name)[0], name, value)
    hint = (get_type_hints(SimulateSettings) | get_type_hints(WalkOptions))[name]
    several = get_origin(hint) is tuple
    if not isinstance(value, str):
        return () if several and value is None else value
    if value == NOTHING:
        return () if several else None
    kinds = [kind for kind in (get_args(hint) or (hint,)) if kind in (int, float)]
    if several:
        return (value,)
    try:
        return number_of(kinds[0], value) if kinds else value
    except ValueError as error:
        raise ParameterError(f"{name}: {error}") from None


def settings_of(
    how: SimulateSettings, variant: Variant
) -> tuple[SimulateSettings, Controller | None]:
    """Return the settings of one simulation, and its controller where that is no word.

    Raises:
        ParameterError: If a value is not allowed.
    """
    changed, controller = dict(variant), None
    if callable(changed.get("controller")):
        controller = changed.pop("controller")
    own = {name: changed.pop(name) for name in [*changed] if name in WORDS or having(name)}
    for name, value in (*changed.items(), *own.items()):
        before = getattr(how, name) if name in changed else getattr(how.words, name, None)
        if isinstance(before, tuple):
            table = changed if name in changed else own
            table[name] = (*before, *((value,) if isinstance(value, str) else value))
    given = SimulateSettings.given("a batch", how, {**changed, **own})
    return given, controller


def plain(variant: Mapping[str, Any]) -> dict[str, Any]:
    """Return a variant as a table shows it and JSON holds it."""
    return {name: _plain(value) for name, value in variant.items()}


def _plain(value: Any) -> Any:
    if callable(value):
        return getattr(value, "__name__", type(value).__name__)
    if isinstance(value, tuple | list):
        return " ".join(map(str, value)) or NOTHING
    return NOTHING if value is None else value


def name_of(index: int, count: int, shown: Mapping[str, Any]) -> str:
    """Return the name of a simulation: its number, and what it has of its own.

    Example:
        >>> name_of(7, 20, {"ground": "slope:5", "seed": 3})
        '07-slope-5-seed-3'
    """
    words = []
    for option, value in shown.items():
        if value == NOTHING:
            words.append(f"no-{option}")
        else:  # a word speaks for itself; a number does not
            alone = isinstance(value, str) and value[:1].isalpha()
            words.append(value if alone else f"{option}-{value}")
    slug = re.sub(r"[^A-Za-z0-9.-]+", "-", "-".join(words))[:60].strip("-.")
    return f"{index:0{len(str(count - 1))}d}" + (f"-{slug}" if slug else "")

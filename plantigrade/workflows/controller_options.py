"""Options of a simulation that belong to one controller or a few.

Each class is what the command line offers for the controllers that have it. Whatever is no word
of :class:`WalkOptions` is a setting of the controller by the same name; all other settings are
reached by ``--set`` and by keywords. Nothing here loads NumPy.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Annotated, Any

import tyro

from plantigrade.bounds import Bounded
from plantigrade.options import Flag, Number, OptionalWord, optional


@dataclass(frozen=True, kw_only=True)
class AnyOptions:
    """The option by which all settings of a controller are reached."""

    set: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, optional("NAME=VALUE")] = ()
    """Setting of the controller, such as swing.clearance=0.05; repeatable."""


@dataclass(frozen=True, kw_only=True)
class SpringOptions(Bounded):
    """Options of controllers that hold joints with springs."""

    ranges = {"stiffness": (0, 100, "times what is usual")}

    stiffness: Number = None
    """posture, stable-pd: joint stiffness; 1 is four times the joint's strength per radian."""


@dataclass(frozen=True, kw_only=True)
class StepOptions:
    """Options of balance."""

    stepping: Flag = False
    """balance: take a step when balance in place is lost."""


@dataclass(frozen=True, kw_only=True)
class WalkOptions(Bounded):
    """Options of the walk of an inverted pendulum."""

    ranges = {"tick": (1e-3, 0.02, "s")}

    speed: Annotated[str | None, optional("M/S[,M/S@S,…]")] = None
    """pendulum: walking speed, with changes: 1.2,0.8@5,0@10; 0 stands."""
    path: Annotated[str | None, optional("PATH")] = None
    """pendulum: straight, bearing:DEG[,DEG@S,…] or points:X,Y/X,Y[/…]."""
    stoop: Annotated[str | None, optional("CM[,CM@S,…]")] = None
    """pendulum: by how much to lower the head [cm], with changes: 0,25@3,0@6."""
    then: Annotated[tuple[str, ...], tyro.conf.UseAppendAction, optional("FILE|RUN[@S]")] = ()
    """pendulum: walk of a recording or run to switch to at a time; repeatable."""
    upper_body: Annotated[
        tuple[str, ...], tyro.conf.UseAppendAction, optional("FILE|RUN|NAME=DEG,…|recorded[@S]")
    ] = ()
    """pendulum: motion of spine, neck and arms from a time on; repeatable."""
    law: OptionalWord = None
    """pendulum: landing law of the swing foot; divergent by default."""
    tick: Number = None
    """pendulum: time for which a command holds [s]; 0.005 by default."""


CLASSES: Mapping[str, type] = {
    "posture": SpringOptions,
    "stable-pd": SpringOptions,
    "balance": StepOptions,
    "pendulum": WalkOptions,
}
"""Name of a controller → the class of its own options."""
OPTIONS: Mapping[str, Any] = {f.name: f.default for kind in CLASSES.values() for f in fields(kind)}
"""Name of every option of a controller → its default."""
WORDS = ("speed", "path", "stoop", "then", "upper_body")
"""Words that command a walk; all other options are settings of the controller."""


def given(options: Any) -> dict[str, Any]:
    """Return the options of controllers that are not at their defaults."""
    return {
        name: value
        for name, default in OPTIONS.items()
        if (value := getattr(options, name)) != default
    }


def users(name: str) -> tuple[str, ...]:
    """Return the controllers that have an option of their own by this name."""
    return tuple(word for word, kind in CLASSES.items() if name in {f.name for f in fields(kind)})

"""Walkers: a gait and the controller that walks it, by name or object, policy or file."""

import importlib
import importlib.util
import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from experiments.guest import Guest
from plantigrade.arrays import Array, Float
from plantigrade.control.choices import CONTROLLERS, Situation, controller_named
from plantigrade.control.pendulum import walk_of
from plantigrade.errors import ParameterError, PlantigradeError
from plantigrade.learn.controller import PolicyController, load_controller
from plantigrade.learn.policy import shipped
from plantigrade.options import LEARNED, assignments, is_policy, shown
from plantigrade.record import Record
from plantigrade.world import AnyController, Controller, controller_from

Make = Callable[[Record], AnyController]
"""Factory of a controller for a walk, called for every simulation.

A factory whose controller needs its own person, such as a policy, has that walk as ``record``.
"""


@dataclass(frozen=True, eq=False)
class Walker:
    """A gait and the factory of the controller that walks it.

    Attributes:
        record: The gait with its person: one closed stride, or a motion that ends
            (:func:`~plantigrade.control.pendulum.reference.walk_of`).
        make: Factory of the controller.
        name: Name of the controller.
    """

    record: Record
    make: Make
    name: str = "controller"

    def controller(self) -> Controller:
        """Return a new controller for the gait."""
        return controller_from(self.make(self.record))

    @property
    def period(self) -> float:
        """Duration of a stride, or of a motion that ends [s]."""
        return self.record.motion.duration

    @property
    def way(self) -> Float[Array, " 2"]:
        """Displacement over the ground in a period [m]."""
        place = self.record.motion.qpos[:, :2]
        return np.asarray(place[-1] - place[0])

    @property
    def speed(self) -> float:
        """Speed of the gait [m/s]."""
        return float(np.linalg.norm(self.way)) / self.period


def walker(controller: str | Make, record: Record | None = None, name: str = "") -> Walker:
    """Return a walker with the given walk, or with that of a controller which has its own.

    Args:
        controller: Its name (:func:`make_named`), or a function or class that is called with the
            walk and returns a controller ``controller(state) -> command``.
        record: The walk: fitted, reproduced or synthesised; of a walk its most regular stride.
            Not needed if the controller has its own.
        name: Name of the walker; that of the controller if empty.

    Raises:
        ParameterError: If there is no such controller.
    """
    make = make_named(controller) if isinstance(controller, str) else controller
    if not callable(make):
        raise ParameterError(f"a controller is a name or a factory, not {shown(make)}")
    own = controller if isinstance(controller, str) else getattr(make, "__name__", "controller")
    walk = getattr(make, "record", None)
    if walk is None:
        if record is None:
            raise ParameterError(f"{own} needs a walk: give record=")
        walk = walk_of(record)
    return Walker(walk, make, name or str(own))


def walks_as(controller: str | Make, record: Record) -> Walker:
    """Return a walker with a given walk.

    Raises:
        ParameterError: If there is no such controller, or it has a person of its own.
    """
    found = walker(controller, record)
    if found.record.human is not record.human:
        raise ParameterError(f"{found.name} defines its own person, and cannot walk as another")
    return found


def guest_named(word: str) -> Callable[[], Guest] | None:
    """Return the class of a guest with a body of its own, ``FILE.py:NAME``; None for others.

    Raises:
        ParameterError: If the module cannot be loaded.
    """
    name, colon, what = word.rpartition(":")
    if not colon or not what or name in CONTROLLERS or is_policy(name) or is_policy(word):
        return None
    if not name.endswith(".py") and "=" in what:
        return None
    found = getattr(_module(name, word), what, None)
    return found if isinstance(found, type) and issubclass(found, Guest) else None


def make_named(word: str) -> Make:
    """Return the factory of a controller by its name.

    A name of :data:`~plantigrade.control.choices.CONTROLLERS`, also with settings of its own,
    ``NAME:SETTING=VALUE;…``; ``pendulum:LAW`` with a landing law; ``learned`` or
    ``learned:FEET``, a policy of the package, and ``FILE.npz`` or ``FILE.onnx``, another policy; or
    one from outside this package, ``FILE.py:NAME`` or ``package.module:NAME``: a function or
    class that is called with the walk (:class:`~plantigrade.record.Record`) and returns a
    controller.

    Raises:
        ParameterError: If there is none.
        FileError: If a policy cannot be read.
    """
    name, colon, what = word.rpartition(":")
    if name == LEARNED or is_policy(word):
        return _Learned(word)
    if name == "pendulum" and "=" not in what:
        what = f"law={what}"
    if name in CONTROLLERS:
        values = assignments(what.split(";"))
        CONTROLLERS[name].with_settings(values, name)
        return _Named(name, tuple(values.items()))
    if word in CONTROLLERS:
        return _Named(word)
    if not colon or not name or not what:
        raise ParameterError(
            f"no controller {word!r}; there are {', '.join(CONTROLLERS)}, pendulum:LAW, learned, "
            "FILE.npz, FILE.onnx, and your own as FILE.py:NAME or package.module:NAME"
        )
    found = getattr(_module(name, word), what, None)
    if not callable(found):
        raise ParameterError(f"{word}: {name} has no function or class {what!r}")
    if guest_named(word) is not None:
        raise ParameterError(
            f"{word} brings a body of its own, which only push-any-controller and the maps of "
            "push-map take"
        )
    return _Outside(word, name, what)


@dataclass(frozen=True)
class _Learned:
    """Factory of a trained policy, which walks as its own person."""

    word: str

    def __post_init__(self):
        """Refuse a policy that does not exist."""
        self(None)

    @property
    def record(self) -> Record:
        """The walk of the policy."""
        return self(None).record

    def __call__(self, record: Record | None) -> PolicyController:
        name, _, feet = self.word.partition(":")
        policy = shipped(feet or "multi-segment") if name == LEARNED else self.word
        return load_controller(policy)


@dataclass(frozen=True)
class _Named:
    """Factory of a controller of the package, with changed settings."""

    name: str
    values: tuple[tuple[str, str], ...] = ()

    def __call__(self, record: Record) -> Controller:
        at = Situation(
            human=record.human, ground=record.ground, motion=record.motion, record=record
        )
        return controller_named(self.name, at, dict(self.values))


@dataclass(frozen=True)
class _Outside:
    """Factory of an external controller, in any process."""

    word: str
    module: str
    name: str

    def __call__(self, record: Record) -> Controller:
        make = getattr(_module(self.module, self.word), self.name)
        try:
            made: Any = make(record)
        except PlantigradeError:
            raise
        except (Exception, SystemExit) as error:
            raise _refused(self.word, error) from error
        if not callable(made):
            raise ParameterError(f"{self.word} returned no controller, but {shown(made)}")
        return controller_from(made)


def _module(name: str, word: str) -> Any:
    """Return a module by its name or file."""
    try:
        if not name.endswith(".py"):
            return importlib.import_module(name)
        path = Path(name).resolve()
        if not path.is_file():
            raise ParameterError(f"controller {word}: there is no file {shown(name)}")
        own = f"plantigrade_outside_{re.sub(r'[^0-9a-zA-Z]', '_', str(path))}"
        if own in sys.modules:
            return sys.modules[own]
        spec = importlib.util.spec_from_file_location(own, path)
        if spec is None or spec.loader is None:
            raise ImportError(f"no module at {path}")
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        sys.modules[own] = module
        return module
    except PlantigradeError:
        raise
    except (Exception, SystemExit) as error:  # external code may raise anything
        raise _refused(word, error) from error


def _refused(word: str, error: BaseException) -> ParameterError:
    """Return the error for external code that failed."""
    return ParameterError(f"controller {word}: {f'{error!r}'[:200]}")

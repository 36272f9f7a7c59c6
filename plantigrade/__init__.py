"""Physics-based human motion with multi-segment feet.

The names below are the public face; each is loaded when it is first used, so that ``import
plantigrade`` costs nothing::

    import plantigrade as pg

    run = pg.fit("walk.c3d")
    run.record.motion["knee_angle_r"]  # [rad]
    run.report()  # runs/fit-walk/report.html

``synthesize``, ``reproduce``, ``report`` and ``vault`` are functions and also rooms of this
package: whichever is met first, the name is the room, and calling the room calls the function.
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plantigrade.analyze.check import check
    from plantigrade.contact.ground import Ground
    from plantigrade.contact.plan import ContactPlan
    from plantigrade.datasets.get import get_data
    from plantigrade.errors import PlantigradeError
    from plantigrade.io import read
    from plantigrade.models.human import Human
    from plantigrade.models.person import Person
    from plantigrade.motion.motion import Motion
    from plantigrade.motion.recording import Recording
    from plantigrade.record.record import Record
    from plantigrade.record.run import Run, load_run
    from plantigrade.workflows.compare import compare
    from plantigrade.workflows.fit import fit
    from plantigrade.workflows.fit_many import fit_many
    from plantigrade.workflows.motions import synthesize
    from plantigrade.workflows.reproduce import reproduce
    from plantigrade.workflows.reproduce_many import reproduce_many
    from plantigrade.workflows.save import report
    from plantigrade.workflows.simulate import simulate
    from plantigrade.workflows.simulate_many import simulate_many
    from plantigrade.workflows.synthesize_many import synthesize_many
    from plantigrade.workflows.vault import vault

__version__ = "0.1.0"

__all__ = [
    "ContactPlan",
    "Ground",
    "Human",
    "Motion",
    "Person",
    "PlantigradeError",
    "Record",
    "Recording",
    "Run",
    "__version__",
    "check",
    "compare",
    "fit",
    "fit_many",
    "get_data",
    "load_run",
    "read",
    "report",
    "reproduce",
    "reproduce_many",
    "simulate",
    "simulate_many",
    "synthesize",
    "synthesize_many",
    "vault",
]

_HOMES = {
    "ContactPlan": "contact.plan",
    "Ground": "contact.ground",
    "Human": "models.human",
    "Motion": "motion.motion",
    "Person": "models.person",
    "PlantigradeError": "errors",
    "Record": "record.record",
    "Recording": "motion.recording",
    "Run": "record.run",
    "check": "analyze.check",
    "compare": "workflows.compare",
    "fit": "workflows.fit",
    "fit_many": "workflows.fit_many",
    "get_data": "datasets.get",
    "load_run": "record.run",
    "read": "io",
    "report": "workflows.save",
    "reproduce": "workflows.reproduce",
    "reproduce_many": "workflows.reproduce_many",
    "simulate": "workflows.simulate",
    "simulate_many": "workflows.simulate_many",
    "synthesize": "workflows.motions",
    "synthesize_many": "workflows.synthesize_many",
    "vault": "workflows.vault",
}
"""Public name → the module of this package it lives in."""
_ROOMS = ("report", "reproduce", "synthesize", "vault")


def _load(name: str) -> Any:
    """Return what lives under a public name, loaded."""
    return getattr(import_module(f"{__name__}.{_HOMES[name]}"), name)


class _Room(ModuleType):
    """A room that bears the name of a function of the face: calling it calls the function."""

    def __call__(self, *args: Any, **options: Any) -> Any:
        return _load(self.__name__.rpartition(".")[2])(*args, **options)

    @property
    def __signature__(self) -> Any:
        import inspect

        return inspect.signature(_load(self.__name__.rpartition(".")[2]))

    def __reduce__(self) -> tuple[Any, tuple[str]]:
        return import_module, (self.__name__,)


class _Face(ModuleType):
    """This module: it makes a room callable when the room is imported, whoever imports it."""

    def __setattr__(self, name: str, value: Any) -> None:
        if name in _ROOMS and type(value) is ModuleType:
            value.__class__ = _Room
        super().__setattr__(name, value)


sys.modules[__name__].__class__ = _Face


def __getattr__(name: str) -> Any:
    """Return a public name, loaded when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return import_module(f"{__name__}.{name}") if name in _ROOMS else _load(name)


def __dir__() -> list[str]:
    """Return every name, loaded or not."""
    return sorted({*globals(), *__all__})

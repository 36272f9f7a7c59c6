"""Physics-based human motion with multi-segment feet.

The names below are the public face; each is loaded when it is first used, so that ``import
plantigrade`` costs nothing::

    import plantigrade as pg

    run = pg.fit("walk.c3d")
    run.record.motion["knee_angle_r"]  # [rad]
    run.report()  # runs/fit-walk/report.html
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from plantigrade.analyze.check import check
    from plantigrade.contact.ground import Ground
    from plantigrade.contact.plan import ContactPlan
    from plantigrade.datasets.get import get_data
    from plantigrade.errors import PlantigradeError
    from plantigrade.exchange.formats import export
    from plantigrade.io import read
    from plantigrade.models.human import Human
    from plantigrade.models.person import Person
    from plantigrade.motion.motion import Motion
    from plantigrade.motion.recording import Recording
    from plantigrade.record.record import Record
    from plantigrade.record.run import Run, load_run
    from plantigrade.robots.retargeting import retarget
    from plantigrade.workflows.compare import compare
    from plantigrade.workflows.fit import fit
    from plantigrade.workflows.fit_many import fit_many
    from plantigrade.workflows.motions import synthesize
    from plantigrade.workflows.notebook import live_session, view
    from plantigrade.workflows.reproduce import reproduce
    from plantigrade.workflows.reproduce_many import reproduce_many
    from plantigrade.workflows.save import report
    from plantigrade.workflows.simulate import simulate
    from plantigrade.workflows.simulate_many import simulate_many
    from plantigrade.workflows.synthesize_many import synthesize_many
    from plantigrade.workflows.vault import vault

__version__ = "0.2.0"

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
    "export",
    "fit",
    "fit_many",
    "get_data",
    "live_session",
    "load_run",
    "read",
    "report",
    "reproduce",
    "reproduce_many",
    "retarget",
    "simulate",
    "simulate_many",
    "synthesize",
    "synthesize_many",
    "vault",
    "view",
]


def __getattr__(name: str) -> Any:
    """Return a public name, loaded when it is first used."""
    return import_module(f"{__name__}.lazy").lazy(__name__)(name)


def __dir__() -> list[str]:
    return sorted(__all__)

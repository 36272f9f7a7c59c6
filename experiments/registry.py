"""The experiments by name, and what each of them takes."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from experiments.table import ResultTable


@dataclass(frozen=True)
class Experiment:
    """A module of this folder whose function ``run`` returns a table.

    Every ``run`` takes ``quick``, for a short form of it, and ``say``, called with a line for all
    that is done; beside these it may take ``data`` (the folder of recordings), ``out`` (a folder
    to keep results in and to write to), ``parts`` (names of those to be done, the usual ones if
    empty), ``overwrite`` (do anew what is in ``out``), ``jobs`` (how many runs at once) and
    ``controllers`` (words of those that are to walk, the usual one if empty).

    Attributes:
        name: Of the module, with hyphens.
        needs: What it cannot do without.
        takes: What else it makes use of.
    """

    name: str
    needs: tuple[str, ...] = ()
    takes: tuple[str, ...] = ()

    @property
    def options(self) -> tuple[str, ...]:
        """What it needs and what it takes."""
        return (*self.needs, *self.takes)

    def run(self, **options: Any) -> "ResultTable":
        """Import the module and call its ``run``."""
        import importlib

        name = f"experiments.{self.name.replace('-', '_')}"
        return importlib.import_module(name).run(**options)


MEASURED = ("out", "parts", "overwrite", "jobs")
"""What experiments of many kept results take."""
EXPERIMENTS = {
    e.name: e
    for e in (
        Experiment("ankle-torque", takes=MEASURED),
        Experiment("feet-while-walking", takes=("data", "controllers", *MEASURED)),
        Experiment("fit-accuracy", needs=("data",)),
        Experiment("foot-motions", takes=("data", *MEASURED)),
        Experiment("foot-pose", needs=("data",)),
        Experiment("foot-segments", needs=("data",)),
        Experiment("gain-curves", takes=MEASURED),
        Experiment("gait-table", needs=("data",)),
        Experiment("gait-ablations", needs=("data",)),
        Experiment("gait-forces", needs=("data",)),
        Experiment("ground-forces", needs=("data",)),
        Experiment("learned-feet", takes=("controllers", *MEASURED)),
        Experiment("learned-walk", takes=MEASURED),
        Experiment("moving-slope", takes=MEASURED),
        Experiment("push-any-controller", takes=("data", "controllers", *MEASURED)),
        Experiment("push-map", takes=("data", "controllers", *MEASURED)),
        Experiment("push-table", takes=MEASURED),
        Experiment("pushed-walk", takes=MEASURED),
        Experiment("random-worlds", takes=("out", "overwrite")),
        Experiment("replay", takes=("data", *MEASURED)),
        Experiment("robustness", takes=MEASURED),
        Experiment("rough-walk", takes=MEASURED),
        Experiment("sensitivity", takes=("data", "controllers", *MEASURED)),
        Experiment("spline-table", takes=("data", "out")),
        Experiment("synthesis-bench", takes=("out", "parts", "overwrite")),
        Experiment("synthesis-fidelity", takes=("out", "parts", "overwrite")),
        Experiment("synthesis-tracking", needs=("data",)),
        Experiment("uneven-ground", takes=MEASURED),
        Experiment("vault-table", takes=("out", "overwrite")),
        Experiment("walk-battery", takes=("data", "controllers", *MEASURED)),
    )
}
"""Every experiment by name."""


def taking(*options: str) -> list[str]:
    """Return the names of the experiments that take all of these options."""
    return [name for name, e in EXPERIMENTS.items() if set(options) <= set(e.options)]

"""The experiments by name, and the options that each of them takes."""

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from experiments.table import ResultTable


@dataclass(frozen=True)
class Experiment:
    """A function of this folder that measures something and returns a table.

    Every function takes ``quick`` (whether to run the short form) and ``say`` (called with a line
    about each result). Further options are ``data`` (folder of recordings), ``out`` (folder for
    results), ``parts`` (names of parts; the default ones if empty), ``overwrite`` (discard the
    results in ``out``), ``jobs`` (number of parallel runs) and ``controllers`` (names of
    controllers; the default one if empty).

    Attributes:
        name: Name of the experiment.
        place: Its module and the object in it whose ``run`` is called; the module of that name and
            its function ``run`` if empty.
        needs: Options that must be given.
        takes: Other options that it uses.
    """

    name: str
    place: str = ""
    needs: tuple[str, ...] = ()
    takes: tuple[str, ...] = ()

    @property
    def options(self) -> tuple[str, ...]:
        """All options that it uses."""
        return (*self.needs, *self.takes)

    def function(self) -> "Callable[..., ResultTable]":
        """Import the module and return the function."""
        module, _, name = (self.place or self.name.replace("-", "_")).partition(":")
        found = importlib.import_module(f"experiments.{module}")
        return getattr(found, name).run if name else found.run


CACHED = ("out", "parts", "overwrite", "jobs")
"""Options of experiments with cached results."""
WALKING = ("data", "controllers", *CACHED)
"""Options of experiments on walking, for any controller."""
EXPERIMENTS = {
    e.name: e
    for e in (
        Experiment("ankle-torque", "learned_level:ANKLE", takes=CACHED),
        Experiment("feet-while-walking", takes=WALKING),
        Experiment("fit-accuracy", needs=("data",)),
        Experiment("foot-motions", takes=("data", *CACHED)),
        Experiment("foot-pose", needs=("data",)),
        Experiment("foot-segments", needs=("data",)),
        Experiment("gain-curves", "learned_level:GAINS", takes=CACHED),
        Experiment("gait-table", needs=("data",)),
        Experiment("gait-ablations", needs=("data",)),
        Experiment("gait-forces", needs=("data",)),
        Experiment("ground-forces", needs=("data",)),
        Experiment("human-likeness", takes=WALKING),
        Experiment("learned-feet", takes=("controllers", *CACHED)),
        Experiment("learned-walk", "learned_level:WALK", takes=CACHED),
        Experiment("changed-walks", "changed_walks:EXPERIMENT", takes=CACHED),
        Experiment("moving-slope", "standing_grounds:MOVING", takes=CACHED),
        Experiment("push-any-controller", takes=WALKING),
        Experiment("push-map", takes=WALKING),
        Experiment("push-table", "push_table:EXPERIMENT", takes=CACHED),
        Experiment("pushed-walk", "learned_disturbed:PUSHED", takes=CACHED),
        Experiment("random-worlds", takes=("out", "overwrite")),
        Experiment("recording-faults", needs=("data",), takes=CACHED),
        Experiment("replay", takes=("data", *CACHED)),
        Experiment("robustness", "robustness:EXPERIMENT", takes=CACHED),
        Experiment("rough-walk", "learned_disturbed:ROUGH", takes=CACHED),
        Experiment("running-table", needs=("data",)),
        Experiment("sensitivity", takes=WALKING),
        Experiment("spline-table", takes=("data", "out")),
        Experiment("synthesis-bench", "synthesis_bench:EXPERIMENT", takes=CACHED),
        Experiment("synthesis-fidelity", "synthesis_fidelity:EXPERIMENT", takes=CACHED),
        Experiment("synthesis-tracking", needs=("data",)),
        Experiment("uneven-ground", "standing_grounds:UNEVEN", takes=CACHED),
        Experiment("vault-table", takes=("out", "overwrite")),
        Experiment("video", needs=("data",)),
        Experiment("walk-battery", takes=WALKING),
        Experiment("walk-norms", "walk_norms:EXPERIMENT", takes=CACHED),
        Experiment("walk-starts", takes=WALKING),
    )
}
"""Every experiment by name."""


def taking(*options: str) -> list[str]:
    """Return the names of the experiments that take all of these options."""
    return [name for name, e in EXPERIMENTS.items() if set(options) <= set(e.options)]

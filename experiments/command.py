"""The options of ``plantigrade experiment``: one experiment, all of them, or a comparison."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from experiments.registry import EXPERIMENTS, Experiment, taking
from plantigrade.bounds import Bounded
from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError, RunExists
from plantigrade.options import Flag, OptionalPath, optional

if TYPE_CHECKING:
    from experiments.table import ResultTable

OPTIONS = {
    "data": "--data",
    "out": "--out",
    "parts": "--part",
    "overwrite": "--overwrite",
    "jobs": "--jobs",
    "controllers": "--controller",
}
"""Option of an experiment → its name on the command line."""
COMMANDS = {
    "demo": ("demo",),  # with it fit and reproduce
    "synthesize": ("synthesize", "sit-to-stand"),
}
"""Commands whose figures are measured together with those of all experiments."""


def _listed(names: Iterable[str], word: str = "or") -> str:
    """Return names as a sentence lists them."""
    *first, last = names
    return f"{', '.join(first)} {word} {last}"


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions, Bounded):
    """Recompute a published table or figure, our numbers and the published ones."""

    ranges = {"jobs": (-1, 1024, "")}

    name: Annotated[
        tyro.conf.Positional[str | None],
        optional("[NAME]", f"Name of the experiment: {_listed(EXPERIMENTS)}."),
    ] = None
    """Name of the experiment."""
    all: Flag = False
    """Run every experiment, even if one fails, and write all figures to figures.json in --out."""
    quick: Flag = False
    """Run a short form with few recordings and motions; all experiments take eight minutes."""
    compare: Annotated[tuple[Path, Path] | None, optional("BEFORE.json AFTER.json")] = None
    """Run nothing; print the differences between two figures.json files."""
    data: OptionalPath = None
    """Folder of recordings; by default PLANTIGRADE_DATA, then ../shared/data."""
    out: Annotated[
        Path | None,
        optional(
            "PATH",
            "Output folder; by default runs/NAME, or runs/experiments with --all. "
            f"{_listed(taking('out', 'overwrite'), 'and')} reuse the results they find there, so "
            "an interrupted run continues.",
        ),
    ] = None
    """Folder for results, figures and pages."""
    parts: Annotated[
        tyro.conf.UseAppendAction[tuple[str, ...]],
        tyro.conf.arg(
            name="part",
            metavar="PART",
            help=f"Run only this part of {_listed(taking('parts'))}; an unknown part lists all.",
        ),
    ] = ()
    """Parts of an experiment that are run."""
    controllers: Annotated[
        tyro.conf.UseAppendAction[tuple[str, ...]],
        tyro.conf.arg(
            name="controller",
            metavar="NAME",
            help=f"Controller for {_listed(taking('controllers'))}: as for "
            "simulate, pendulum:LAW, or your own as FILE.py:NAME. The default is pendulum.",
        ),
    ] = ()
    """Controllers of an experiment on walking."""
    overwrite: Flag = False
    """Discard results already in --out and measure again."""

    jobs: Annotated[
        int | None,
        optional(
            "N", f"Number of parallel runs of {_listed(taking('jobs'))}; -1 for one per core."
        ),
    ] = None
    """Number of parallel runs."""

    def __post_init__(self):
        """Refuse impossible values before any work."""
        super().__post_init__()
        if self.jobs == 0:
            raise ParameterError("jobs must be 1, 2, … or -1 for one per core, not 0")

    def run(self) -> Outcome:
        """Run the command."""
        from plantigrade.commands.progress import Progress

        say = Progress(quiet=self.quiet).say
        if (self.name is not None) + self.all + (self.compare is not None) != 1:
            raise ParameterError(
                f"name one experiment, or give --all or --compare alone; "
                f"experiments are {', '.join(EXPERIMENTS)}"
            )
        if self.compare is not None:
            self._refuse_but((), "--compare")
            if self.quick:
                raise ParameterError("--quick has no effect with --compare")
            return self._compared(*self.compare)
        if self.all:
            self._refuse_but(("data", "out", "overwrite", "jobs"), "--all")
            return self._all(say)
        if self.name not in EXPERIMENTS:
            raise ParameterError(f"no experiment {self.name!r}; there are {', '.join(EXPERIMENTS)}")
        experiment = EXPERIMENTS[self.name]
        self._refuse_but(experiment.options, self.name)
        out = self.out or Path("runs") / self.name
        table = self._table(experiment, out, overwrite=self.overwrite, say=say)
        return Outcome(table.text(), table.metrics())

    def _refuse_but(self, allowed: tuple[str, ...], what: str) -> None:
        """Raise if an option is given that has no effect here."""
        for option, flag in OPTIONS.items():
            if getattr(self, option) and option not in allowed:
                raise ParameterError(f"{flag} has no effect with {what}")

    def _table(
        self, experiment: Experiment, out: Path, *, overwrite: bool, say: Callable[[str], None]
    ) -> "ResultTable":
        """Run an experiment with its options."""
        jobs = 1 if self.jobs is None else self.jobs
        values: dict[str, Any] = {
            "out": out,
            "parts": self.parts,
            "overwrite": overwrite,
            "jobs": jobs,
            "controllers": self.controllers,
        }
        if "data" in experiment.options:
            values["data"] = data_folder(self.data, needed="data" in experiment.needs)
        given = {option: values[option] for option in experiment.options}
        return experiment.function()(**given, quick=self.quick, say=say)

    def _all(self, say: Callable[[str], None]) -> Outcome:
        """Run every experiment and the commands, and write their figures."""
        from experiments.figures import FILE, figures_of, measure, measured_table

        folder = self.out or Path("runs") / "experiments"
        path = folder / FILE
        if path.exists() and not self.overwrite:
            raise RunExists(f"{path} exists; choose another --out, or add --overwrite")

        def figures(experiment: Experiment) -> dict[str, Any]:
            out = folder / experiment.name
            return figures_of(self._table(experiment, out, overwrite=True, say=say))

        runs = {name: partial(figures, experiment) for name, experiment in EXPERIMENTS.items()}
        for name, words in COMMANDS.items():
            runs[name] = partial(command_figures, words, folder / name)
        found = measure(runs, path, quick=self.quick, say=say)
        every = found["experiments"]
        failed = [f"{name}: {e['status']}" for name, e in every.items() if e["status"] != "ok"]
        metrics = {
            "status": "; ".join(failed) or "ok",
            "experiments": len(every),
            "experiments_failed": len(failed),
            "figures": sum(len(e["figures"]) for e in every.values()),
            "goals": sum(len(e["goals"]) for e in every.values()),
            "goals_met": sum(sum(e["goals"].values()) for e in every.values()),
            "time_s": found["time_s"],
        }
        return Outcome(f"{measured_table(found)}\n\nThe figures are in {path}.", metrics)

    def _compared(self, before: Path, after: Path) -> Outcome:
        """Compare two files of figures."""
        from experiments.figures import compare, read_figures

        found = compare(read_figures(before), read_figures(after))
        return Outcome(found.text(), found.metrics())


def command_figures(words: tuple[str, ...], out: Path) -> dict[str, Any]:
    """Run a command and return its status and those of its metrics that are numbers."""
    from plantigrade.commands.main import parse

    where = ("--out", str(out), "--overwrite", "--quiet")
    metrics = parse(words[0], (*words[1:], *where)).run().metrics
    figures = {k: v for k, v in metrics.items() if v is None or isinstance(v, int | float)}
    figures |= {f"{name}_time_s": spent for name, spent in metrics.get("seconds", {}).items()}
    return {"status": metrics["status"], "figures": figures, "goals": {}}


def data_folder(given: Path | None, *, needed: bool) -> Path | None:
    """Return the folder of recordings; None if it is not there and nobody needs or named it.

    Raises:
        ParameterError: If it is not there.
    """
    import os

    folder = given or Path(os.environ.get("PLANTIGRADE_DATA", "../shared/data"))
    if folder.is_dir():
        return folder
    if given is None and not needed:
        return None
    raise ParameterError(
        f"no folder of recordings at {folder}; set --data or PLANTIGRADE_DATA, or download one: "
        f"plantigrade data get --all"
    )

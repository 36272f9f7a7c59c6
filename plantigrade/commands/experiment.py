"""Compute a table or figure: ours beside the published numbers."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError
from plantigrade.options import Flag, OptionalPath

EXPERIMENTS = {
    "fit-accuracy": "fit_accuracy",
    "foot-segments": "foot_segments",
    "gait-table": "gait_table",
    "gait-ablations": "gait_ablations",
    "gait-forces": "gait_forces",
    "spline-table": "spline_table",
    "synthesis-bench": "synthesis_bench",
    "synthesis-fidelity": "synthesis_fidelity",
    "synthesis-tracking": "synthesis_tracking",
}
DRAWING = ("spline-table",)  # experiments that draw figures
LONG = ("synthesis-bench", "synthesis-fidelity")  # without recordings; in parts that are kept


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions):
    """Compute a table or figure: ours beside the published numbers."""

    name: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="NAME")]
    """Name of the experiment: fit-accuracy, foot-segments, gait-table, gait-ablations,
    gait-forces, spline-table, synthesis-bench, synthesis-fidelity or synthesis-tracking."""
    data: OptionalPath = None
    """Folder of recordings; PLANTIGRADE_DATA or ../shared/data if absent."""
    out: OptionalPath = None
    """Folder for the figures (spline-table), or for results and page (synthesis-…; runs/NAME if
    absent): what is there is not measured again, so that a stopped run goes on."""
    part: Annotated[tyro.conf.UseAppendAction[tuple[str, ...]], tyro.conf.arg(metavar="PART")] = ()
    """This part of synthesis-… only; may be given several times."""
    quick: Flag = False
    """Of synthesis-…: one motion of each kind only."""
    overwrite: Flag = False
    """Of synthesis-…: measure anew what is there."""

    def run(self) -> Outcome:
        """Do it."""
        import importlib

        from plantigrade.commands.progress import Progress

        if self.name not in EXPERIMENTS:
            raise ParameterError(f"no experiment {self.name!r}; there are {', '.join(EXPERIMENTS)}")
        module = importlib.import_module(f"plantigrade.experiments.{EXPERIMENTS[self.name]}")
        say = Progress(quiet=self.quiet).say
        if self.name in LONG:
            return self._in_parts(module, say)
        for option in ("part", "quick", "overwrite"):
            if getattr(self, option):
                raise ParameterError(f"--{option} is for {', '.join(LONG)}")
        if self.name in DRAWING:
            table = module.run(optional_data_folder(self.data), out=self.out, say=say)
        elif self.out is not None:
            raise ParameterError(
                f"--out is for experiments that draw: {', '.join((*DRAWING, *LONG))}"
            )
        else:
            table = module.run(data_folder(self.data), say=say)
        return Outcome(table.text(), table.metrics())

    def _in_parts(self, module: Any, say: Callable[[str], None]) -> Outcome:
        """Do what is not done yet."""
        folder = self.out or Path("runs") / self.name
        if self.overwrite:
            (folder / module.FILE).unlink(missing_ok=True)
        table = module.run(parts=self.part, quick=self.quick, folder=folder, say=say)
        return Outcome(table.text(), table.metrics())


def optional_data_folder(given: Path | None) -> Path | None:
    """Return the folder of recordings for an experiment that can do without: None if absent.

    Raises:
        ParameterError: If one was named and is not there.
    """
    if given is not None:
        return data_folder(given)
    try:
        return data_folder(None)
    except ParameterError:
        return None


def data_folder(given: Path | None) -> Path:
    """Return the folder of recordings.

    Raises:
        ParameterError: If it is not there.
    """
    import os

    folder = given or Path(os.environ.get("PLANTIGRADE_DATA", "../shared/data"))
    if not folder.is_dir():
        raise ParameterError(
            f"no folder of recordings at {folder}; name one with --data or PLANTIGRADE_DATA"
        )
    return folder

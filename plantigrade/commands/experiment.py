"""Compute a table or figure: ours beside the published numbers."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from plantigrade.commands.options import OptionalPath, PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.errors import ParameterError

EXPERIMENTS = {
    "fit-accuracy": "fit_accuracy",
    "foot-segments": "foot_segments",
    "gait-table": "gait_table",
    "gait-ablations": "gait_ablations",
    "gait-forces": "gait_forces",
}


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions):
    """Compute a table or figure: ours beside the published numbers."""

    name: Annotated[tyro.conf.Positional[str], tyro.conf.arg(metavar="NAME")]
    """Name of the experiment: fit-accuracy, foot-segments, gait-table, gait-ablations
    or gait-forces."""
    data: OptionalPath = None
    """Folder of recordings; PLANTIGRADE_DATA or ../shared/data if absent."""

    def run(self) -> Outcome:
        """Do it."""
        import importlib

        from plantigrade.commands.progress import Progress

        if self.name not in EXPERIMENTS:
            raise ParameterError(f"no experiment {self.name!r}; there are {', '.join(EXPERIMENTS)}")
        folder = data_folder(self.data)
        module = importlib.import_module(f"plantigrade.experiments.{EXPERIMENTS[self.name]}")
        table = module.run(folder, say=Progress(quiet=self.quiet).say)
        return Outcome(table.text(), table.metrics())


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

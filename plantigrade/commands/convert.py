"""Convert a motion file, or a run, to another format."""

import os
import tempfile
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Literal

import tyro

from plantigrade.bounds import Bounded
from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress
from plantigrade.errors import FileError, RunExists
from plantigrade.options import Flag, OptionalPath, OptionalWord, optional

View = Literal["side", "left", "front", "back", "quarter"]


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions, Bounded):
    """Convert a motion file, or a run, to another format.

    Data that the target format cannot hold is left out with a warning; force plates are then
    written to NAME_grf.mot. A run folder becomes a file for another program: .csv, .bvh, .glb,
    .mp4, .gif, .c3d, .trc, .mot, .osim, or BIDS (…_motion.tsv).
    """

    activity = "a recording"
    ranges = {"rate": (1, 10_000, "Hz"), "height_px": (120, 2160, "pixels")}

    source: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="IN")]
    """File to read, or run folder."""
    target: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="OUT")]
    """File to write; the extension selects the format."""
    skeleton: OptionalPath = None
    """Skeleton (.asf) of an AMC file, if it is not in the same folder; or body model of SMPL."""
    rate: Annotated[float | None, optional("HZ")] = None
    """Frame rate of an AMC or SMPL file without one, or that a run is written at [Hz]."""
    over: Annotated[Literal["time", "cycles", "mean"] | None, optional("{time,cycles,mean}")] = None
    """Rows of the .csv of a run: instants, or percents of each gait cycle or of the mean one."""
    estimated: Flag = False
    """Keep forces, moments and powers of a run that were estimated, not measured."""
    rig: OptionalWord = None
    """Bone names of a run's .bvh or .glb: plantigrade, mixamo, cmu, rokoko, unity, unreal or
    rigify."""
    marker_set: Annotated[str | None, optional("NAME|FILE.toml")] = None
    """Markers of a run's .c3d, .trc or .osim: plug-in-gait, oxford-foot-model, gait2392, rajagopal,
    or your own TOML file; by default those it was fitted to, else oxford-foot-model (.osim: none).
    """
    forces: Flag = False
    """Draw ground reactions in a run's .glb as arrows."""
    solids: Flag = False
    """Draw the solids that physics sees in a run's .glb, in place of the skin."""
    view: Annotated[View | None, optional("{side,left,front,back,quarter}")] = None
    """View of a run's film: right side, left side, front, back, or three-quarter front."""
    height_px: Annotated[int | None, optional("PIXELS")] = None
    """Height of a run's film [pixels]."""
    unit: Annotated[Literal["m", "cm", "mm"] | None, optional("{m,cm,mm}")] = None
    """Unit of length of a .bvh file, which does not state it: to read it, or to write a run's."""
    overwrite: Flag = False
    """Replace existing files."""

    def run(self) -> Outcome:
        """Write the target, whole or not at all.

        Raises:
            RunExists: If a file that would be written exists and is not to be replaced.
            FileError: If the source cannot be read, or the target's format cannot hold it.
        """
        from plantigrade.exchange import export
        from plantigrade.io import convert

        if not self.source.exists():
            problem = "there is no such file or run folder"
            raise FileError(self.source, problem, remedy="check the name and the folder")
        self._refuse(self.target)
        if self.target.exists() and self.target.samefile(self.source):
            # A format keeps less than what was read: the recording itself would be lost.
            raise RunExists(f"{self.target} is the input file; choose another output file")
        folder = self.target.parent
        if not folder.is_dir():
            raise FileError(self.target, f"there is no folder {folder}", remedy="create it first")
        plain = ("source", "target", "overwrite", "json", "quiet")
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        options = {k: v for k, v in given.items() if k not in plain and v not in (None, False)}
        written_by = export if self.source.is_dir() else convert
        try:
            # Inside the target's folder: renaming works inside one file system only.
            with tempfile.TemporaryDirectory(prefix=".plantigrade-", dir=folder) as part:
                written = Path(part) / self.target.name
                notes = written_by(self.source, written, **options)
                paths = sorted(Path(part).iterdir())  # the target and, maybe, its force plates
                for path in paths:
                    self._refuse(folder / path.name)
                    if (folder / path.name).is_dir():
                        raise RunExists(
                            f"{folder / path.name} is a folder; choose another file name"
                        )
                for path in paths:
                    os.replace(path, folder / path.name)
        except FileError as error:
            if error.path.parent.name.startswith(".plantigrade-"):  # name the file as the user did
                raise type(error)(
                    folder / error.path.name, error.problem, where=error.where, remedy=error.remedy
                ) from error
            raise
        progress = Progress(quiet=self.quiet)
        for note in notes:
            progress.warn(note)
        files = [folder / path.name for path in paths]
        return Outcome(
            text=f"wrote {' and '.join(map(str, files))}",
            metrics={
                "status": "ok",
                "command": "convert",
                "source_file": self.source,
                "target_files": files,
                "warnings": notes,
            },
        )

    def _refuse(self, path: Path) -> None:
        if path.exists() and not self.overwrite:
            raise RunExists(f"{path} exists; choose another file or add --overwrite")

"""Convert a motion file, or a run, to another format."""

import os
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Literal

import tyro

from plantigrade.bounds import Bounded
from plantigrade.commands.options import PrintOptions
from plantigrade.commands.outcome import Outcome
from plantigrade.commands.progress import Progress
from plantigrade.errors import FileError, ParameterError, RunExists
from plantigrade.options import LEARNED, Flag, OptionalPath, OptionalWord, optional

View = Literal["side", "left", "front", "back", "quarter"]


@dataclass(frozen=True, kw_only=True)
class Command(PrintOptions, Bounded):
    """Convert a motion file, or a run, to another format.

    Data that the target format cannot hold is left out with a warning; force plates are then
    written to NAME_grf.mot. A run folder becomes a file for another program: .csv, .bvh, .glb,
    .mp4, .gif, .c3d, .trc, .mot, .osim, or BIDS (…_motion.tsv). The gait cycles of several runs, or
    of a batch, become one .parquet, .nc or .zarr. A policy.npz, or
    learned for a bundled one, becomes an .onnx.
    """

    activity = "a recording"
    ranges = {"rate": (1, 10_000, "Hz"), "height_px": (120, 2160, "pixels")}

    paths: Annotated[tyro.conf.Positional[tuple[Path, ...]], optional("IN [IN ...] OUT")]
    """File to read, or run folder (several runs or a batch for one table), and the file to write,
    whose extension selects the format."""
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
        self._refuse_faulty()
        folder = self.target.parent
        try:
            # Inside the target's folder: renaming works inside one file system only.
            with tempfile.TemporaryDirectory(prefix=".plantigrade-", dir=folder) as part:
                notes = self._write(Path(part) / self.target.name)
                paths = sorted(Path(part).iterdir())  # the target and, maybe, its force plates
                self._move(paths, Path(part))
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
                "source_files": self.inputs,
                "target_files": files,
                "warnings": notes,
            },
        )

    def _refuse_faulty(self) -> None:
        """Refuse inputs and a target that do not go together, before anything is read."""
        from plantigrade.learn.onnx_policy import is_onnx

        if len(self.paths) < 2:
            raise ParameterError("name a file or a run, and then the file to write")
        for source in self.inputs:
            if not source.exists() and not (str(source) == LEARNED and is_onnx(self.target)):
                problem = "there is no such file or run folder"
                raise FileError(source, problem, remedy="check the name and the folder")
        self._refuse(self.target)
        if self.target.exists() and any(map(self.target.samefile, self.inputs)):
            # A format keeps less than what was read: the recording itself would be lost.
            raise RunExists(f"{self.target} is the input file; choose another output file")
        recordings = self._recordings
        if recordings and len(self.inputs) > 1:
            problem = "is one of several files, and not a run folder"
            raise FileError(recordings[0], problem, remedy="convert recordings one by one")
        folder = self.target.parent
        if not folder.is_dir():
            raise FileError(self.target, f"there is no folder {folder}", remedy="create it first")

    def _write(self, path: Path) -> Sequence[str]:
        """Write the target to a path, and return what was left out and assumed."""
        from plantigrade.exchange import export
        from plantigrade.io import convert
        from plantigrade.learn.onnx_policy import convert_policy, is_onnx

        plain = ("paths", "overwrite", "json", "quiet")
        given = {field.name: getattr(self, field.name) for field in fields(self)}
        options = {k: v for k, v in given.items() if k not in plain and v not in (None, False)}
        if is_onnx(path):
            return convert_policy(self.paths[0], path, **options)
        if self._recordings:
            return convert(self._recordings[0], path, **options)
        return export(self.inputs, path, **options)

    def _move(self, paths: list[Path], part: Path) -> None:
        """Move what was written to its place; ``part`` takes a zarr that is replaced."""
        folder = self.target.parent
        for path in paths:
            self._refuse(folder / path.name)
            if (folder / path.name).is_dir() and not _is_zarr(folder / path.name):
                raise RunExists(f"{folder / path.name} is a folder; choose another file name")
        for path in paths:
            if (folder / path.name).is_dir():
                os.replace(folder / path.name, part / "replaced")
            os.replace(path, folder / path.name)

    @property
    def inputs(self) -> tuple[Path, ...]:
        """What is read."""
        return self.paths[:-1]

    @property
    def _recordings(self) -> list[Path]:
        """The inputs that are files."""
        return [source for source in self.inputs if not source.is_dir()]

    @property
    def target(self) -> Path:
        """What is written."""
        return self.paths[-1]

    def _refuse(self, path: Path) -> None:
        if path.exists() and not self.overwrite:
            raise RunExists(f"{path} exists; choose another file or add --overwrite")


def _is_zarr(folder: Path) -> bool:
    return any((folder / name).is_file() for name in (".zgroup", "zarr.json"))

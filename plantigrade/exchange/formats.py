"""The formats a run can be exported to: one writer per format, found by the file's extension."""

import importlib
import inspect
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from plantigrade.errors import FileError, ParameterError, UnsupportedFormat
from plantigrade.options import as_path, refuse_unknown
from plantigrade.record import Run
from plantigrade.signatures import keywords_of, takes


@dataclass(frozen=True)
class ExportFormat:
    """One format of exported runs."""

    name: str  #: Its name in messages
    suffixes: tuple[str, ...]  #: File extensions, lower case, with the dot
    #: ``module:function`` under :mod:`plantigrade.exchange`, called with the run, the path and the
    #: options; it returns notes, one sentence each
    writer: str
    many: bool = False  #: Whether it holds many runs: its writer takes a list of them

    @property
    def function(self) -> Callable[..., tuple[str, ...]]:
        """The writer."""
        module, function = self.writer.split(":")
        return getattr(importlib.import_module(f"plantigrade.exchange.{module}"), function)

    @property
    def options(self) -> tuple[str, ...]:
        """Names of its options."""
        return tuple(inspect.signature(self.function).parameters)[2:]


FORMATS = (
    ExportFormat("CSV", (".csv",), "tables:write_table"),
    ExportFormat("BVH", (".bvh",), "skeleton:write_skeleton"),
    ExportFormat("glTF", (".glb",), "animation:write_glb"),
    ExportFormat("film", (".mp4", ".gif"), "film:write_film"),
    ExportFormat("C3D", (".c3d",), "markers:write_markers_c3d"),
    ExportFormat("TRC", (".trc",), "markers:write_markers_trc"),
    ExportFormat("MOT/STO", (".mot", ".sto"), "markers:write_coordinates"),
    ExportFormat("OpenSim model", (".osim",), "opensim_model:write_model"),
    ExportFormat("BIDS motion", (".tsv",), "bids:write_motion"),
    ExportFormat("Parquet", (".parquet",), "trials:write_parquet", many=True),
    ExportFormat("xarray", (".nc", ".zarr"), "trials:write_dataset", many=True),
)
"""All formats."""


def format_of(path: Path) -> ExportFormat:
    """Return the format that the extension of a file names.

    Raises:
        UnsupportedFormat: If there is none; the message lists those there are.
    """
    for each in FORMATS:
        if path.suffix.lower() in each.suffixes:
            return each
    endings = ", ".join(suffix for each in FORMATS for suffix in each.suffixes)
    problem = f"a run cannot be exported with extension {path.suffix or 'none'!r}"
    raise UnsupportedFormat(path, problem, remedy=f"use one of {endings}")


@takes(more=[o for each in FORMATS for o in keywords_of(each.function, each.name)])
def export(
    run: Run | str | Path | Sequence[Run | str | Path], path: str | Path, **options: Any
) -> tuple[str, ...]:
    """Write a run as a file of another program; an existing file is replaced.

    Args:
        run: A run, or its folder; for Parquet, NetCDF and zarr also several, or folders of batches.
        path: The file; its extension chooses the format (:data:`FORMATS`).
        options: Those of all writers; each format has some of them.

    Returns:
        One sentence for each thing that the file lacks, or holds with a reservation.

    Raises:
        UnsupportedFormat: If no format has this extension.
        FileError: If there is no run in the folder, the run has not what the format stores, or the
            file cannot be written.
        ParameterError: If the format has no such option, or its value is not allowed.
    """
    path = as_path(path, "an exported file")
    kind = format_of(path)
    refuse_unknown(f"the export to {kind.name}", options, kind.options)
    if not path.parent.is_dir():
        problem = f"there is no folder {path.parent}"
        raise FileError(path, problem, remedy="create it first")
    several = [run] if isinstance(run, Run | str | Path) else list(run)
    several = [each if isinstance(each, Run) else as_path(each, "a run") for each in several]
    if kind.many:
        return kind.function(several, path, **options)
    if len(several) != 1:
        remedy = (
            f"use one of {', '.join(s for each in FORMATS if each.many for s in each.suffixes)}"
        )
        raise UnsupportedFormat(
            path, f"{kind.name} holds one run, not {len(several)}", remedy=remedy
        )
    run = several[0] if isinstance(several[0], Run) else Run.load(several[0])
    if run.record.motion.n_frames == 0:
        raise ParameterError("the motion has no frames: there is nothing to export")
    return kind.function(run, path, **options)

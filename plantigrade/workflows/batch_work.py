"""Work on one item of a batch: compute its run and keep the chosen part of it."""

import io
import json
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from plantigrade.analyze.norms import unit_of
from plantigrade.analyze.run_comparison import gait_of
from plantigrade.errors import ParameterError
from plantigrade.record import Run
from plantigrade.record.batch import Curve
from plantigrade.record.metrics import metrics_json
from plantigrade.side_names import without_side
from plantigrade.workflows.batch_items import Item
from plantigrade.workflows.save import save

Keep = Literal["pages", "runs", "figures"]
"""Files kept of each item in the folder of a batch: its run with report and viewer, its run, or
its line of the table alone."""
MAX_RETURNED_BYTES = 64 * 2**20
"""Largest result that a worker sends back; Ray and Dask copy it in memory several times."""
Work = Callable[[Any, Any], Run]
"""Makes the run of an item: from what it is, and from what its group starts with."""


class Kept(NamedTuple):
    """How results are kept; it travels to where they are computed."""

    folder: Path | None
    what: Keep
    collect: bool


class Made(NamedTuple):
    """The result of one item, as a worker returns it."""

    figures: dict[str, Any]
    status: str
    curves: dict[str, Curve]
    warnings: tuple[str, ...]
    run: Run | None = None
    archive: bytes = b""


def made(work: Work, kept: Kept, task: tuple[Item, Any]) -> Made:
    """Compute the run of an item and keep the chosen part of it."""
    item, start = task
    run = replace(work(item.what, start), name=item.name)
    metrics = run.metrics
    found = Made(figures_of(metrics), run.status, curves_of(run), tuple(metrics["warnings"]))
    if kept.folder is None:
        return found._replace(run=run)
    if kept.what == "figures":
        return found
    write = save if kept.what == "pages" else Run.save
    if not kept.collect:
        write(run, kept.folder / item.name, overwrite=True)
        return found
    with tempfile.TemporaryDirectory() as place:
        return found._replace(archive=_packed(write(run, Path(place) / item.name)))


def _packed(run: Run) -> bytes:
    """Return a run folder as one archive."""
    assert run.folder is not None
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        for path in sorted(run.folder.iterdir()):
            archive.write(path, path.name)
    size = stream.tell()
    if size > MAX_RETURNED_BYTES:
        raise ParameterError(
            f"the run has {size / 2**20:.0f} MB, and at most {MAX_RETURNED_BYTES / 2**20:.0f} MB "
            "can be sent back: use --keep figures, or a folder that all workers share"
        )
    return stream.getvalue()


def unpack(archive: bytes, folder: Path) -> None:
    """Write a run folder that was sent back, whole or not at all."""
    part = Path(tempfile.mkdtemp(prefix=f".{folder.name[:20]}-", suffix=".part", dir=folder.parent))
    try:
        with zipfile.ZipFile(io.BytesIO(archive)) as stream:
            stream.extractall(part)
        shutil.rmtree(folder, ignore_errors=True)
        part.chmod(0o755)
        part.rename(folder)
    finally:
        shutil.rmtree(part, ignore_errors=True)


_NOT_FIGURES = ("status", "format", "version", "kind", "title", "command", "files")


def figures_of(metrics: Mapping[str, Any]) -> dict[str, Any]:
    """Return the figures of a run, flat: numbers, words and booleans; how many warnings it has.

    Example:
        >>> figures_of({"status": "ok", "mass_kg": 70.0, "warnings": ["one"], "gaits": {}})
        {'mass_kg': 70.0, 'warnings_count': 1}
    """
    found: dict[str, Any] = {}
    for name, value in json.loads(metrics_json(metrics)).items():
        if name in _NOT_FIGURES:
            continue
        if name == "warnings":
            found["warnings_count"] = len(value)
        elif isinstance(value, str | int | float | bool):
            found[name] = value
    return found


def curves_of(run: Run) -> dict[str, Curve]:
    """Return the mean curves over the gait cycles of a run; none where it has no whole cycle."""
    try:
        gait = gait_of(run, run.name or run.kind)
    except ParameterError:
        return {}
    found = {}
    for name, rows in gait.curves.items():
        sd = rows.std(axis=0, ddof=1) if len(rows) > 1 else np.full(rows.shape[1], np.nan)
        unit = unit_of(without_side(name))
        found[name] = Curve(unit, len(rows), np.nanmean(rows, axis=0), sd)
    return found

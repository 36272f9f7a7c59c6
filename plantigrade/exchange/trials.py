"""The gait cycles of many runs as one table (Parquet), or as one xarray Dataset (NetCDF, zarr).

A row of the table is a percent of one cycle and one signal; in the Dataset each signal is an array
``(stride, percent)``, where a stride is one cycle of one side in one trial. Both hold what
:func:`~plantigrade.exchange.tables.side_curves` returns, with the signs it has.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from os.path import commonpath
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import FileError, ParameterError
from plantigrade.exchange.tables import EVENTS, UNITS, events_of, side_curves
from plantigrade.extras import require
from plantigrade.motion.cycles import PERCENT
from plantigrade.record import Run
from plantigrade.record.metrics import METRICS, read_metrics

NETCDF_FORMAT = "NETCDF3_64BIT"  # SciPy writes it; every reader of NetCDF knows it
_WORDS = ("subject", "trial", "side", "signal", "unit")


@dataclass(frozen=True)
class Strides:
    """All gait cycles of one side of one run."""

    subject: str  #: Name of the person in the recording; empty if it has none
    trial: str  #: Name of the run
    side: str  #: ``"r"`` or ``"l"``
    height: float  #: Stature [m]
    mass: float  #: Body mass [kg]
    #: ``start_s``, ``duration_s`` and events in percent, one value per cycle, NaN where not seen
    events: dict[str, Float[Array, " n_cycles"]]
    #: Signal → unit, and one row per cycle, NaN where unknown
    signals: dict[str, tuple[str, Float[Array, "n_cycles n_percent"]]]

    @property
    def count(self) -> int:
        """Number of cycles."""
        return len(self.events["start_s"])


def write_parquet(runs: Sequence[Run | Path], path: Path, estimated: bool = False):
    """Write the gait cycles of many runs as one table, one row per percent and signal.

    Args:
        runs: Runs, their folders, or folders of batches.
        estimated: Whether forces, moments and powers count where forces were estimated.
    """
    pa, pq = require("pyarrow", "tables"), require("pyarrow.parquet", "tables")
    word = pa.dictionary(pa.int32(), pa.string())
    schema = pa.schema([
        *((name, word) for name in _WORDS[:3]), ("cycle", pa.int32()), ("percent", pa.float32()),
        ("signal", word), ("unit", word), ("value", pa.float64()),
    ])  # fmt: skip
    notes: list[str] = []
    with pq.ParquetWriter(path, schema, compression="zstd") as writer:
        for strides in all_strides(runs, notes, estimated=estimated):
            names, each = list(strides.signals), strides.count * len(PERCENT)
            units = [unit for unit, _ in strides.signals.values()]
            values = np.stack([rows.ravel() for _, rows in strides.signals.values()])
            cycle = np.repeat(np.arange(1, strides.count + 1), len(PERCENT))
            columns: dict[str, Any] = {
                "subject": [strides.subject or None] * values.size,
                "trial": [strides.trial] * values.size,
                "side": [strides.side] * values.size,
                "cycle": np.tile(cycle, len(names)),
                "percent": np.tile(PERCENT, len(names) * strides.count),
                "signal": np.repeat(names, each),
                "unit": np.repeat(units, each),
                "value": pa.array(values.ravel(), from_pandas=True),  # NaN is no value
            }
            arrays = [pa.array(columns[field.name]).cast(field.type) for field in schema]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))
    return tuple(notes)


def write_dataset(runs: Sequence[Run | Path], path: Path, estimated: bool = False):
    """Write the gait cycles of many runs as NetCDF (``.nc``) or zarr.

    Arguments are those of :func:`write_parquet`.
    """
    if path.suffix.lower() == ".zarr":
        require("zarr", "tables")
    data, notes = trials_dataset(runs, estimated=estimated)
    if path.suffix.lower() == ".zarr":
        data.to_zarr(path, zarr_format=2, consolidated=True)
    else:
        data.to_netcdf(path, format=NETCDF_FORMAT, engine="scipy")
    return notes


def trials_dataset(
    runs: Sequence[Run | str | Path], *, estimated: bool = False
) -> tuple[Any, tuple[str, ...]]:
    """Return the gait cycles of many runs as an xarray Dataset, and notes.

    Its dimensions are ``stride`` and ``percent``. Subject, trial, side, cycle, stature, mass and
    the events are coordinates of the strides; every signal is a variable with its unit as attribute
    ``units``, NaN where a stride lacks it.

    Args:
        runs: Runs, their folders, or folders of batches.
        estimated: Whether forces, moments and powers count where forces were estimated.

    Raises:
        MissingExtra: If xarray is not installed.
        FileError: If a folder holds no run, or no run shows a complete gait cycle.
    """
    xarray = require("xarray", "tables")
    notes: list[str] = []
    found = list(all_strides(runs, notes, estimated=estimated))
    total = sum(each.count for each in found)
    arrays: dict[str, Any] = {}
    first = 0
    for each in found:
        for signal, (unit, rows) in each.signals.items():
            if signal not in arrays:
                empty = np.full((total, len(PERCENT)), np.nan)
                arrays[signal] = (("stride", "percent"), empty, {"units": unit})
            arrays[signal][1][first : first + each.count] = rows
        first += each.count

    def per_stride(values: list[Any], unit: str = "") -> tuple:
        return (
            "stride",
            np.repeat(values, [e.count for e in found]),
            {"units": unit} if unit else {},
        )

    coordinates: dict[str, Any] = {
        "percent": ("percent", PERCENT.astype(float), {"units": "%", "long_name": "gait cycle"}),
        "subject": per_stride([each.subject for each in found]),
        "trial": per_stride([each.trial for each in found]),
        "side": per_stride([each.side for each in found]),
        "cycle": ("stride", np.concatenate([np.arange(1, each.count + 1) for each in found])),
        "height": per_stride([each.height for each in found], "m"),
        "mass": per_stride([each.mass for each in found], "kg"),
    }
    for name, (stem, unit) in EVENTS.items():
        values = np.concatenate([each.events[name] for each in found])
        coordinates[stem] = ("stride", values, {"units": unit})
    return xarray.Dataset(arrays, coordinates), tuple(notes)


def all_strides(
    runs: Sequence[Run | str | Path], notes: list[str], *, estimated: bool
) -> Iterator[Strides]:
    """Yield the gait cycles of each side of each run, a run at a time.

    Args:
        runs: Runs, their folders, or folders of batches.
        notes: Gets a sentence for each run without a complete gait cycle.
        estimated: Whether estimated forces count.
    """
    there = [each for one in runs for each in _runs_in(one)]
    names = _names(there)
    some = False
    for each, trial in zip(there, names, strict=True):
        run = each if isinstance(each, Run) else Run.load(each)
        sides = [_strides(run, trial, side, estimated) for side in SIDES]
        sides = [strides for strides in sides if strides.count]
        if not sides:
            notes.append(f"{trial} shows no complete gait cycle and is left out")
        yield from sides
        some = some or bool(sides)
    if not some:
        problem = "no run shows a complete gait cycle"
        raise FileError(Path(names[0] if names else "."), problem, remedy="give runs of walking")


def _strides(run: Run, trial: str, side: str, estimated: bool) -> Strides:
    _, cycles, curves = side_curves(run, side, estimated=estimated)
    signals = {}
    for column, rows in curves.items():
        ending = next(each for each in UNITS if column.endswith(f"_{each}"))
        if len(rows) != len(cycles):  # forces on another clock show fewer cycles
            rows = np.full((len(cycles), len(PERCENT)), np.nan)
        signals[column.removesuffix(f"_{ending}")] = UNITS[ending], rows
    human, subject = run.record.human, str(run.metrics.get("subject_name", ""))
    return Strides(subject, trial, side, human.height, human.mass, events_of(cycles), signals)


def _runs_in(one: Run | str | Path) -> list[Run | Path]:
    """Return the run itself, or those of the folder of a batch."""
    if isinstance(one, Run):
        return [one]
    folder = Path(one)
    if not (folder / METRICS).is_file():
        return [folder]  # loading it says what is wrong
    metrics = read_metrics(folder)
    if metrics.get("kind") != "batch":
        return [folder]
    there = [folder / str(name) for name in metrics.get("folders", ())]
    there = [each for each in there if (each / METRICS).is_file()]
    if not there:
        remedy = "run it again with --keep runs, or read the mean curves of its curves.parquet"
        raise FileError(folder, "is a batch that kept no runs", remedy=remedy)
    return list(there)


def _names(runs: Sequence[Run | Path]) -> list[str]:
    """Return a name for each run: that of its folder, with those above it where names agree."""
    folders = [each.folder if isinstance(each, Run) else each for each in runs]
    names = [
        folder.name if folder is not None else run.name or run.kind  # type: ignore[union-attr]
        for run, folder in zip(runs, folders, strict=True)
    ]
    if len(set(names)) < len(names) and all(folder is not None for folder in folders):
        places = [folder.resolve() for folder in folders if folder is not None]
        if len(set(places)) < len(places):
            given = next(place for place in places if places.count(place) > 1)
            raise ParameterError(f"{given} is named more than once; give each run once")
        above = commonpath(places)
        names = [place.relative_to(above).as_posix() for place in places]
    if twice := next((name for name in names if names.count(name) > 1), None):
        raise ParameterError(f"two runs are called {twice!r}; save them in folders of their own")
    return names

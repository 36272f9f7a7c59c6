"""The folder of a batch: the results of many items, resumed where the batch was interrupted.

Two journals hold one line for each item that has ended: figures in ``items.jsonl``,
mean curves over the gait cycle in ``curves.jsonl``. A batch that is killed loses only the items
being computed. When all have ended, the tables are written from them: ``batch.csv``, and with
pyarrow ``batch.parquet`` and ``curves.parquet`` (``curves.csv`` without it).
"""

import base64
import json
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade import __version__
from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError, RunExists
from plantigrade.motion.cycles import PERCENT
from plantigrade.options import shown
from plantigrade.printable import printable
from plantigrade.record.folder import FORMAT, refuse_existing, remove_stale_parts, replace_file
from plantigrade.record.journal import NAME, Journal
from plantigrade.record.metrics import METRICS, metrics_json, read_metrics
from plantigrade.record.tables import Kind, columns_of, write_tables

KIND = "batch"  # Kind of the folder
ITEMS, CURVES, FAILED = "items.jsonl", "curves.jsonl", "failed.txt"
PRINTED = ("batch.pdf", "study.pdf")  # pages printed after an earlier end of the batch
TABLE, CURVE_TABLE = "batch", "curves"
CURVE_COLUMNS: dict[str, Kind] = {
    **{"name": "word", "variable": "word", "unit": "word"},
    **{"percent": "float", "mean": "float", "sd": "float", "cycles": "int"},
}
"""Columns of the table of curves, one row per percent of the gait cycle."""
UNFINISHED = "not finished; run the same command to continue"  # Status of a batch that has begun
FIRST = ("name", "file", "status")  # Columns of the table that come first
HEADER = ""  # Name of the first line of the journal, which holds what makes two batches the same
_PACKED = np.dtype("<f4")


@dataclass(frozen=True)
class Curve:
    """The mean of a curve over the gait cycles of one item."""

    unit: str  #: Its unit
    cycles: int  #: Number of cycles
    mean: Float[Array, " n_percent"]  #: Mean at every percent
    sd: Float[Array, " n_percent"]  #: Standard deviation over cycles; NaN for a single cycle

    def packed(self) -> list[Any]:
        """Return it as a line of the journal holds it: single precision, as text."""
        raw = np.stack([self.mean, self.sd]).astype(_PACKED).tobytes()
        return [self.unit, self.cycles, base64.b64encode(raw).decode()]

    @classmethod
    def unpacked(cls, packed: Sequence[Any]) -> "Curve":
        """Return the curve of a line of the journal."""
        unit, cycles, text = packed
        raw = base64.b64decode(text, validate=True)
        mean, sd = np.frombuffer(raw, _PACKED).reshape(2, len(PERCENT)).astype(float)
        return cls(str(unit), int(cycles), mean, sd)


@dataclass(frozen=True)
class Row:
    """Result of one item."""

    name: str  #: Its name, and that of its folder in that of the batch
    number: int = 0  #: Its place in the table
    file: str = ""  #: Where it came from; empty where it came from no file
    key: str = ""  #: Content hash of what decides the result
    status: str = ""  #: ``"ok"``, what is wrong with the result, or why there is none
    failed: bool = False  #: Whether there is no result
    left_out: bool = False  #: Whether it was found in a folder and holds nothing to work on
    seconds: float = 0.0  #: How long it took [s]
    sha256: str = ""  #: Of the file
    varied: Mapping[str, Any] = field(default_factory=dict)  #: What it has of its own, by option
    #: Every figure: numbers, words and booleans by name
    figures: Mapping[str, Any] = field(default_factory=dict)
    warnings: Sequence[str] = ()  #: Every warning, a sentence

    @classmethod
    def of(cls, line: Mapping[str, Any]) -> "Row":
        """Return the row of a line of the journal.

        Raises:
            TypeError: If a value is of another type.
            ValueError: If a number is no number.
        OverflowError: If a number is too large for a table.
        """
        words = {k: line.get(k, "") for k in ("name", "file", "key", "status", "sha256")}
        tables = {k: line.get(k, {}) for k in ("varied", "figures")}
        for kind, values in ((str, words), (dict, tables)):
            for name, value in values.items():
                if not isinstance(value, kind):
                    raise TypeError(f"{name} is {shown(value)}")
        warnings = line.get("warnings", ())
        if not isinstance(warnings, list | tuple) or any(
            type(each) is not str for each in warnings
        ):
            raise TypeError(f"warnings are {shown(warnings)}")
        for name, value in (*tables["varied"].items(), *tables["figures"].items()):
            if isinstance(value, dict | list):
                raise TypeError(f"{name} is {shown(value)}")
            if isinstance(value, int):
                float(value)  # too large for a table: an OverflowError
        return cls(
            **words,
            **tables,
            warnings=tuple(warnings),
            number=int(line.get("number", 0)),
            failed=bool(line.get("failed")),
            left_out=bool(line.get("left_out")),
            seconds=float(line.get("seconds") or 0.0),
        )

    def table_row(self, settings: Mapping[str, Any]) -> dict[str, Any]:
        """Return its line of the table: figures, then the settings, which all items share."""
        return {
            **{"name": self.name, "file": self.file or None, "status": self.status},
            **self.varied,
            **self.figures,
            **{f"setting_{k}": v for k, v in settings.items() if k not in self.varied},
            **{"version": __version__, "sha256": self.sha256 or None, "seconds": self.seconds},
        }


class BatchFolder:
    """The folder of a batch.

    Args:
        path: The folder. It is made, or taken up if it holds the same batch.
        spec: What two batches have in common if they are the same: command, settings, what varies.
        overwrite: Replace a folder of results that is there.
    """

    def __init__(self, path: Path, spec: Mapping[str, Any], command: str, overwrite: bool):
        self.path = path
        self.spec = json.loads(metrics_json({"version": __version__, **spec}))
        self.command = command
        self._claim(overwrite)
        remove_stale_parts(path)
        self.items = Journal(path / ITEMS)
        self.curves = Journal(path / CURVES)
        self.items.open()
        if not len(self.items):
            self.items.append({NAME: HEADER, **self.spec})
        #: Item that had ended when the folder was opened → its file, and its key if it has a result
        self.before: dict[str, tuple[str, str]] = {}
        self._numbers: dict[str, int] = {}
        try:
            for line in self.items:
                if line[NAME] != HEADER:
                    row = self._row(line)
                    self.before[row.name] = row.file, "" if row.failed else row.key
                    self._numbers[row.name] = row.number
        except FileError:
            self.items.close()
            raise

    def rows(self) -> Iterator[Row]:
        """Yield the results so far, in the order of the items."""
        order = sorted(self._numbers, key=lambda name: (self._numbers[name], name))
        return (self._row(line) for line in self.items.lines(order))

    def _row(self, line: Mapping[str, Any]) -> Row:
        try:
            return Row.of(line)
        except (TypeError, ValueError, OverflowError) as error:
            raise self._damaged(ITEMS, error) from error

    def _damaged(self, name: str, error: Exception) -> FileError:
        remedy = "add --overwrite to do the whole batch again"
        return FileError(self.path / name, f"is no journal of a batch ({error})", remedy=remedy)

    def place(self, name: str, number: int) -> None:
        """Set the place in the table of an item that was done before."""
        self._numbers[name] = number

    def add(self, row: Row, curves: Mapping[str, Curve]) -> None:
        """Append the result of an item to the journals."""
        if curves or row.name in self.curves:  # those of an earlier result hold no longer
            packed = {name: curve.packed() for name, curve in curves.items()}
            self.curves.append({NAME: row.name, "curves": packed})
        self.items.append(vars(row))
        self._numbers[row.name] = row.number

    def announce(self, names: Iterable[str]) -> None:
        """List in ``metrics.json`` the folders of the batch that has begun."""
        there = [path.name for path in self.path.iterdir() if path.is_file()]
        files = {ITEMS, CURVES, *(set(there) & set(self._listed))} - {METRICS}
        self._write({"status": UNFINISHED}, sorted(files), {*names, *self._numbers})

    def finish(
        self, found: Mapping[str, Any], pages: Mapping[str, str], folders: Sequence[str] = ()
    ) -> dict[str, Any]:
        """Write the tables, the pages and the figures; return ``metrics.json``."""
        written = self._tables()
        failed = [r.file for r in self.rows() if r.failed and r.file and not r.left_out]
        texts = dict(pages)
        if failed:
            texts[FAILED] = "".join(f"{printable(file, lines=False)}\n" for file in failed)
        else:
            (self.path / FAILED).unlink(missing_ok=True)
        for name, text in texts.items():
            replace_file(self.path / name, text)
        self.items.close()
        self.curves.close()
        kept = [name for name in (ITEMS, CURVES, *PRINTED) if (self.path / name).is_file()]
        return self._write(found, [*written, *texts, *kept], {*folders, *self._numbers})

    def curve_means(self) -> Iterator[tuple[str, dict[str, Curve]]]:
        """Yield name and curves of every item that has some, in the order of the items."""
        order = sorted(self._numbers, key=lambda name: (self._numbers[name], name))
        for line in self.curves.lines(order):
            try:
                found = {k: Curve.unpacked(v) for k, v in line["curves"].items()}
            except (TypeError, ValueError, KeyError, AttributeError) as error:
                raise self._damaged(CURVES, error) from error
            if found:
                yield line[NAME], found

    def _tables(self) -> list[str]:
        settings = self.spec["settings"]

        def rows() -> Iterator[dict[str, Any]]:
            return (row.table_row(settings) for row in self.rows())

        last = [*(f"setting_{name}" for name in settings), "version", "sha256", "seconds"]
        kinds = columns_of(rows(), FIRST)
        columns: dict[str, Kind] = {k: v for k, v in kinds.items() if k not in last}
        columns |= {k: kinds[k] for k in last if k in kinds}
        written = write_tables(self.path, TABLE, rows, columns)
        if len(self.curves):
            words = [name for name, kind in CURVE_COLUMNS.items() if kind == "word"]
            written += write_tables(
                self.path,
                CURVE_TABLE,
                self._curve_rows,
                CURVE_COLUMNS,
                also_csv=False,
                repeating=words,
            )
        return written

    def _curve_rows(self) -> Iterator[dict[str, Any]]:
        for name, curves in self.curve_means():
            for variable, curve in curves.items():
                fixed = {"name": name, "variable": variable, "unit": curve.unit}
                for percent, mean, sd in zip(PERCENT, curve.mean, curve.sd, strict=True):
                    known = {k: float(v) for k, v in (("mean", mean), ("sd", sd)) if v == v}
                    yield {**fixed, "percent": float(percent), **known, "cycles": curve.cycles}

    def _write(
        self, found: Mapping[str, Any], files: Sequence[str], names: Iterable[str]
    ) -> dict[str, Any]:
        marked = {"format": FORMAT, "kind": KIND, "command": self.command, **self.spec}
        marked |= {**found, "files": sorted(files), "folders": sorted(names)}
        text = metrics_json(marked)
        replace_file(self.path / METRICS, text + "\n")
        return json.loads(text)

    def _claim(self, overwrite: bool) -> None:
        self._listed: list[str] = []
        if (self.path / METRICS).is_file() and not overwrite:
            try:
                held = read_metrics(self.path)
            except FileError:  # cut off: the journal beside it knows what was done
                lines = iter(Journal(self.path / ITEMS))
                held = {"kind": KIND, **line} if (line := next(lines, None)) else {}
            if held.get("kind") == KIND:
                other = [key for key in self.spec if held.get(key) != self.spec[key]]
                if not other:
                    self._listed = [str(name) for name in held.get("files", ())]
                    return
                raise RunExists(
                    f"{self.path} holds another batch ({_differing(other, held, self.spec)}): "
                    "choose another folder with --out, or add --overwrite"
                )
        if self.path.exists():
            refuse_existing(self.path, overwrite)
            shutil.rmtree(self.path)
        try:
            self.path.mkdir(parents=True)
        except OSError as error:
            raise FileError(self.path, f"cannot be written ({error.strerror or error})") from error
        self._write({"status": UNFINISHED}, [ITEMS, CURVES], ())


def _differing(keys: Sequence[str], held: Mapping[str, Any], requested: Mapping[str, Any]) -> str:
    """Return in words the first setting in which a batch differs from the requested one."""
    key = keys[0]
    before, now = held.get(key), requested[key]
    if isinstance(before, dict) and isinstance(now, dict):
        key = next(k for k in {**now, **before} if before.get(k) != now.get(k))
        before, now = before.get(key), now.get(key)
    return f"{key} {str(before)[:40]}, not {str(now)[:40]}"

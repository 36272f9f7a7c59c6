r"""MOT and STO tables of OpenSim: joint coordinates, ground reactions, moments.

A header up to ``endheader`` (several versions are in use), a row of column names starting with
``time``, then rows of numbers. OpenSim's axes are x forward, y up, z to the right; ground reactions
are rotated to ours (x forward, y left, z up), pelvis translations are kept (see
:class:`~plantigrade.motion.recording.Recording`).

**Angles.** ``inDegrees=yes`` scales rotations only: not translations (``…_tx``), moments, forces
or the patella's dependent ``…_beta`` (which files give in either unit). If the header does not say,
degrees are assumed, as in OpenSim, unless the numbers can only be radians.

**Knee.** Flexion is negative in the gait2392 family and the planar models, positive in
Rajagopal's (:func:`~plantigrade.io.opensim_coordinates.knee_sign` tells from the data);
coordinates are returned with flexion positive.

**Ground reactions.** See :mod:`plantigrade.io.opensim_forces`.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError, ParameterError
from plantigrade.io.opensim_coordinates import (
    COORDINATE,
    NO_ANGLE,
    coordinate_columns,
    to_radians,
    turn_knees,
)
from plantigrade.io.opensim_forces import force_groups, plates_of, plates_table
from plantigrade.io.text import count_of, numbers, parse_numbers, read_text, unique_labels
from plantigrade.io.writing import write_text
from plantigrade.motion.recording import ForcePlate, Recording, Table

_ANSWERS = {"yes": True, "true": True, "1": True, "no": False, "false": False, "0": False}
MAX_COLUMNS = 5000  # beyond it the file is damaged; models with muscles have some hundreds
MAX_BYTES = 80e6  # of a file [bytes]: about 5 minutes of two plates at 2000 Hz


@dataclass(frozen=True)
class MotFile:
    """Contents of a MOT or STO file, unscaled."""

    table: Table  #: Its columns, with names reduced to those of the coordinates
    paths: tuple[str, ...]  #: Column names as in the file
    in_degrees: bool | None  #: As stated in the header; None if not stated
    warnings: tuple[str, ...] = ()  #: Warnings for the user


def read_mot(path: str | Path, *, knee_sign: int | None = None) -> Recording:
    """Read joint coordinates or ground reactions (or both) from a MOT or STO file.

    Args:
        knee_sign: ``1`` if knee flexion is positive in the file, ``-1`` if negative; by default
            found from the data.

    Returns:
        A recording with ``coordinates`` [rad, m] (knee flexion positive), ``plates``, or both.
        Speeds, activations, moments and the patella's coordinates are left out
        (:func:`read_table` returns them).
    """
    if knee_sign not in (None, 1, -1):
        raise ParameterError(f"{knee_sign=} must be 1, -1 or None")
    file = _read(Path(path))
    warnings = list(file.warnings)
    groups = force_groups(file.table.names)
    used = {name for group in groups for axis in group.columns for name in axis if name}
    plates = plates_of(file.table, groups, warnings)
    keep = coordinate_columns(file.table.names, file.paths, used)
    coordinates = None
    if keep:
        values = file.table.values[:, keep].copy()
        names = tuple(file.table.names[k] for k in keep)
        to_radians(values, names, file.in_degrees, warnings)
        turn_knees(values, names, knee_sign, warnings)
        coordinates = Table(names, _cycle_time(file.table.time, values, warnings), values)
    if coordinates is None and not plates:
        names = ", ".join(file.table.names[:6])
        raise FileError(
            path,
            f"contains neither joint coordinates nor ground reactions, but {names} …",
            where="column names",
            remedy="give a motion (hip_flexion_r …) or a force file (ground_force_vx …)",
        )
    return Recording(
        source=Path(path), coordinates=coordinates, plates=plates, warnings=tuple(warnings)
    )


def read_table(path: str | Path) -> Table:
    """Read every column of a MOT or STO file: moments, activations, anything.

    Angles are converted to radians; nothing else is scaled, no sign is changed, no axis rotated.

    Raises:
        FileError: If the file cannot be read.
    """
    file = _read(Path(path))
    values = file.table.values.copy()
    known = [k for k, name in enumerate(file.table.names) if COORDINATE.fullmatch(name)]
    if known:
        to_radians(values, file.table.names, file.in_degrees, [], set(known))
    return Table(file.table.names, file.table.time, values)


def _read(path: Path) -> MotFile:
    text = read_text(path, MAX_BYTES)
    broken = partial(
        FileError, path, remedy="check that this is a complete MOT or STO file of OpenSim"
    )
    end = re.search(r"^[ \t]*endheader\b[^\n]*$", text, re.MULTILINE | re.IGNORECASE)
    if end is None:
        raise broken("has no line 'endheader'", where="header")
    header = _header(text[: end.start()])
    if header.get("datatype", "double").lower() not in ("double", "float"):
        problem = f"DataType={header['datatype']}: only tables of plain numbers are read"
        raise FileError(path, problem, where="header", remedy="export it as doubles")
    warnings: list[str] = []
    labels = re.compile(r"\s*([^\n]*\S)[^\n]*(?:\n|$)").match(text, end.end())
    if labels is None:
        raise broken("ends after its header", where="endheader")
    line = text.count("\n", 0, labels.start(1)) + 1
    row = labels[1]
    paths = [p.strip().strip('"') for p in (row.split("\t") if "\t" in row else row.split())]
    paths = [p for p in paths if p]
    if not paths or paths[0].lower() not in ("time", "t"):
        problem = f"the first column is {(paths or [''])[0][:40]!r}, it must be time"
        raise broken(problem, where=f"line {line}")
    if len(paths) > MAX_COLUMNS:
        raise broken(f"has {len(paths)} columns", where=f"line {line}")
    values = _rows(path, text[labels.end() :], line, paths, warnings)
    values = _checked_time(path, values, warnings)
    stated = header.get("nrows", header.get("datarows", ""))
    if (count_of(stated) or 0) > len(values):
        warnings.append(f"the header announces {stated} rows, the file holds {len(values)}")
    names = _unique([_reduced(p) for p in paths[1:]], paths[1:], warnings)
    in_degrees = _ANSWERS.get(header.get("indegrees", "").lower())
    table = Table(names, values[:, 0], values[:, 1:])
    return MotFile(table, tuple(paths[1:]), in_degrees, tuple(warnings))


def _header(text: str) -> dict[str, str]:
    """Return the keys of a header, lower case: ``key=value`` lines and SIMM's ``key value``."""
    header: dict[str, str] = {}
    for line in text.splitlines():
        key, equals, value = line.partition("=")
        if equals:
            header[key.strip().lower()] = value.strip()
        elif len(words := line.split()) == 2 and words[0].lower() in ("datarows", "datacolumns"):
            header[words[0].lower()] = words[1]
    return header


def _reduced(path: str) -> str:
    """Return the coordinate's name of a column name.

    Example:
        >>> _reduced("/jointset/hip_r/hip_flexion_r/value"), _reduced("hip_flexion_r/speed")
        ('hip_flexion_r', 'hip_flexion_r/speed')
    """
    parts = [part for part in path.split("/") if part]
    if len(parts) > 1 and parts[-1] == "value":
        return parts[-2]
    return "/".join(parts[-2:]) if parts else path


def _unique(names: Sequence[str], paths: Sequence[str], warnings: list[str]) -> tuple[str, ...]:
    """Return unique names: repeated ones get their full path, then a number."""
    full = [p if names.count(n) > 1 else n for n, p in zip(names, paths, strict=True)]
    return unique_labels(full, warnings)


def _rows(
    path: Path, text: str, line: int, names: Sequence[str], warnings: list[str]
) -> Float[Array, "n k"]:
    """Return the rows of numbers; a truncated last row is left out with a warning."""
    lines = text.rstrip().split("\n")
    first = next((row for row in lines if row.strip()), "")
    if not first:
        remedy = "check that the file is complete"
        raise FileError(path, "has no rows of numbers", where=f"line {line + 1}", remedy=remedy)
    delimiter = "\t" if "\t" in first.strip() else None
    others = any(row.strip() for row in lines[:-1])
    if others and len(lines[-1].strip().split(delimiter)) < len(names):
        warnings.append(f"the last row (line {line + len(lines)}) is truncated and was left out")
        lines.pop()
    if delimiter and all(line.count("\t") == len(names) - 1 for line in lines):
        flat = parse_numbers(text)
        if flat is not None and flat.size == len(lines) * len(names):
            flat[np.isinf(flat)] = np.nan
            return flat.reshape(-1, len(names))
    return numbers(
        lines, path, count=len(names), first_line=line + 1, delimiter=delimiter, names=names
    )


def _checked_time(path: Path, values: np.ndarray, warnings: list[str]) -> np.ndarray:
    """Return the rows in order of time; repeated rows are left out."""
    time = values[:, 0]
    if not np.isfinite(time).all():
        where = f"row {np.flatnonzero(~np.isfinite(time))[0] + 1}, column time"
        remedy = "every row needs its time [s]"
        raise FileError(path, "time is not a number", where=where, remedy=remedy)
    step = np.diff(time)
    if (step < 0).any():
        where = f"row {np.flatnonzero(step < 0)[0] + 2}, column time"
        remedy = "sort the rows by time; one trial per file"
        raise FileError(path, "time decreases", where=where, remedy=remedy)
    if (step == 0).any():
        warnings.append(
            f"{(step == 0).sum()} rows repeat the time of the row before and were left out"
        )
        values = values[np.concatenate([[True], step > 0])]
    return values


def _cycle_time(time: np.ndarray, values: np.ndarray, warnings: list[str]) -> np.ndarray:
    """Return the time; a percentage of the gait cycle is converted to one second per cycle."""
    if len(time) < 20 or time[0] != 0 or time[-1] not in (1.0, 100.0):
        return time
    span = np.nanmax(values, axis=0) - np.nanmin(values, axis=0)
    moving = span > 0.05
    if not moving.any() or (np.abs(values[-1] - values[0])[moving] > 0.15 * span[moving]).any():
        return time
    warnings.append(
        "time runs from 0 to "
        f"{time[-1]:g} and the motion ends as it begins: it was taken as one gait cycle of 1 s"
    )
    return time / time[-1]


def write_mot(
    what: Recording | Table | Sequence[ForcePlate], path: str | Path, *, in_degrees: bool = True
) -> Path:
    """Write joint coordinates or ground reactions in OpenSim's format.

    Args:
        what: A table of coordinates [rad, m], plates, or a recording (its coordinates or, if it has
            none, its plates).
        path: The file, ``.mot`` or ``.sto``.
        in_degrees: Write angles in degrees; translations and ``…_beta`` are never scaled.

    Raises:
        ParameterError: If there is nothing to write.
        FileError: If the file cannot be written.
    """
    if isinstance(what, Recording):
        if what.coordinates is None and not what.plates:
            raise ParameterError(
                f"{what.source} has neither coordinates nor ground reactions to write as MOT"
            )
        what = what.coordinates if what.coordinates is not None else what.plates
    table = what if isinstance(what, Table) else plates_table(what)
    write_text(path, mot_text(table, Path(path).stem, isinstance(what, Table) and in_degrees))
    return Path(path)


def mot_text(table: Table, title: str, in_degrees: bool) -> str:
    """Return a table in OpenSim's format."""
    values = table.values
    if in_degrees:
        angle = np.array([NO_ANGLE.search(name) is None for name in table.names], dtype=bool)
        values = np.where(angle[None, :], values * (180 / np.pi), values)
    lines = [
        title,
        "version=1",
        f"nRows={len(table.time)}",
        f"nColumns={len(table.names) + 1}",
        f"inDegrees={'yes' if in_degrees else 'no'}",
        "endheader",
        "\t".join(["time", *(re.sub(r"\s+", "_", name) for name in table.names)]),
    ]
    row = "\t".join(["%.10g"] * (len(table.names) + 1))
    rows = np.concatenate([table.time[:, None], values], axis=1).tolist()
    lines += [row % tuple(one) for one in rows]
    return "\n".join(lines) + "\n"

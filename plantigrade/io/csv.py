"""Plain tables of markers or joint coordinates, one row per time.

The package's own format: a header, then numbers, separated by commas, semicolons or tabs::

    # unit: m
    # up: z
    time, LASI_x, LASI_y, LASI_z, …, hip_flexion_r, …

``NAME_x, NAME_y, NAME_z`` is a marker; every other column is a coordinate [rad, m]. An empty field
is a missing value. The lines that start with ``#`` may be left out, or say otherwise: ``unit`` (m,
cm, mm), ``up`` (x, y, z, with a sign if need be), ``angles`` (radians, degrees: of the columns that
are angles, that is all but those that end in ``_tx``, ``_ty`` or ``_tz``). If they are absent and
the body would be hundreds of metres tall or lie on its side, the reader assumes other values, with
a warning.
"""

import csv as _csv
import re
from collections import Counter
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from plantigrade.errors import FileError
from plantigrade.io.axes import MIN_CERTAINTY, UP_AXES, is_seen, to_world, up_axis_of_points
from plantigrade.io.c3d import LENGTH_UNITS, NAMES_OF_UNITS, unit_of_points
from plantigrade.io.text import check_time, numbers, read_text, unique_labels
from plantigrade.io.writing import write_text
from plantigrade.motion.recording import Markers, Recording, Table

_TIME_NAMES = {"time", "t", "time_s", "time[s]", "time(s)", "times", "seconds", "timestamp"}
_SKIPPED_NAMES = {"frame", "frame#", "frames", "index", "sample", ""}
_AXIS = re.compile(r"(.+?)[ _.:\-]([xyz])", re.I)
_AXIS_GLUED = re.compile(r"(.+?)([xyzXYZ])")


def read_csv(path: str | Path) -> Recording:
    """Read a table of markers, joint coordinates, or both.

    Raises:
        FileError: With line and field, if the table has no time, no columns or no numbers.
    """
    lines = read_text(path).split("\n")
    if lines and not lines[-1].strip():
        lines.pop()
    says, at = _comments(lines, path)
    in_header = partial(FileError, path, where=f"line {at + 1}")
    delimiter = max("\t;,", key=re.sub('"[^"]*"', "", lines[at]).count)
    if not lines[at].count(delimiter):
        raise in_header(
            "the header must contain several names separated by commas, semicolons or tabs",
            remedy="write 'time, NAME_x, NAME_y, NAME_z, …'",
        )
    warnings: list[str] = []
    names = _header(lines[at], delimiter, in_header, warnings)
    times = [i for i, n in enumerate(names) if n.lower().replace(" ", "") in _TIME_NAMES]
    if not times:
        given = f"{', '.join(names[:6])}{', …' if len(names) > 6 else ''}"
        raise in_header(f"no column 'time' among {given}", remedy="add a column 'time' in seconds")
    rows = lines[at + 1 :]
    decimal = "," if delimiter != "," and any("," in row for row in rows[:3]) else "."
    table = numbers(
        rows,
        path,
        count=len(names),
        first_line=at + 2,
        delimiter=delimiter,
        decimal=decimal,
        short=True,
        names=names,
    )
    if len(table) == 0:
        raise in_header("has a header but no rows of numbers", remedy="export it again")
    time = table[:, times[0]]
    check_time(time, rows, path, first_line=at + 2)
    triples = _triples(names)
    taken = {i for three in triples.values() for i in three} | {times[0]}
    rest = [i for i, n in enumerate(names) if i not in taken and n.lower() not in _SKIPPED_NAMES]
    markers = coordinates = None
    if triples:
        raw = np.stack([table[:, three] for three in triples.values()], axis=1)
        positions = _positions(raw, says, path, warnings)
        markers = Markers(tuple(triples), time, positions)
    if rest:
        values = table[:, rest].copy()
        _to_radians(values, [names[i] for i in rest], says, path, warnings)
        coordinates = Table(tuple(names[i] for i in rest), time, values)
    if markers is None and coordinates is None:
        remedy = "add columns NAME_x, NAME_y, NAME_z of markers, or joint coordinates"
        raise in_header("contains only time", remedy=remedy)
    return Recording(
        source=Path(path), markers=markers, coordinates=coordinates, warnings=tuple(warnings)
    )


def write_csv(recording: Recording, path: str | Path) -> None:
    """Write markers and coordinates at the same times: SI units, radians, z up."""
    markers, coordinates = recording.markers, recording.coordinates
    first = markers or coordinates
    if first is None:
        raise FileError(
            path,
            "the recording has neither markers nor coordinates",
            remedy="write another skeleton to .bvh or .npz",
        )
    names: list[str] = []
    parts = []
    time = first.time
    if markers is not None:
        names += [f"{name}_{axis}" for name in markers.names for axis in "xyz"]
        parts.append(markers.positions.reshape(len(time), -1))
    if coordinates is not None:
        if len(coordinates.time) != len(time) or np.abs(coordinates.time - time).max() > 1e-6:
            raise FileError(
                path,
                "markers and coordinates have different times; a table has one time column",
                remedy="resample one of them, or write .npz",
            )
        names += list(coordinates.names)
        parts.append(coordinates.values)
    for name in names:
        if "\n" in name or "\r" in name:
            raise FileError(path, f"name {name!r} is not allowed in a header", remedy="rename it")
    quoted = ['"' + n.replace('"', '""') + '"' if re.search(r'[",;\t]', n) else n for n in names]
    values = np.concatenate(parts, axis=1)
    row = "%.9g" + ",%.9g" * values.shape[1]
    body = "\n".join(
        row % (t, *line) for t, line in zip(time.tolist(), values.tolist(), strict=True)
    )
    head = "# unit: m\n# up: z\n# angles: radians\ntime," + ",".join(quoted) + "\n"
    write_text(path, head + body.replace("nan", "") + "\n")


def _comments(lines: list[str], path) -> tuple[dict[str, str], int]:
    """Return the settings in the comments and the index of the header."""
    says = {}
    for i, line in enumerate(lines):
        bare = line.strip()
        if bare.startswith("#"):
            match = re.match(r"#\s*(\w+)\s*[:=]\s*(.+?)[\s,;]*$", bare)
            if match:
                says[match[1].lower()] = match[2].strip().lower()
        elif bare:
            return says, i
    raise FileError(path, "contains only comments", remedy="add a header and rows of numbers")


def _header(
    line: str, delimiter: str, in_header: Callable[..., FileError], warnings: list[str]
) -> list[str]:
    try:
        names = next(_csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    except _csv.Error as error:
        raise in_header(f"header cannot be read ({error})", remedy="shorten it") from None
    names = [name.strip() for name in names]
    while names and not names[-1]:
        names.pop()
    names = _numbered(names, warnings)
    seen = [name for name in names if name]
    twice = [name for name, n in Counter(seen).items() if n > 1]
    if twice:
        remedy = "give every column a unique name"
        raise in_header(f"column {twice[0]!r} occurs more than once", remedy=remedy)
    if seen and all(re.fullmatch(r"[-+.\deE]+", name) for name in seen):
        remedy = "add a header 'time, NAME_x, NAME_y, NAME_z, …'"
        raise in_header("starts with numbers instead of column names", remedy=remedy)
    return names


def _numbered(names: list[str], warnings: list[str]) -> list[str]:
    """Return the columns with numbered labels of repeated markers: ``LKNE_2_x``."""
    at: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        if (match := _AXIS.fullmatch(name)) and not re.search(r"_t[xyz]$", name):
            at.setdefault(match[2].lower(), []).append(i)
    labels = {axis: [names[i][:-2] for i in columns] for axis, columns in at.items()}
    if len(at) < 3 or len({tuple(each) for each in labels.values()}) > 1:
        return names  # not three columns to each label
    label_warnings: list[str] = []
    for axis, columns in at.items():
        for i, label in zip(columns, unique_labels(labels[axis], label_warnings), strict=True):
            names[i] = label + names[i][-2:]
    warnings += label_warnings[:1]
    return names


def _triples(names: list[str]) -> dict[str, tuple[int, int, int]]:
    """Return the columns of each marker: NAME_x, NAME_y, NAME_z (also NAME.X, NAMEx)."""
    for pattern in (_AXIS, _AXIS_GLUED):
        found: dict[str, dict[str, int]] = {}
        for i, name in enumerate(names):
            match = pattern.fullmatch(name)
            if match and not re.search(r"_t[xyz]$", name):
                found.setdefault(match[1], {})[match[2].lower()] = i
        whole = {n: (c["x"], c["y"], c["z"]) for n, c in found.items() if len(c) == 3}
        if whole:
            return whole
    return {}


def _positions(raw: np.ndarray, says: dict, path, warnings: list[str]) -> np.ndarray:
    raw = raw.copy()
    raw[~is_seen(raw)] = np.nan
    word = says.get("unit", says.get("units"))
    if word is not None and word not in LENGTH_UNITS:
        raise FileError(
            path, f"unit {word[:20]!r} is unknown", where="# unit", remedy="use m, cm or mm"
        )
    unit = LENGTH_UNITS[word] if word else unit_of_points(raw) if np.isfinite(raw).any() else 1.0
    if word is None and unit != 1.0:
        warnings.append(
            f"the table states no length unit; from the size of the body it was taken as "
            f"{NAMES_OF_UNITS[unit]} (write '# unit: m' on top to say otherwise)"
        )
    up = says.get("up")
    if up is not None:
        up = up if up[0] in "+-" else "+" + up
        if up not in UP_AXES:
            problem, remedy = f"up {up[:10]!r} is not an axis", f"use {', '.join(UP_AXES)}"
            raise FileError(path, problem, where="# up", remedy=remedy)
        return to_world(raw * unit, up)
    body, sure = up_axis_of_points(raw)
    if sure <= MIN_CERTAINTY or body == "+z":
        return to_world(raw * unit, "+z")
    warnings.append(
        f"the table does not state the vertical; the body is upright along {body}, which was "
        "taken as up (write '# up: z' on top to say otherwise)"
    )
    return to_world(raw * unit, body)


def _to_radians(values: np.ndarray, names: list[str], says, path, warnings) -> None:
    angles = [i for i, name in enumerate(names) if not re.search(r"_t[xyz]$", name, re.I)]
    word = says.get("angles", "radians")
    if word in ("degrees", "degree", "deg"):
        values[:, angles] = np.deg2rad(values[:, angles])
    elif word not in ("radians", "radian", "rad"):
        problem = f"angles {word[:20]!r} is not a unit of angle"
        raise FileError(path, problem, where="# angles", remedy="use radians or degrees")
    elif "angles" not in says and angles and np.nanmax(np.abs(values[:, angles]), initial=0) > 13:
        warnings.append(
            "coordinates beyond 13 rad look like degrees: if so, write '# angles: degrees' on top"
        )

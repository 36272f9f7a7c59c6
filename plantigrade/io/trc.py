"""TRC marker trajectories (Motion Analysis, OpenSim): a five-line header, then one row per frame.

OpenSim's axes are x forward, y up, z right; some laboratories export z up, which is
detected from the height of the body. The header states the unit. An empty field, a word for
"missing" and the exact point 0, 0, 0 all mean a missing marker.
"""

from pathlib import Path

import numpy as np

from plantigrade.errors import FileError
from plantigrade.io.axes import MIN_CERTAINTY, from_world, is_seen, to_world, up_axis_of_points
from plantigrade.io.c3d import LENGTH_UNITS, NAMES_OF_UNITS, unit_of_points
from plantigrade.io.text import check_time, count_of, number, numbers, read_text, unique_labels
from plantigrade.io.writing import write_text
from plantigrade.motion.recording import Markers, Recording

_HEADER_LINES = 40  # maximum length of a header


def read_trc(path: str | Path) -> Recording:
    """Read a TRC file."""
    lines = read_text(path).split("\n")
    cut = bool(lines[-1])
    if not cut:
        lines.pop()
    warnings: list[str] = []
    labels_at = _find_labels(lines, path)
    fields = _header(lines[:labels_at])
    names, delimiter = _names(lines[labels_at], path, labels_at + 1, warnings)
    first = _first_row(lines, labels_at + 1)
    columns = ["Frame#", "Time"] + [f"{name} {axis}" for name in names for axis in "xyz"]
    rows = lines[first:]
    sample = rows[0] if rows else ""
    decimal = "," if delimiter != "," and "," in sample and "." not in sample else "."
    if cut and len(rows) > 1 and rows[-1].strip() and len(rows[-1].split(delimiter)) < len(columns):
        rows.pop()
        warnings.append("the last row is truncated and was left out")
    if (count_of(fields.get("nummarkers", "")) or 0) > len(names) and delimiter is not None:
        # Trajectories without a name follow those with one.
        rows = [delimiter.join(row.split(delimiter)[: len(columns)]) for row in rows]
    table = numbers(
        rows,
        path,
        count=len(columns),
        first_line=first + 1,
        delimiter=delimiter,
        decimal=decimal,
        short=delimiter is not None,
        names=columns,
    )
    if len(table) == 0:
        where, remedy = f"line {first + 1}", "export the trajectories again"
        raise FileError(path, "has a header but no frames", where=where, remedy=remedy)
    time = _time(table, fields, rows, first, path, warnings)
    _check_counts(fields, len(names), len(table), warnings)
    raw = table[:, 2:].reshape(len(table), len(names), 3)
    raw[~is_seen(raw)] = np.nan
    unit = _unit(fields, raw, warnings)
    up = "+y"
    body, sure = up_axis_of_points(raw)
    if sure > MIN_CERTAINTY and body != up:
        warnings.append(
            f"TRC files have y up, but this body is upright along {body} ({sure:.1f} times longer "
            f"than along the next axis); {body} was taken as up"
        )
        up = body
    if not np.isfinite(raw).any():
        warnings.append("no marker is visible in any frame")
    markers = Markers(names=names, time=time, positions=to_world(raw * unit, up))
    return Recording(source=Path(path), markers=markers, warnings=tuple(warnings))


def write_trc(recording: Recording, path: str | Path) -> None:
    """Write markers in mm, OpenSim's axes (x forward, y up, z right), to 1e-5 mm.

    A missing marker is an empty field.
    """
    markers = recording.markers
    if markers is None or markers.n_frames == 0 or not markers.names:
        raise FileError(
            path,
            "the recording has no markers, and a TRC file stores nothing else",
            remedy="write joint angles to .mot or .npz, another skeleton to .bvh",
        )
    for name in markers.names:
        if not name.strip() or any(c in name for c in "\t\r\n"):
            raise FileError(
                path, f"marker name {name!r} is not allowed in a TRC header", remedy="rename it"
            )
    n, rate = markers.n_frames, np.nan_to_num(markers.rate, nan=100.0)
    file = from_world(markers.positions, "+y").reshape(n, -1) * 1e3
    row = "%d\t%.9g" + "\t%.5f" * file.shape[1]
    body = "\n".join(
        row % (i + 1, t, *values)
        for i, (t, values) in enumerate(zip(markers.time.tolist(), file.tolist(), strict=True))
    )
    values = (f"{rate:.6g}", f"{rate:.6g}", n, len(markers.names), "mm", f"{rate:.6g}", 1, n)
    header = [
        f"PathFileType\t4\t(X/Y/Z)\t{Path(path).name}",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame"
        "\tOrigNumFrames",
        "\t".join(map(str, values)),
        "Frame#\tTime\t" + "\t\t\t".join(markers.names) + "\t\t",
        "\t\t" + "\t".join(f"{axis}{i + 1}" for i in range(len(markers.names)) for axis in "XYZ"),
        "",
    ]
    write_text(path, "\n".join(header) + "\n" + body.replace("nan", "") + "\n")


def _find_labels(lines: list[str], path) -> int:
    for i, line in enumerate(lines[:_HEADER_LINES]):
        words = line.lower().split()
        if len(words) >= 2 and words[0].strip("#") == "frame" and words[1].startswith("time"):
            return i
    raise FileError(
        path,
        f"none of the first {min(len(lines), _HEADER_LINES)} lines starts with 'Frame#  Time', so "
        "this is not a TRC file or its header is truncated",
        where="header",
        remedy="check that its extension matches its format, or export it again",
    )


def _header(lines: list[str]) -> dict[str, str]:
    """Return the fields of the header, keys in lower case: a line of names above one of values."""
    for above, below in zip(lines, lines[1:], strict=False):
        keys, values = above.split(), below.split()
        if "datarate" in (key.lower() for key in keys):
            return {key.lower(): value for key, value in zip(keys, values, strict=False)}
    return {}


def _names(line: str, path, where: int, warnings: list[str]) -> tuple[tuple[str, ...], str | None]:
    delimiter = "\t" if line.count("\t") >= 2 else "," if line.count(",") >= 2 else None
    words = [word.strip() for word in line.split(delimiter)][2:]
    names = [word for word in words if word]
    if not names:
        remedy = "name one marker per 3 columns"
        raise FileError(path, "names no marker", where=f"line {where}", remedy=remedy)
    return unique_labels(names, warnings), delimiter


def _first_row(lines: list[str], start: int) -> int:
    """Return the index of the first row of numbers: after ``X1 Y1 Z1`` and blank lines."""
    for i in range(start, min(start + 5, len(lines))):
        words = lines[i].split()
        if words and not words[0].lower().startswith("x"):
            return i
    return min(start + 1, len(lines))


def _time(table, fields, rows, first: int, path, warnings) -> np.ndarray:
    time = table[:, 1].copy()
    rate = fields.get("datarate", fields.get("camerarate", ""))
    if not np.isfinite(time).any() or (len(time) > 1 and not np.any(time)):
        per_second = number(rate, path, where="header", what="DataRate")
        if not 1e-3 < per_second < np.inf:
            raise FileError(path, f"DataRate is {rate}", where="header", remedy="correct it")
        step = 1.0 / per_second
        warnings.append("the column Time is empty; time was computed from DataRate")
        return np.arange(len(table)) * step
    check_time(time, rows, path, first_line=first + 1)
    return time


def _check_counts(fields, n_markers: int, n_frames: int, warnings: list[str]) -> None:
    for what, found in (("frames", n_frames), ("markers", n_markers)):
        said = fields.get(f"num{what}", "")
        if count_of(said) not in (None, found):
            warnings.append(f"the header announces {said} {what}, the file holds {found}")


def _unit(fields, raw: np.ndarray, warnings: list[str]) -> float:
    word = fields.get("units", "").lower()
    if word in LENGTH_UNITS:
        return LENGTH_UNITS[word]
    unit = unit_of_points(raw)
    warnings.append(
        f"the header states the unit {word[:20]!r}; from the size of the body it was taken as "
        f"{NAMES_OF_UNITS[unit]}"
    )
    return unit

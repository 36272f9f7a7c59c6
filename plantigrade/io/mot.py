r"""MOT and STO tables of OpenSim: joint coordinates, ground reactions, moments.

A header up to ``endheader`` (several generations of it are in use), a row of column names that
begins with ``time``, then rows of numbers. OpenSim's axes are x forward, y up, z to the right;
ground reactions are turned to ours (x forward, y left, z up), pelvis translations stay as they
are (see :class:`~plantigrade.motion.recording.Recording`).

**Angles.** ``inDegrees=yes`` scales rotations only: not translations (``…_tx``), moments, forces
or the patella's dependent ``…_beta`` (which files give in either unit). Where the header does not
say, degrees are taken, as OpenSim does, unless the numbers can only be radians.

**Knee.** Flexion is negative in the gait2392 family and the planar models, positive in
Rajagopal's; :func:`knee_sign` tells from the data, and coordinates come back with flexion
positive.

**Ground reactions.** Any columns ``NAMEvx NAMEvy NAMEvz`` are a force, ``NAMEpx …`` its point,
``NAMEmx …`` or the same name with *torque* or *moment* instead of *force* its torque about that
point. With force :math:`f` and torque :math:`t` about :math:`p`, the centre of pressure and the
free moment about the vertical are (file axes)

.. math:: c = p + (t_z / f_y,\ 0,\ -t_x / f_y), \quad
    T = t_y - (c_z - p_z) f_x + (c_x - p_x) f_z .
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from warnings import catch_warnings, simplefilter

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import FileError, ParameterError
from plantigrade.io.text import numbers, read_text, write_text
from plantigrade.motion.recording import ForcePlate, Recording, Table

MIN_FORCE = 10.0  # [N] vertical; below it there is no centre of pressure
HYPEREXTENSION = np.deg2rad(20)  # further back no knee goes [rad]
MAX_COLUMNS = 5000
MAX_BYTES = 80e6  # of a file [bytes]: about 5 minutes of two plates at 2000 Hz

_OPENSIM_TO_OURS = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
_NO_ANGLE = re.compile(
    r"(_t[xyz]|_beta|_moment|_force|_torque|_power|_activation|_excitation|_length)$"
)
_NO_COORDINATE = re.compile(
    r"(_moment|_force|_torque|_power|_activation|_excitation|_length|_u|_beta)$"
    r"|\.(activation|fiber_length|excitation)$"
)
_COORDINATE = re.compile(
    r"(?:pelvis_(?:tilt|list|rotation|tx|ty|tz)"
    r"|(?:lumbar|thorax|neck|torso|trunk)\w*_(?:extension|bending|rotation)|lumbar"
    r"|(?:hip_(?:flexion|adduction|rotation)|knee_(?:angle|adduction|rotation|flexion)"
    r"|ankle_(?:angle|rotation|flexion)|subtalar_angle|mtp\d?_(?:angle|inversion|adduction)"
    r"|(?:heel|cuboid)_(?:angle|inversion|adduction)|arm_(?:flex|add|rot)|elbow_(?:flex|adduction)\w*"
    r"|pro_sup|wrist_(?:flex|dev)|fingers_flex|clavicle_\w+|shoulder_\w+)_[rl])"
)


@dataclass(frozen=True)
class MotFile:
    """A MOT or STO file as it stands: numbers unscaled.

    Attributes:
        table: Its columns; names reduced to those of the coordinates.
        paths: The columns' names as the file spells them.
        in_degrees: What the header says; None where it says nothing.
        warnings: What the user should know.
    """

    table: Table
    paths: tuple[str, ...]
    in_degrees: bool | None
    warnings: tuple[str, ...] = ()


# ---------------------------------------------------------------------------------------- reading


def read_mot(path: str | Path, *, knee_sign: int | None = None) -> Recording:
    """Read joint coordinates or ground reactions (or both) from a MOT or STO file.

    Args:
        path: The file.
        knee_sign: ``1`` if knee flexion is positive in the file, ``-1`` if negative; found from
            the data if absent.

    Returns:
        A recording with ``coordinates`` [rad, m] (knee flexion positive), ``plates``, or both.
        Speeds, activations, moments and the patella's coordinates are left out
        (:func:`read_table` returns them).

    Raises:
        FileError: If the file cannot be read or holds neither.
        ParameterError: If ``knee_sign`` is neither 1, -1 nor None.
    """
    if knee_sign not in (None, 1, -1):
        raise ParameterError(f"{knee_sign=} must be 1, -1 or None")
    file = _read(Path(path))
    warnings = list(file.warnings)
    groups = _force_groups(file.table.names)
    used = {name for group in groups for axis in group.columns for name in axis if name}
    plates = tuple(_plate(file.table, group, warnings) for group in groups)
    keep = _coordinate_columns(file, used)
    coordinates = None
    if keep:
        values = file.table.values[:, keep].copy()
        names = tuple(file.table.names[k] for k in keep)
        _to_radians(values, names, file, Path(path), warnings)
        _turn_knees(values, names, knee_sign, warnings)
        coordinates = Table(names, _cycle_time(file.table.time, values, warnings), values)
    if coordinates is None and not plates:
        names = ", ".join(file.table.names[:6])
        raise FileError(
            path,
            f"holds neither joint coordinates nor ground reactions, but {names} …",
            where="column names",
            remedy="name a motion (hip_flexion_r …) or force file (ground_force_vx …)",
        )
    return Recording(
        source=Path(path), coordinates=coordinates, plates=plates, warnings=tuple(warnings)
    )


def read_table(path: str | Path) -> Table:
    """Read every column of a MOT or STO file: moments, activations, anything.

    Angles come in radians; nothing else is scaled, no sign changed, no axis turned.

    Raises:
        FileError: If the file cannot be read.
    """
    file = _read(Path(path))
    values = file.table.values.copy()
    known = [k for k, name in enumerate(file.table.names) if _COORDINATE.fullmatch(name)]
    if known:
        _to_radians(values, file.table.names, file, Path(path), [], set(known))
    return Table(file.table.names, file.table.time, values)


def _read(path: Path) -> MotFile:
    text = read_text(path, MAX_BYTES)
    remedy = "check that this is a MOT or STO file of OpenSim and whole"
    end = re.search(r"^[ \t]*endheader\b[^\n]*$", text, re.MULTILINE | re.IGNORECASE)
    if end is None:
        raise FileError(path, "there is no line 'endheader'", where="header", remedy=remedy)
    header = _header(text[: end.start()])
    if header.get("datatype", "double").lower() not in ("double", "float"):
        raise FileError(
            path,
            f"DataType={header['datatype']}: only tables of plain numbers are read",
            where="header",
            remedy="export it as doubles",
        )
    warnings: list[str] = []
    labels = re.compile(r"\s*([^\n]*\S)[^\n]*(?:\n|$)").match(text, end.end())
    if labels is None:
        raise FileError(path, "ends after its header", where="endheader", remedy=remedy)
    line = text.count("\n", 0, labels.start(1)) + 1
    row = labels[1]
    paths = [p.strip().strip('"') for p in (row.split("\t") if "\t" in row else row.split())]
    paths = [p for p in paths if p]
    if not paths or paths[0].lower() not in ("time", "t"):
        raise FileError(
            path,
            f"the first column is {(paths or [''])[0][:40]!r}, it must be time",
            where=f"line {line}",
            remedy=remedy,
        )
    if len(paths) > MAX_COLUMNS:
        raise FileError(path, f"has {len(paths)} columns", where=f"line {line}", remedy=remedy)
    values = _rows(path, text[labels.end() :], line, paths, warnings)
    values = _checked_time(path, values, warnings)
    stated = header.get("nrows", header.get("datarows", ""))
    if stated.isdigit() and int(stated[:9]) > len(values):
        warnings.append(f"the header says {stated[:9]} rows, the file holds {len(values)}")
    names = _unique([_reduced(p) for p in paths[1:]], paths[1:])
    yes = header.get("indegrees", "").lower()
    return MotFile(
        Table(names, values[:, 0], values[:, 1:]),
        tuple(paths[1:]),
        True if yes in ("yes", "true", "1") else False if yes in ("no", "false", "0") else None,
        tuple(warnings),
    )


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


def _unique(names: Sequence[str], paths: Sequence[str]) -> tuple[str, ...]:
    """Return the names, with the full path where a short one stands twice, then with a number."""
    names = [p if names.count(n) > 1 else n for n, p in zip(names, paths, strict=True)]
    seen: dict[str, int] = {}
    for i, name in enumerate(names):
        seen[name] = seen.get(name, 0) + 1
        if seen[name] > 1:
            names[i] = f"{name}#{seen[name]}"
    return tuple(names)


def _rows(
    path: Path,
    text: str,
    line: int,
    names: Sequence[str],
    warnings: list[str],
) -> Float[Array, "n k"]:
    """Return the rows of numbers; a last row that is cut off is left out with a warning."""
    lines = text.rstrip().split("\n")
    first = next((row for row in lines if row.strip()), "")
    if not first:
        raise FileError(
            path,
            "there are no rows of numbers",
            where=f"line {line + 1}",
            remedy="check that the file is whole",
        )
    delimiter = "\t" if "\t" in first.strip() else None
    if len(lines) > 1 and len(lines[-1].strip().split(delimiter)) < len(names):
        warnings.append(f"the last row (line {line + len(lines)}) is cut off and left out")
        lines.pop()
    if delimiter and all(line.count("\t") == len(names) - 1 for line in lines):
        with catch_warnings():
            simplefilter("error")
            try:
                flat = np.fromstring(text, sep=" ")
            except (DeprecationWarning, ValueError, UnicodeError):
                flat = np.empty(0)
        if flat.size == len(lines) * len(names):
            flat[np.isinf(flat)] = np.nan
            return flat.reshape(-1, len(names))
    return numbers(
        lines, path, count=len(names), first_line=line + 1, delimiter=delimiter, names=names
    )


def _checked_time(path: Path, values: np.ndarray, warnings: list[str]) -> np.ndarray:
    """Return the rows with a time that increases; repeated rows are left out."""
    time = values[:, 0]
    if not np.isfinite(time).all():
        raise FileError(
            path,
            "time is not a number",
            where=f"row {np.flatnonzero(~np.isfinite(time))[0] + 1}, column time",
            remedy="every row needs its time [s]",
        )
    step = np.diff(time)
    if (step < 0).any():
        raise FileError(
            path,
            "time goes back",
            where=f"row {np.flatnonzero(step < 0)[0] + 2}, column time",
            remedy="sort the rows by time; one trial per file",
        )
    if (step == 0).any():
        warnings.append(f"{(step == 0).sum()} rows repeat the time of the row before: left out")
        values = values[np.concatenate([[True], step > 0])]
    return values


def _cycle_time(time: np.ndarray, values: np.ndarray, warnings: list[str]) -> np.ndarray:
    """Return the time; a percentage of a gait cycle becomes a second per cycle."""
    if len(time) < 20 or time[0] != 0 or time[-1] not in (1.0, 100.0):
        return time
    span = np.nanmax(values, axis=0) - np.nanmin(values, axis=0)
    moving = span > 0.05
    if not moving.any() or (np.abs(values[-1] - values[0])[moving] > 0.15 * span[moving]).any():
        return time
    warnings.append(
        "time runs from 0 to "
        f"{time[-1]:g} and the motion ends as it begins: one gait cycle, taken to last 1 s"
    )
    return time / time[-1]


# ---------------------------------------------------------------------------------- coordinates


def knee_sign(angles: Float[Array, "n k"]) -> int:
    """Return 1 if knee flexion is positive in ``angles`` [rad], -1 if it is negative.

    Knees do not hyperextend by more than 20 degrees: a side to which they go further is flexion. If
    they go further to neither or both, the sign of the median decides; within 2 degrees of zero
    flexion counts as positive.
    """
    finite = angles[np.isfinite(angles)]
    if not finite.size:
        return 1
    low, high, middle = finite.min(), finite.max(), float(np.median(finite))
    if (high > HYPEREXTENSION) != (low < -HYPEREXTENSION):
        return 1 if high > HYPEREXTENSION else -1
    return -1 if middle < -np.deg2rad(2) else 1


def _turn_knees(
    values: np.ndarray, names: Sequence[str], sign: int | None, warnings: list[str]
) -> None:
    knees = [k for k, name in enumerate(names) if re.fullmatch(r"knee_angle(_[rl])?", name)]
    if not knees:
        return
    if sign is None:
        sign = knee_sign(values[:, knees])
    if sign < 0:
        values[:, knees] *= -1
        warnings.append(
            "knee flexion is negative in this file (as in gait2392); turned to positive"
        )


def _coordinate_columns(file: MotFile, used: set[str]) -> list[int]:
    """Return the columns that are coordinates; none unless at least one has a known name."""
    names = file.table.names
    keep, known = [], False
    for k, (name, path) in enumerate(zip(names, file.paths, strict=True)):
        coordinate = "/" in path and path.endswith("/value")
        if name in used or _NO_COORDINATE.search(name) or ("/" in path and not coordinate):
            continue
        known = known or coordinate or _COORDINATE.fullmatch(name) is not None
        keep.append(k)
    return keep if known else []


def _to_radians(
    values: np.ndarray,
    names: Sequence[str],
    file: MotFile,
    path: Path,
    warnings: list[str],
    only: set[int] | None = None,
) -> None:
    """Scale the angles among ``values`` in place where they are degrees."""
    angles = [
        k
        for k, name in enumerate(names)
        if not _NO_ANGLE.search(name) and (only is None or k in only)
    ]
    joints = [k for k in angles if re.match(r"(hip|knee|ankle)_", names[k])]
    peak = float(np.nanmax(np.abs(values[:, joints]), initial=0.0)) if joints else np.nan
    degrees = file.in_degrees
    if degrees is None:
        knees = [k for k in angles if names[k].startswith("knee_angle")]
        span = np.ptp(np.nan_to_num(values[:, knees]), axis=0).max() if knees else 0.0
        degrees = not (peak <= np.pi and span > 0.3)
        what = "degrees" if degrees else "radians"
        warnings.append(f"the header does not say whether angles are degrees: {what} taken")
    elif not degrees and peak > 4.0:
        degrees = True
        warnings.append(f"the header says radians, but joints reach {peak:.0f}: read as degrees")
    if degrees:
        values[:, angles] *= np.pi / 180


# ------------------------------------------------------------------------------ ground reactions


@dataclass(frozen=True)
class _ForceGroup:
    name: str
    columns: tuple[tuple[str, ...], tuple[str, ...], tuple[str, ...]]  # force, point, torque


def _force_groups(names: Sequence[str]) -> list[_ForceGroup]:
    """Return the ground reactions among the column names, in the order of the file."""
    have = set(names)
    groups = []
    for name in names:
        if not re.search(r"(?:^|[^A-Za-z]|force|grf)[vV][xX]$", name, re.IGNORECASE):
            continue
        stem, v = name[:-2], name[-2]
        lower = name[-1] == "x"
        xyz = "xyz" if lower else "XYZ"

        def triple(stem: str, letters: str, xyz: str = xyz) -> tuple[str, ...]:
            """Return the three columns ``stem + letters + axis``, nothing unless all exist."""
            columns = tuple(f"{stem}{letters}{x}" for x in xyz)
            return columns if have.issuperset(columns) else ()

        force = triple(stem, v)
        if not force:
            continue
        point = triple(stem, "p") or triple(stem, "P")
        torque: tuple[str, ...] = triple(stem, "m") or triple(stem, "M") or triple(stem, "t")
        for old, new in (
            ("force", "torque"),
            ("force", "moment"),
            ("Force", "Torque"),
            ("Force", "Moment"),
        ):
            if old in stem and not torque:
                other = stem.replace(old, new)
                torque = triple(other, "") or triple(other, "m") or triple(other, "t")
        groups.append(_ForceGroup(stem.rstrip("_. ") or "force", (force, point, torque)))
    return groups


def side_of(name: str) -> str | None:
    """Return ``"r"`` or ``"l"`` where a plate's name says which foot it is, else None.

    Example:
        >>> side_of("ground_force_r"), side_of("calcn_l_force"), side_of("1_ground_force")
        ('r', 'l', None)
    """
    found = re.search(r"(?:^|[_. ])(r|l|right|left)(?:$|[_. ])", name, re.IGNORECASE)
    return found[1][0].lower() if found else None


def _plate(table: Table, group: _ForceGroup, warnings: list[str]) -> ForcePlate:
    """Return one ground reaction at its centre of pressure, in our axes."""
    n = len(table.time)

    def columns(names: tuple[str, ...], missing: float) -> np.ndarray:
        if not names:
            return np.full((n, 3), missing)
        return np.stack([table[name] for name in names], axis=1)

    f, p, t = (
        columns(names, missing)
        for names, missing in zip(group.columns, (0.0, np.nan, 0.0), strict=True)
    )
    size = np.nan_to_num(np.abs(f)).mean(axis=0)
    if size.max() > 0 and size[1] < 0.8 * size.max():
        warnings.append(
            f"{group.name}: the largest force is along {'xyz'[int(size.argmax())]}, not y; OpenSim "
            "files have y up"
        )
    loaded = np.abs(f[:, 1]) >= MIN_FORCE
    if loaded.any() and np.median(f[loaded, 1]) < 0:
        warnings.append(f"{group.name}: forces push down; turned to forces on the body")
        f, t = -f, -t
    loaded &= f[:, 1] >= MIN_FORCE
    far = np.abs(p[loaded & np.isfinite(p).all(axis=1)])
    if far.size and np.median(far.max(axis=1)) > 20.0:
        warnings.append(f"{group.name}: points are given in mm; read so, torques in N mm")
        p, t = p / 1000, t / 1000
    if not group.columns[1]:
        warnings.append(f"{group.name}: the file gives no point of application")
    elif loaded.any() and not np.any(p[loaded]) and not np.any(t[loaded]):
        warnings.append(f"{group.name}: point of application and torque are all zero: not known")
        p = np.full_like(p, np.nan)
    vertical = np.where(loaded, f[:, 1], np.nan)
    t = np.where(np.isfinite(t), t, 0.0)
    d_x, d_z = t[:, 2] / vertical, -t[:, 0] / vertical  # from p to the centre of pressure [m]
    cop = p + np.stack([d_x, np.zeros(n), d_z], axis=1)
    free = t[:, 1] - (np.nan_to_num(d_z) * f[:, 0] - np.nan_to_num(d_x) * f[:, 2])
    cop[~loaded] = np.nan
    return ForcePlate(
        name=group.name,
        time=table.time,
        force=f @ _OPENSIM_TO_OURS.T,
        cop=cop @ _OPENSIM_TO_OURS.T,
        free_moment=np.where(np.isfinite(free), free, 0.0),
        side=side_of(group.name),
    )


# ---------------------------------------------------------------------------------------- writing


def write_mot(
    what: Recording | Table | Sequence[ForcePlate],
    path: str | Path,
    *,
    in_degrees: bool = True,
) -> Path:
    """Write joint coordinates or ground reactions in OpenSim's format.

    Args:
        what: A table of coordinates [rad, m], plates, or a recording (its coordinates, or where it
            has none, its plates).
        path: The file, ``.mot`` or ``.sto``.
        in_degrees: Write angles in degrees; translations and ``…_beta`` are never scaled.

    Returns:
        The file.

    Raises:
        ParameterError: If there is nothing to write.
        FileError: If the file cannot be written.
    """
    if isinstance(what, Recording):
        if what.coordinates is None and not what.plates:
            raise ParameterError(
                f"{what.source} holds neither coordinates nor ground reactions to write as MOT"
            )
        what = what.coordinates if what.coordinates is not None else what.plates
    table = what if isinstance(what, Table) else _plates_table(what)
    values = table.values
    if isinstance(what, Table) and in_degrees:
        angle = np.array([_NO_ANGLE.search(name) is None for name in table.names], dtype=bool)
        values = np.where(angle[None, :], values * (180 / np.pi), values)
    lines = [
        Path(path).stem,
        "version=1",
        f"nRows={len(table.time)}",
        f"nColumns={len(table.names) + 1}",
        f"inDegrees={'yes' if in_degrees and isinstance(what, Table) else 'no'}",
        "endheader",
        "\t".join(["time", *(re.sub(r"\s+", "_", name) for name in table.names)]),
    ]
    row = "\t".join(["%.10g"] * (len(table.names) + 1))
    rows = np.concatenate([table.time[:, None], values], axis=1).tolist()
    lines += [row % tuple(one) for one in rows]
    write_text(path, "\n".join(lines) + "\n")
    return Path(path)


def _plates_table(plates: Sequence[ForcePlate]) -> Table:
    """Return plates as OpenSim's columns, on the clock of the first, in its axes."""
    if not plates:
        raise ParameterError("there are no plates to write")
    time = plates[0].time
    names: list[str] = []
    columns: list[np.ndarray] = []
    sides = [plate.side for plate in plates]
    for n, plate in enumerate(plates, start=1):
        known = plate.side if plate.side and sides.count(plate.side) == 1 else str(n)
        loaded = np.all(np.isfinite(plate.cop), axis=1)
        signals = np.concatenate(
            [
                np.nan_to_num(plate.force) @ _OPENSIM_TO_OURS,
                np.where(loaded[:, None], plate.cop, 0.0) @ _OPENSIM_TO_OURS,
            ],
            axis=1,
        )
        moment = np.nan_to_num(plate.free_moment)
        if len(plate.time) != len(time) or not np.allclose(plate.time, time):
            signals = np.stack(
                [np.interp(time, plate.time, s, left=0, right=0) for s in signals.T], axis=1
            )
            moment = np.interp(time, plate.time, moment, left=0, right=0)
        zero = np.zeros(len(time))
        names += [f"ground_force_{known}_{q}{x}" for q in "vp" for x in "xyz"]
        names += [f"ground_torque_{known}_{x}" for x in "xyz"]
        columns += [*signals.T, zero, moment, zero]
    return Table(tuple(names), time, np.stack(columns, axis=1))


def loaded(plate: ForcePlate) -> Bool[Array, " n"]:
    """Return the samples in which the plate carries enough load to have a centre of pressure."""
    return np.all(np.isfinite(plate.cop), axis=1)

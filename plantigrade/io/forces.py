"""Force tables of Motion Analysis (Cortex, EVaRT): ``NAME.forces`` beside ``NAME.trc``.

A header of four lines, a line of column names, then one row per analog sample::

    [Force Data]
    NumberOfForcePlates=2
    SampleRate=1000.000000
    NumberOfSamples=4000
    #Sample	FX1	FY1	FZ1	X1	Y1	Z1	MZ1	FX2	…

Forces [N] and the centre of pressure [mm] are in the axes of the laboratory, the moment about the
vertical at the centre of pressure is in N mm; one about the laboratory's origin is recognised
(:mod:`plantigrade.io.moment_reference`). The file does not say which axis is up: it is the one
with the largest force in stance. Values are zero while a plate is not loaded.
"""

import re
from functools import partial
from pathlib import Path

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import FileError
from plantigrade.io.axes import to_world
from plantigrade.io.moment_reference import reference
from plantigrade.io.opensim_forces import MIN_FORCE
from plantigrade.io.text import count_of, number, numbers, read_text
from plantigrade.motion.recording import ForcePlate, Recording
from plantigrade.notes import Info

MILLIMETRE = 1e-3
MIN_LOAD = 50.0  # [N] minimum force of a foot on the plate
_HEADER_LINES = 20  # maximum length of a header
_COLUMNS = ("FX", "FY", "FZ", "X", "Y", "Z", "MZ")


def read_forces(path: str | Path) -> Recording:
    """Read the ground reactions of a ``.forces`` file; its first sample is at 0 s.

    Returns:
        A recording with ``plates``: forces on the body, world axes.

    Raises:
        FileError: With the line, if the file does not follow the format.
    """
    lines = read_text(path).split("\n")
    broken = partial(FileError, path, remedy="export the forces again")
    at = next((i for i, line in enumerate(lines[:_HEADER_LINES]) if _is_names(line)), None)
    if at is None:
        problem = "no line names the columns FX1 FY1 FZ1 X1 Y1 Z1 MZ1"
        raise broken(problem, where="header")
    header = dict(
        (key.strip().lower(), value.strip())
        for key, _, value in (line.partition("=") for line in lines[:at])
    )
    rate = number(header.get("samplerate", ""), path, where="header", what="SampleRate")
    if not 1.0 <= rate <= 1e6:
        raise broken(f"SampleRate is {rate:g} Hz", where="header")
    names = ["#Sample", *(word.upper() for word in lines[at].split()[1:])]
    plates = _plates(names)
    if not plates:
        problem = "names no plate with all of FX FY FZ X Y Z MZ"
        raise broken(problem, where=f"line {at + 1}")
    warnings: list[str] = []
    rows = _whole_rows(lines[at + 1 :], len(names), warnings)
    if not rows:
        raise broken("has a header but no samples", where=f"line {at + 2}")
    table = numbers(rows, path, count=len(names), first_line=at + 2, delimiter=None, names=names)
    for what, found in (("plates", len(plates)), ("samples", len(table))):
        said = header.get({"plates": "numberofforceplates", "samples": "numberofsamples"}[what], "")
        if count_of(said) not in (None, found):
            warnings.append(f"the header announces {said} {what}, the file holds {found}")
    time = np.arange(len(table)) / rate
    samples = np.nan_to_num(np.stack([table[:, seven] for seven in plates.values()]))
    up = _up(samples[..., :3])
    forces = to_world(samples[..., :3], up)
    standing = forces[..., 2][np.abs(forces[..., 2]) >= MIN_LOAD]
    sign = -1.0 if standing.size and np.median(standing) < 0 else 1.0
    if sign < 0:
        warnings.append("the forces point down; they were reversed to act on the body")
    forces, points = sign * forces, MILLIMETRE * to_world(samples[..., 3:6], up)
    moments = np.zeros_like(forces)
    moments[..., 2] = sign * MILLIMETRE * samples[..., 6]
    f, p, t = (each.reshape(-1, 3) for each in (forces, points, moments))
    about = reference(f, p, t, f[:, 2] >= MIN_LOAD, 2)
    if about is not None:
        moments = about.about(forces, points, moments)
        warnings.append(Info(f"the moments are about {about}; they were converted to free moments"))
    found = [
        _plate(name, time, force, point, moment[:, 2])
        for name, force, point, moment in zip(plates, forces, points, moments, strict=True)
    ]
    return Recording(source=Path(path), plates=tuple(found), warnings=tuple(warnings))


def _is_names(line: str) -> bool:
    words = line.upper().split()
    return len(words) > 7 and words[0].startswith("#") and any(w.startswith("FX") for w in words)


def _plates(names: list[str]) -> dict[str, list[int]]:
    """Return the seven columns of each plate, by its number."""
    numbered = [match[1] for name in names if (match := re.fullmatch(r"FX(\w+)", name))]
    columns = {n: [f"{column}{n}" for column in _COLUMNS] for n in numbered}
    return {
        n: [names.index(c) for c in seven] for n, seven in columns.items() if {*seven} <= {*names}
    }


def _up(forces: Float[Array, "n_plates n_samples 3"]) -> str:
    """Return the vertical, the axis with the largest force."""
    size = np.abs(forces).mean(axis=(0, 1))
    return "+" + "xyz"[int(size.argmax())] if size.max() > 0 else "+z"


def _plate(
    name: str,
    time: Float[Array, " n"],
    force: Float[Array, "n 3"],
    point: Float[Array, "n 3"],
    moment: Float[Array, " n"],
) -> ForcePlate:
    """Return a plate from its force [N], centre of pressure [m] and free moment [N m]."""
    loaded = (force[:, 2] >= MIN_FORCE) & point[:, :2].any(axis=1)
    return ForcePlate(
        name=name,
        time=time,
        force=force,
        cop=np.where(loaded[:, None], point, np.nan),
        free_moment=np.where(loaded, moment, 0.0),
    )


def _whole_rows(rows: list[str], count: int, warnings: list[str]) -> list[str]:
    """Return the rows up to the last that is not empty, without one that was cut off."""
    while rows and not rows[-1].strip():
        rows.pop()
    if len(rows) > 1 and len(rows[-1].split()) < count:
        rows.pop()
        warnings.append("the last row is truncated and was left out")
    return rows

"""Norms given by the user: mean and standard deviation of gait curves, in a file or a record.

The file is a table with a header, separated by commas, semicolons or tabs::

    # 12 adults of our laboratory, 20–60 years, 1.3 m/s
    variable, percent, mean, sd
    knee_angle, 0, 5.2, 4.1
    knee_angle, 1, 6.3, 4.3
    …

``variable`` is a coordinate without its side (``pelvis_tilt``, ``knee_angle``,
``foot_progression``; degrees), its moment (``knee_angle_moment``; N m/kg, internal) or power
(``knee_angle_power``; W/kg), or ``ground_force_up`` or ``ground_force_forward`` (body weights),
with zero and sign as in this package; list and rotation of the pelvis are those of the right side.
``percent`` goes from 0 to 100 in any steps. The optional first line describes the people.
``plantigrade norms`` writes such a file from runs.
"""

import csv
from collections.abc import Mapping
from functools import partial
from pathlib import Path

import numpy as np

from plantigrade.analyze.norms import Population
from plantigrade.arrays import Array
from plantigrade.charts.labels import COORDINATES
from plantigrade.errors import FileError, did_you_mean
from plantigrade.io.text import read_text
from plantigrade.io.writing import csv_text
from plantigrade.motion.cycles import PERCENT
from plantigrade.side_names import without_side

HEADER = ("variable", "percent", "mean", "sd")
MAX_FILE_SIZE = 20e6  # [bytes]
_ANGLES = [name for name in COORDINATES if not name.startswith(("ground_force", "pelvis_t"))]
NAMES = (
    *(*_ANGLES, "pelvis_tilt", "ground_force_up", "ground_force_forward"),
    *(f"{name}{kind}" for name in _ANGLES for kind in ("_moment", "_power")),
)
"""Allowed names of variables."""


def own_population(curves: Mapping[str, tuple[Array, Array]], people: str) -> Population:
    """Return a population with given curves, at equidistant percentages of the cycle."""
    return Population("own norms", people or "your own norms", "", "", dict(curves))


def read_norms_file(path: str | Path) -> Population:
    """Return the norms of a file."""
    lines = read_text(path, MAX_FILE_SIZE).split("\n")
    comments = [line.lstrip("# ").strip() for line in lines if line.startswith("#")]
    rows = [(n, line) for n, line in enumerate(lines, 1) if line.strip() and line[0] != "#"]
    remedy = f"write a header '{', '.join(HEADER)}' and below it one row per percent"
    head = rows[0][1] if rows else ""
    delimiter = max(",;\t", key=head.count)
    names = [word.strip().lower() for word in head.split(delimiter)]
    if not set(HEADER) <= set(names):
        missing = ", ".join(sorted(set(HEADER) - set(names)))
        raise FileError(path, f"has no column {missing}", where="line 1", remedy=remedy)
    table: dict[str, list[tuple[float, float, float]]] = {}
    for n, line in rows[1:]:
        error_at = partial(FileError, path, where=f"line {n}")
        try:
            cells = next(csv.reader([line], delimiter=delimiter))
        except csv.Error as error:
            raise error_at(f"is not a row of a table ({error})", remedy=remedy) from None
        found = dict(zip(names, (cell.strip() for cell in cells), strict=False))
        variable = found.get("variable", "")
        if variable not in NAMES:
            raise error_at(f"there is no variable {variable[:40]!r}", remedy=_advice(variable))
        try:
            values = float(found["percent"]), float(found["mean"]), float(found["sd"])
        except (KeyError, ValueError):
            raise error_at("percent, mean and sd must be numbers", remedy=remedy) from None
        if not np.isfinite(values).all() or values[2] < 0:
            raise error_at("mean and sd must be finite and sd not negative", remedy=remedy)
        table.setdefault(variable, []).append(values)
    if not table:
        raise FileError(path, "holds no rows", remedy=remedy)
    curves = {name: _even(path, name, np.array(table[name])) for name in table}
    return own_population(curves, comments[0] if comments else Path(path).name)


def norms_csv(population: Population) -> str:
    """Return norms as the text of such a file."""
    rows = [
        [name, *row]
        for name, curves in population.curves.items()
        for row in zip(np.linspace(0.0, 100.0, len(curves[0])), *curves, strict=True)
    ]
    return f"# {' '.join(population.people.split())}\n" + csv_text(HEADER, rows)


def as_signals(population: Population) -> dict[str, Array]:
    """Return norms as signals of a record, so that its pages can be written again."""
    names = list(population.curves)
    mean, sd = (np.array([population.curves[name][k] for name in names]) for k in (0, 1))
    return {
        "norms.people": np.array([population.people]),
        "norms.names": np.array(names),
        "norms.mean": mean,
        "norms.sd": sd,
    }


def from_signals(signals: Mapping[str, Array]) -> Population | None:
    """Return the norms in the signals of a record; None if there are none."""
    if "norms.names" not in signals:
        return None
    rows = zip(signals["norms.mean"], signals["norms.sd"], strict=True)
    curves = dict(zip(map(str, signals["norms.names"]), rows, strict=True))
    return own_population(curves, str(signals["norms.people"][0]))


def _even(path: str | Path, name: str, rows: Array) -> tuple[Array, Array]:
    """Return mean and SD of a curve at every percent."""
    percent = rows[:, 0]
    if len(rows) < 2 or abs(percent[0]) > 0.5 or abs(percent[-1] - 100.0) > 0.5:
        problem = f"{name} goes from {percent[0]:g} to {percent[-1]:g} percent"
        raise FileError(path, problem, where=name, remedy="give each variable from 0 to 100")
    if not (np.diff(percent) > 0).all():
        problem = "percent does not increase from row to row"
        raise FileError(path, problem, where=name, remedy="give each variable once, in order")
    mean, sd = (np.interp(PERCENT, percent, rows[:, k]) for k in (1, 2))
    return mean, sd


def _advice(variable: str) -> str:
    plain = without_side(variable)
    if plain in NAMES:
        return f"write {plain}: norms apply to both sides, over the cycle of the right foot"
    hint = did_you_mean(variable, NAMES)
    return f"{hint}names are those of coordinates, as knee_angle, hip_flexion_moment"

"""Curves of a run as comma-separated values: over time, or over the gait cycle of each side.

Column names end in their unit, as the keys of ``metrics.json`` do:

==================================  ========================================================
``knee_angle_r_deg``                coordinate or other angle, signs as in the conventions
``pelvis_tx_m``                     place of the pelvis, OpenSim's axes
``knee_angle_moment_r_nm_kg``       internal moment per body mass
``knee_angle_power_r_w_kg``         power per body mass
``ground_force_up_r_bw``            ground reaction in body weights; also ``forward``,
                                    ``sideways`` (to the left)
``centre_of_pressure_up_r_m``       where it acts, world axes
==================================  ========================================================

Over the cycle the side is a column, so its letter is missing: ``knee_angle_deg``. An unknown
value is an empty field.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from plantigrade.analyze.curves import coordinates_of, gait_curves, joint_loads, known
from plantigrade.analyze.foot_progression import foot_progression
from plantigrade.analyze.statistics import mean_sd
from plantigrade.arrays import Array
from plantigrade.constants import SIDES
from plantigrade.errors import FileError, ParameterError
from plantigrade.io.writing import write_text
from plantigrade.models.mirror import mirror_sign
from plantigrade.motion.cycles import PERCENT, Cycle
from plantigrade.motion.views import TRANSLATIONS
from plantigrade.record import Record, Run
from plantigrade.side_names import split_side
from plantigrade.spatial.conventions import PELVIS

OVER = ("time", "cycles", "mean")
"""Meaning of a row: an instant, a percent of one gait cycle, a percent of the mean gait cycle."""

AXES = {"forward": "forward", "sideways": "left", "up": "up"}
"""Name of an axis in a column → its name among the curves over the cycle."""


def write_table(
    run: Run, path: Any, over: str = "time", estimated: bool = False
) -> tuple[str, ...]:
    """Write the curves of a run as comma-separated values.

    Args:
        over: One of :data:`OVER`.
        estimated: Whether forces, moments and powers count where forces were estimated off or
            without plates; otherwise they are empty there.
    """
    if over not in OVER:
        raise ParameterError(f"{over=} must be one of {', '.join(OVER)}")
    if over == "time":
        text = table_text([time_columns(run, estimated=estimated)])
    else:
        text = cycle_table(run, mean=over == "mean", estimated=estimated)
        if not text:
            problem = "has no curves over the gait cycle: this motion shows no complete gait cycle"
            raise FileError(path, problem, remedy="export its curves over time (--over time)")
    write_text(path, text)
    return ()


def time_columns(run: Run, *, estimated: bool = False) -> dict[str, Array]:
    """Return the curves over time by column, all at the instants of the motion."""
    record = run.record
    columns = {"time_s": record.motion.time} | _angles(record)
    forces, time = run.with_forces, record.motion.time
    for name, values in _loads(forces, estimated=estimated).items():
        if forces is not record:
            values = np.interp(time, forces.motion.time, values, left=np.nan, right=np.nan)
        columns[name] = values
    return columns


def _angles(record: Record) -> dict[str, Array]:
    table = coordinates_of(record)
    return {
        f"{name}_m" if name in TRANSLATIONS else f"{name}_deg": (
            column if name in TRANSLATIONS else np.rad2deg(column)
        )
        for name, column in zip(table.names, table.values.T, strict=True)
    }


def _loads(record: Record, *, estimated: bool) -> dict[str, Array]:
    """Return moments, powers, ground reactions and centres of pressure over time, by column."""
    found: dict[str, Array] = {}
    moments, powers = joint_loads(record, record.human.coordinates, estimated=estimated)
    for name, moment in moments.items():
        found[_load(name, "moment_nm_kg")] = moment
        found[_load(name, "power_w_kg")] = powers[name]
    if record.has_forces:
        for side in SIDES:
            foot, there = record.foot(side), known(record, side, estimated=estimated)
            for k, axis in enumerate(("forward", "sideways", "up")):
                found[f"ground_force_{axis}_{side}_bw"] = there * foot.force[:, k] / record.weight
                place = there * foot.centre_of_pressure[:, k]
                found[f"centre_of_pressure_{axis}_{side}_m"] = place
    return found


def _load(coordinate: str, ending: str) -> str:
    """Return the column of a moment or power.

    Example:
        >>> _load("knee_angle_r", "moment_nm_kg"), _load("lumbar_bending", "power_w_kg")
        ('knee_angle_moment_r_nm_kg', 'lumbar_bending_power_w_kg')
    """
    stem, side = split_side(coordinate)
    what, unit = ending.split("_", 1)
    return f"{stem}_{what}_{side}_{unit}" if side else f"{stem}_{what}_{unit}"


def cycle_table(run: Run, *, mean: bool = False, estimated: bool = False) -> str:
    """Return the curves over the gait cycles of both sides; empty where there are none.

    Each row is a percent of a cycle of one side. The first columns are ``side``, ``cycle`` and
    ``percent``, then the events: ``start_s`` and ``duration_s`` of the cycle, and ``toe_off_pct``,
    ``opposite_toe_off_pct`` and ``opposite_heel_strike_pct``. Of pelvis, trunk and head those
    coordinates that change sign in a mirror do so on the left, so that left and right read alike.

    Args:
        mean: Mean over the cycles of a side, after each column its standard deviation with
            ``_sd`` before the unit; ``cycles_count`` takes the place of ``cycle``.
        estimated: Whether estimated forces count.
    """
    parts = [
        _mean_part(*part) if mean else _every_part(*part)
        for side in SIDES
        if (part := side_curves(run, side, estimated=estimated, every=not mean))[1]
    ]
    return table_text(parts) if parts else ""


def side_curves(
    run: Run, side: str, *, estimated: bool = False, every: bool = True
) -> tuple[str, tuple[Cycle, ...], dict[str, Array]]:
    """Return a side, its cycles, and its curves by column, one row per cycle.

    Args:
        side: ``"r"`` or ``"l"``.
        estimated: Whether estimated forces count.
        every: Whether cycles stay in curves of which they show less than half.
    """
    record, forces = run.record, run.with_forces
    curves = gait_curves(record, estimated=estimated, keep_incomplete=every, side=side)
    loaded = curves
    if forces is not record:
        loaded = gait_curves(forces, estimated=estimated, keep_incomplete=every, side=side)
    mine = tuple(cycle for cycle in curves.cycles if cycle.side == side)
    found: dict[str, Array] = {}

    def put(table: Mapping[str, Array], ending: str, *, names: Mapping[str, str] | None = None):
        for name, rows in table.items():
            stem, of = split_side(name)
            if of in ("", side) and len(rows):
                sign = mirror_sign(name) if side == "l" else 1.0
                found[f"{names[stem] if names else stem}_{ending}"] = sign * rows

    ahead = [*PELVIS[:3], *(n for n in curves.angles if n not in PELVIS)]
    put({name: curves.angles[name] for name in ahead if name in curves.angles}, "deg")
    if mine:
        put(foot_progression(record, side=side), "deg")
    put(loaded.moments, "moment_nm_kg")
    put(loaded.powers, "power_w_kg")
    put(loaded.forces, "bw", names={of: f"ground_force_{axis}" for axis, of in AXES.items()})
    return side, mine, found


def _every_part(side: str, cycles: Sequence[Cycle], curves: dict[str, Array]) -> dict[str, Any]:
    count, n = len(cycles), len(PERCENT)
    part: dict[str, Any] = {
        "side": [side] * (count * n),
        "cycle": np.repeat(np.arange(1, count + 1), n),
        "percent": np.tile(PERCENT, count),
    }
    part |= {name: np.repeat(values, n) for name, values in events_of(cycles).items()}
    missing = np.full(count * n, np.nan)
    for name, rows in curves.items():  # of forces on another clock there may be fewer cycles
        part[name] = rows.ravel() if len(rows) == count else missing
    return part


def _mean_part(side: str, cycles: Sequence[Cycle], curves: dict[str, Array]) -> dict[str, Any]:
    n = len(PERCENT)
    part: dict[str, Any] = {"side": [side] * n, "cycles_count": np.full(n, len(cycles))}
    part["percent"] = PERCENT
    for name, values in events_of(cycles).items():
        if name != "start_s":
            part[name] = np.full(n, mean_sd(values[:, None])[0][0])
    for name, rows in curves.items():
        part[name], deviation = mean_sd(rows)
        part[_deviation(name)] = deviation if len(rows) > 1 else np.full(n, np.nan)
    return part


def events_of(cycles: Sequence[Cycle]) -> dict[str, Array]:
    """Return start, duration and events of cycles by column; NaN where one was not seen."""

    def percent(cycle: Cycle, instant: float | None) -> float:
        return np.nan if instant is None else cycle.percent(instant)

    events = ("toe_off", "opposite_toe_off", "opposite_heel_strike")
    return {
        "start_s": np.array([c.start for c in cycles]),
        "duration_s": np.array([c.duration for c in cycles]),
        **{f"{e}_pct": np.array([percent(c, getattr(c, e)) for c in cycles]) for e in events},
    }


UNITS = {"nm_kg": "N m/kg", "w_kg": "W/kg", "deg": "deg", "bw": "BW"}
"""Ending of a column of a curve → its unit."""
EVENTS = {
    "start_s": ("start", "s"),
    "duration_s": ("duration", "s"),
    "toe_off_pct": ("toe_off", "%"),
    "opposite_toe_off_pct": ("opposite_toe_off", "%"),
    "opposite_heel_strike_pct": ("opposite_heel_strike", "%"),
}
"""Column of an event of a cycle → its name and unit."""


def _deviation(column: str) -> str:
    """Return the column of the standard deviation.

    Example:
        >>> _deviation("knee_angle_moment_nm_kg"), _deviation("knee_angle_deg")
        ('knee_angle_moment_sd_nm_kg', 'knee_angle_sd_deg')
    """
    unit = next(unit for unit in UNITS if column.endswith(f"_{unit}"))
    return f"{column.removesuffix(f'_{unit}')}_sd_{unit}"


def table_text(parts: Sequence[Mapping[str, Any]]) -> str:
    """Return tables below each other as comma-separated values: seven digits, nothing for NaN.

    Args:
        parts: Columns by name; a part may lack some.
    """
    names = list(dict.fromkeys(name for part in parts for name in part))
    rows = (row for part in parts for row in _rows(part, names))
    return "\n".join([",".join(names), *rows]) + "\n"


def _rows(part: Mapping[str, Any], names: Sequence[str]) -> Iterator[str]:
    """Yield the rows of a part."""
    missing = ["nan"] * len(next(iter(part.values())))
    columns = [part.get(name, missing) for name in names]
    written = [[c if isinstance(c, str) else f"{c:.7g}" for c in column] for column in columns]
    for row in zip(*written, strict=True):
        yield ",".join("" if cell == "nan" else cell for cell in row)

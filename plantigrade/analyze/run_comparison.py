"""Comparison of two or more gaits: cycles of every curve, their differences, and figures."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from plantigrade.analyze.clinical import clinical_angles
from plantigrade.analyze.curve_difference import CurveDifference, curve_difference
from plantigrade.analyze.curves import LOADED_JOINTS, gait_curves
from plantigrade.analyze.gait_profile import ANGLES
from plantigrade.analyze.norms import unit_of
from plantigrade.arrays import Array
from plantigrade.charts.labels import without_side
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.motion.cycles import PERCENT
from plantigrade.record import Run

TRUNK = ("lumbar_extension", "lumbar_bending", "lumbar_rotation")
CURVES = (
    *(*ANGLES, "subtalar_angle", "mtp_angle", *TRUNK),
    *(f"{name}_moment" for name in LOADED_JOINTS),
    *("ground_force_up", "ground_force_forward"),
)
"""Names of the compared curves, without side."""
SYNTHESISED_KINDS = ("synthesize",)
"""Kinds of runs whose strides have no variability, because they are synthesised."""
MEASURES = (
    *(
        "walking_speed_m_s",
        "running_speed_m_s",
        "cadence_steps_min",
        "step_width_m",
        "double_support_pct",
    ),
    *(f"{n}_{s}_{u}" for n, u in (("step_length", "m"), ("stance", "pct")) for s in SIDES),
    *("gps_deg", "gps_r_deg", "gps_l_deg", "marker_rms_mean_mm"),
)
"""Figures that are compared."""
SUFFIX = {"deg": "deg", "N m/kg": "nm_kg", "body weight": "bw"}


@dataclass(frozen=True)
class Gait:
    """One of the compared gaits."""

    name: str  #: Name of the gait
    curves: Mapping[str, Array] = field(repr=False)  #: Curve → one row per cycle
    foot_off: Mapping[str, float]  #: Side → foot off [% of the cycle]
    exact: bool = False  #: Whether its strides have no variability, because it is synthesised


@dataclass(frozen=True, eq=False)
class RunComparison:
    """Comparison of gaits, each later one with the first.

    Attributes:
        gaits: The gaits, in order.
        runs: Their runs; a single one if its sides are compared.
    """

    gaits: tuple[Gait, ...]
    runs: tuple[Run, ...] = field(repr=False)

    @property
    def sides(self) -> bool:
        """Whether the sides of one run are compared."""
        return len(self.runs) == 1

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the curves that all gaits have."""
        every = [f"{n}{s}" for n in CURVES for s in (("",) if self.sides else ("", "_r", "_l"))]
        return tuple(n for n in every if all(n in gait.curves for gait in self.gaits))

    @cached_property
    def differences(self) -> dict[str, dict[str, CurveDifference]]:
        """Name of each later gait → curve → its difference from the first."""
        first = self.gaits[0]
        return {
            gait.name: {
                name: curve_difference(
                    first.curves[name], gait.curves[name], exact=(first.exact, gait.exact)
                )
                for name in self.names
            }
            for gait in self.gaits[1:]
        }

    def metrics(self) -> dict[str, Any]:
        """Return figures of each later gait relative to the first, and measures of the runs."""
        found: dict[str, Any] = {"status": "ok", "compared_count": len(self.gaits)}
        found["gaits"] = [gait.name for gait in self.gaits]
        found["differences"] = {}
        for gait, table in self.differences.items():
            flat: dict[str, float] = {}
            for name, each in table.items():
                unit = SUFFIX[unit_of(without_side(name))]
                flat[f"difference_rms_{name}_{unit}"] = each.rms
                flat[f"difference_max_{name}_{unit}"] = each.largest
                if each.half is not None:
                    flat[f"difference_beyond_{name}_pct"] = 100.0 * float(np.mean(each.beyond))
            found["differences"][gait] = flat
        if not self.sides:
            found["measures"] = {
                gait.name: {k: run.figures[k] for k in MEASURES if k in run.figures}
                for gait, run in zip(self.gaits, self.runs, strict=True)
            }
        return found

    def rows(self) -> tuple[list[str], list[list[Any]]]:
        """Return every curve as column names and rows of values."""
        later = list(self.differences)
        header = ["variable", "percent"]
        header += [f"{what} {gait.name}" for gait in self.gaits for what in ("mean", "sd")]
        header += [f"{what} {name}" for name in later for what in ("difference", "low", "high")]
        rows = []
        for name in self.names:
            columns = [PERCENT]
            for gait in self.gaits:
                known = gait.curves[name]
                columns += [np.nanmean(known, axis=0)]
                columns += [known.std(axis=0, ddof=1) if len(known) > 1 else PERCENT * np.nan]
            for other in later:
                each = self.differences[other][name]
                half = PERCENT * np.nan if each.half is None else each.half
                columns += [each.mean, each.mean - half, each.mean + half]
            rows += [[name, *map(float, values)] for values in zip(*columns, strict=True)]
        return header, rows


def compare_runs(runs: Sequence[Run], names: Sequence[str]) -> RunComparison:
    """Return the comparison of runs over their gait cycles, or of the sides of a single one.

    Args:
        runs: One or more runs.
        names: Names of the runs, all different.

    Raises:
        ParameterError: If there is none, or one has no complete gait cycle.
    """
    if not runs:
        raise ParameterError(
            "nothing to compare: give two runs, or one to compare its right and left side"
        )
    gaits = [gait_of(run, name) for run, name in zip(runs, names, strict=True)]
    if len(gaits) == 1:
        gaits = list(sides_of(gaits[0]))
    return RunComparison(tuple(gaits), tuple(runs))


def gait_of(run: Run, name: str) -> Gait:
    """Return the gait of a run.

    Raises:
        ParameterError: If it has no complete gait cycle.
    """
    curves, loaded = gait_curves(run.record), gait_curves(run.with_forces)
    if not curves.cycles:
        raise ParameterError(
            f"{name} shows no complete gait cycle; runs are compared over the gait cycle, so give "
            "walks"
        )
    every: dict[str, Array] = dict(clinical_angles(run.record, curves))
    every |= {n: curves.angles[n] for n in TRUNK if n in curves.angles}
    every |= {n: rows for n, rows in loaded.loads().items() if "_power_" not in n}
    known = {n: rows for n, rows in every.items() if len(rows) and np.isfinite(rows).any(0).all()}
    known = {
        n: v for n, v in known.items() if n[:-2] in ANGLES or np.nanmax(v) - np.nanmin(v) > 1e-6
    }
    offs = {side: run.figures.get(f"stance_{side}_pct") for side in SIDES}
    foot_off = {side: float(value) for side, value in offs.items() if isinstance(value, float)}
    return Gait(name, known, foot_off, run.kind in SYNTHESISED_KINDS)


def sides_of(gait: Gait) -> tuple[Gait, Gait]:
    """Return right and left of a gait, as two gaits whose curves have no side.

    Raises:
        ParameterError: If a foot has no complete gait cycle.
    """
    found = []
    for side, name in zip(SIDES, ("right", "left"), strict=True):
        mine = {n[:-2]: rows for n, rows in gait.curves.items() if n.endswith(f"_{side}")}
        if not mine:
            raise ParameterError(
                f"{gait.name} shows no complete gait cycle of the {name} foot: its sides cannot be "
                "compared; name a second run"
            )
        offs = {side: gait.foot_off[side]} if side in gait.foot_off else {}
        found.append(Gait(name, mine, offs, gait.exact))
    right, left = found
    return right, left

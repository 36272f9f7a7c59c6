"""Comparison of two or more gaits: cycles of every curve, their differences, and figures."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from plantigrade.analyze.curve_difference import (
    CurveDifference,
    FigureDifference,
    curve_difference,
    figure_differences,
)
from plantigrade.analyze.norms import unit_of
from plantigrade.analyze.pooled_gait import (
    CURVES,
    Affected,
    ComparedGait,
    gait_of,
    pooled,
    sides_of,
)
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.motion.cycles import PERCENT
from plantigrade.record import Run
from plantigrade.side_names import without_side

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


@dataclass(frozen=True, eq=False)
class RunComparison:
    """Comparison of gaits, each later one with the first."""

    #: The gaits, in order; if the sides of one are compared, the affected one is second
    gaits: tuple[ComparedGait, ...]
    affected: Affected | None = None  #: The affected side, if one was named
    omitted: tuple[str, ...] = ()  #: Names of trials without a complete gait cycle

    @property
    def sides(self) -> bool:
        """Whether the sides of one gait are compared."""
        return bool(self.gaits[0].side)

    @property
    def runs(self) -> tuple[Run, ...]:
        """All runs, in order."""
        return tuple(run for gait in self.gaits[: 1 if self.sides else None] for run in gait.runs)

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

    @cached_property
    def figures(self) -> dict[str, tuple[FigureDifference, ...]]:
        """Name of each later gait → range, peak and time of the peak of every curve."""
        first = self.gaits[0]
        return {gait.name: figure_differences(first, gait, self.names) for gait in self.gaits[1:]}

    def metrics(self) -> dict[str, Any]:
        """Return figures of each later gait relative to the first, and measures of the runs."""
        found: dict[str, Any] = {"status": "ok", "compared_count": len(self.gaits)}
        found["gaits"] = [gait.name for gait in self.gaits]
        found["trials_count"] = len(self.runs)
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
                gait.name: {k: x for k in MEASURES if (x := gait.figure(k)) is not None}
                for gait in self.gaits
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

    def figure_rows(self) -> tuple[list[str], list[list[Any]]]:
        """Return range, peak and time of the peak as column names and rows of values."""
        first = self.gaits[0].name
        header = ["gait", "compared_with", "variable", "figure", "unit"]
        header += ["first", "second", "difference", "p", "test"]
        return header, [
            [name, first, d.curve, d.figure, d.unit, d.first, d.second, d.difference, d.p, d.test]
            for name, each in self.figures.items()
            for d in each
        ]


def compare_runs(
    groups: Sequence[Run | Sequence[Run]], names: Sequence[str], *, affected: Affected | None = None
) -> RunComparison:
    """Return the comparison of gaits over the gait cycle, or of the sides of a single one.

    Args:
        groups: Runs, or trials of one person that are pooled.
        names: Names of the gaits, all different.
        affected: Affected side of a single gait.

    Raises:
        ParameterError: If there is none, one has no complete gait cycle, pooled trials are of
            different people, or an affected side is named for several gaits.
    """
    if not groups:
        raise ParameterError(
            "nothing to compare: give two runs, or one to compare its right and left side"
        )
    gaits = []
    for group, name in zip(groups, names, strict=True):
        trials = [group] if isinstance(group, Run) else list(group)
        each = [gait_of(run, name if len(trials) == 1 else run.name or name) for run in trials]
        gaits.append(replace(each[0], name=name) if len(each) == 1 else pooled(each, name))
    if len(gaits) == 1:
        return RunComparison(sides_of(gaits[0], affected), affected)
    if affected is not None:
        raise ParameterError(f"{affected=} needs one gait, whose sides are compared")
    return RunComparison(tuple(gaits))

"""A gait as a gait laboratory reports it: angles of both sides, scores, symmetry, and against whom.

The pelvis has no side: its angles over the right foot's cycles are the right side's, those over the
left foot's, with list and rotation turned round, the left side's, so that both stand beside the
same norm.
"""

import contextlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plantigrade.analyze import norms
from plantigrade.analyze.curves import GaitCurves, gait_curves, pelvis_cycles
from plantigrade.analyze.foot_progression import foot_progression
from plantigrade.analyze.gait_profile import gait_profile
from plantigrade.analyze.own_norms import from_signals
from plantigrade.analyze.symmetry import symmetry_figures
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.record import Record

LEG_LENGTHS = ("thigh", "shank", "ankle_height")


@dataclass(frozen=True)
class Compared:
    """With whom somebody is compared, and why."""

    population: norms.Population  #: Whose curves
    speed_class: str  #: Class of speed of children's curves
    reason: str  #: Why they were chosen


def compared_with(record: Record, figures: Mapping[str, Any]) -> Compared:
    """Return with whom the person of a record is compared.

    Args:
        record: The record; norms of the user's own are among its signals.
        figures: Those of its run: ``age_years``, ``height_estimated``, ``walking_speed_m_s``.
    """
    age = _number(figures, "age_years")
    height = None if figures.get("height_estimated") else record.human.height
    speed, lengths = _number(figures, "walking_speed_m_s"), record.human.dimensions
    leg = sum(float(getattr(lengths, name)) for name in LEG_LENGTHS)
    kind = "free" if speed is None else norms.speed_class(speed, leg)
    own = from_signals(record.signals)
    if own is not None:
        return Compared(own, kind, "given with --norms")
    return Compared(norms.population(age, height), kind, norms.reason(age, height))


def clinical_angles(
    record: Record, curves: GaitCurves | None = None
) -> dict[str, Float[Array, "n_cycles n_percent"]]:
    """Return every angle of a side over its gait cycles [deg], by name and side.

    Args:
        record: The record.
        curves: Its curves over the cycle, where they are known already.
    """
    curves = curves or gait_curves(record)
    found = {n: rows for n, rows in curves.angles.items() if n[-2:] in ("_r", "_l")}
    for side in SIDES:
        mine = [cycle for cycle in curves.cycles if cycle.side == side]
        for name, rows in pelvis_cycles(record, mine).items():
            mirrored = side == "l" and name in norms.MIRRORED
            found[f"{name}_{side}"] = -rows if mirrored else rows
    return found | foot_progression(record)


def clinical_figures(record: Record, figures: Mapping[str, Any]) -> dict[str, Any]:
    """Return scores, symmetry and foot progression of a gait; nothing for other motions.

    A run has scores only against norms of the user's own.

    Args:
        record: The record.
        figures: What is known of it already, as in ``metrics.json``.
    """
    curves = gait_curves(record)
    if not curves.cycles:
        return {}
    angles, who = clinical_angles(record, curves), compared_with(record, figures)
    found: dict[str, Any] = {}
    for side in SIDES:
        rows = angles.get(f"foot_progression_{side}", np.empty((0, 1)))
        stance = _number(figures, f"stance_{side}_pct")
        if np.isfinite(rows).any() and stance is not None:
            known = rows[:, curves.percent <= stance]
            found[f"foot_progression_stance_{side}_deg"] = float(np.nanmean(known))
    found |= symmetry_figures(figures, angles)
    if figures.get("running") and not who.population.own:  # norms of walking are no measure of it
        return found
    found |= {"norm_population": who.population.name, "norm_reason": who.reason}
    with contextlib.suppress(ParameterError):  # an angle is missing: a foot has no whole cycle
        profile = gait_profile(curves.percent, angles, who.population, who.speed_class)
        found |= profile.metrics()
    return found


def _number(figures: Mapping[str, Any], key: str) -> float | None:
    value = figures.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        return None
    return float(value) if np.isfinite(float(value)) else None

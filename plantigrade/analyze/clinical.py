"""Clinical gait figures: angles of both sides, scores, symmetry, and the choice of norms.

Angles of the pelvis over the cycles of the right foot are those of the right side; over the cycles
of the left foot, with list and rotation reversed, those of the left side, so that one norm applies
to both.
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
class NormChoice:
    """Norms for a person, and the reason for their choice."""

    population: norms.Population  #: Population of the norms
    speed_class: str  #: Speed class of children's norms
    reason: str  #: Reason of the choice


def norms_for(record: Record, figures: Mapping[str, Any]) -> NormChoice:
    """Return the norms for the person of a record.

    Args:
        record: The record, whose signals may contain norms of the user.
        figures: Figures of its run: ``age_years``, ``height_estimated``, ``walking_speed_m_s``.
    """
    age = number_of(figures, "age_years")
    height = None if figures.get("height_estimated") else record.human.height
    speed, lengths = number_of(figures, "walking_speed_m_s"), record.human.dimensions
    leg = sum(float(getattr(lengths, name)) for name in LEG_LENGTHS)
    speed_class = "free" if speed is None else norms.speed_class(speed, leg)
    own = from_signals(record.signals)
    if own is not None:
        return NormChoice(own, speed_class, "given with --norms")
    return NormChoice(norms.population(age, height), speed_class, norms.reason(age, height))


def clinical_angles(
    record: Record, curves: GaitCurves | None = None
) -> dict[str, Float[Array, "n_cycles n_percent"]]:
    """Return every angle over the gait cycles of its side [deg], by name and side."""
    curves = curves or gait_curves(record)
    found = {n: rows for n, rows in curves.angles.items() if n[-2:] in ("_r", "_l")}
    for side in SIDES:
        mine = [cycle for cycle in curves.cycles if cycle.side == side]
        for name, rows in pelvis_cycles(record, mine).items():
            mirrored = side == "l" and name in norms.MIRRORED
            found[f"{name}_{side}"] = -rows if mirrored else rows
    return found | foot_progression(record)


def known_curves(
    record: Record, curves: GaitCurves, loaded: GaitCurves | None = None
) -> dict[str, Float[Array, "n_cycles n_percent"]]:
    """Return angles of both sides and the trunk, and loads, that are known at every percent.

    Args:
        record: The record.
        curves: Its curves.
        loaded: Curves of the record whose forces count, where it is another one.
    """
    rows = clinical_angles(record, curves)
    rows |= {n: values for n, values in curves.angles.items() if n.startswith("lumbar")}
    rows |= (loaded or curves).loads()
    return {n: v for n, v in rows.items() if len(v) and np.isfinite(v).any(axis=0).all()}


def clinical_figures(
    record: Record, figures: Mapping[str, Any], curves: GaitCurves | None = None
) -> dict[str, Any]:
    """Return scores, symmetry and foot progression of a gait; nothing for other motions.

    Running, and walking backward or sideways, have scores only with norms of the user.

    Args:
        record: The record.
        figures: Known figures, as in ``metrics.json``.
        curves: Its curves, where they are known already.
    """
    curves = curves or gait_curves(record)
    if not curves.cycles:
        return {}
    angles, choice = clinical_angles(record, curves), norms_for(record, figures)
    found: dict[str, Any] = {}
    for side in SIDES:
        rows = angles.get(f"foot_progression_{side}", np.empty((0, 1)))
        stance = number_of(figures, f"stance_{side}_pct")
        if np.isfinite(rows).any() and stance is not None:
            known = rows[:, curves.percent <= stance]
            found[f"foot_progression_stance_{side}_deg"] = float(np.nanmean(known))
    found |= symmetry_figures(figures, angles)
    if not usual_walk(figures) and not choice.population.own:  # norms of walking do not apply
        return found
    found |= {"norm_population": choice.population.name, "norm_reason": choice.reason}
    with contextlib.suppress(ParameterError):  # an angle is missing if a foot has no complete cycle
        profile = gait_profile(curves.percent, angles, choice.population, choice.speed_class)
        found |= profile.metrics()
    return found


def usual_walk(figures: Mapping[str, Any]) -> bool:
    """Return whether a gait is one that there are norms of: walking forward.

    Args:
        figures: Those of :func:`~plantigrade.analyze.movement.movement_figures`: ``running``, and
            ``walking_direction`` where it is not forward.
    """
    return not figures.get("running") and "walking_direction" not in figures


def number_of(figures: Mapping[str, Any], key: str) -> float | None:
    """Return a figure of a run; None if it is unknown."""
    value = figures.get(key)
    if isinstance(value, bool) or not isinstance(value, int | float | np.number):
        return None
    return float(value) if np.isfinite(float(value)) else None

r"""Gait Profile Score and Movement Analysis Profile [Baker2009]_.

The profile holds, for each of nine angles of a side, the gait variable score: the root mean square
difference over the gait cycle between a person's mean curve and the mean of a population. The
score is the root mean square of the profile: of the nine of one side, or of fifteen of both, the
pelvis counted once (by the right foot).

A constant offset of convention between two body models is part of every difference, as in the
original; so is a difference of speed. Beside each value stands the population's own standard
deviation, root mean square over the cycle: that is the root mean square of the same difference over
the population's people, so what is usual for somebody of it. The smallest difference of the score
that matters clinically is :data:`SMALLEST` [Baker2012]_.

References:
    [Baker2009]_, [Baker2012]_.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plantigrade.analyze import norms
from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError

PELVIS = ("pelvis_tilt", "pelvis_list", "pelvis_rotation")
LEG = (
    *("hip_flexion", "hip_adduction", "hip_rotation"),
    *("knee_angle", "ankle_angle", "foot_progression"),
)
ANGLES = (*PELVIS, *LEG)
"""The nine angles, in their order."""

SMALLEST = 1.6
"""Smallest clinically important difference of the score [deg]; of children [Baker2012]_."""


@dataclass(frozen=True)
class GaitProfile:
    """How far a gait is from the mean of a population [deg]."""

    #: Angle with its side → RMS difference from the mean of the population
    difference: Mapping[str, float]
    #: Angle without side → standard deviation in the population, RMS over the cycle
    usual: Mapping[str, float]

    def score(self, side: str = "") -> float:
        """Return the Gait Profile Score of a side, or of both where ``side`` is empty."""
        if side:
            return _rms([self.difference[f"{name}_{side}"] for name in ANGLES])
        own = [f"{name}_r" for name in PELVIS] + [f"{name}_{s}" for s in SIDES for name in LEG]
        return _rms([self.difference[name] for name in own])

    @property
    def usual_score(self) -> float:
        """Root mean square of the score of a side over the people of the population."""
        return _rms([self.usual[name] for name in ANGLES])

    def metrics(self) -> dict[str, float]:
        """Return score (``gps``) and gait variable scores (``gvs``) under flat keys [deg]."""
        found = {"gps_deg": self.score()}
        found |= {f"gps_{side}_deg": self.score(side) for side in SIDES}
        found["gps_reference_deg"] = self.usual_score
        for name in ANGLES:
            found |= {f"gvs_{name}_{s}_deg": self.difference[f"{name}_{s}"] for s in SIDES}
            found[f"gvs_{name}_reference_deg"] = self.usual[name]
        return found


def gait_profile(
    percent: Float[Array, " n_percent"],
    angles: Mapping[str, Float[Array, "n_cycles n_percent"]],
    population: norms.Population = norms.ADULTS,
    speed_class: str = "free",
) -> GaitProfile:
    """Return how far a gait is from the mean of a population with all nine angles.

    Args:
        percent: Percent of the gait cycle.
        angles: Cycles of every angle [deg], by name and side, those of the pelvis too
            (:func:`plantigrade.analyze.clinical.clinical_angles`): as the right side's.
        population: Whom it is compared with.
        speed_class: Of children, see :func:`plantigrade.analyze.norms.speed_class`.

    Raises:
        ParameterError: If an angle is missing, of the person or of the population.
    """
    wanted = [f"{name}_{side}" for side in SIDES for name in ANGLES]
    published = norms.names(population)
    missing = [n for n in wanted if not np.isfinite(angles.get(n, ())).any()]
    missing += [n for n in ANGLES if n not in published]
    if missing:
        raise ParameterError(f"a gait profile needs {', '.join(missing)} as well")
    difference, usual = {}, {}
    for name in ANGLES:
        band = norms.norm(name, speed_class, population=population)
        mean = np.interp(percent, band.percent, band.mean)
        for side in SIDES:
            full = f"{name}_{side}"
            difference[full] = _rms(np.nanmean(angles[full], axis=0) - mean)
        usual[name] = _rms(band.sd)
    return GaitProfile(difference, usual)


def _rms(values) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))

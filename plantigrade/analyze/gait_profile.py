r"""Gait Profile Score and Movement Analysis Profile [Baker2009]_.

The profile consists of the gait variable scores of nine angles per side: the root mean square
difference over the gait cycle between a person's mean curve and the mean of a population. The
score is the root mean square of the profile: of the nine of one side, or of fifteen of both, the
pelvis counted once (by the right foot).

Constant offsets between the conventions of two body models are part of every difference, as in the
original, and so are differences of speed. Each value is shown with the standard deviation of the
population, root mean square over the cycle, which is the usual value of its people. The minimal
clinically important difference of the score is :data:`MIN_IMPORTANT_DIFFERENCE` [Baker2012]_.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from plantigrade.analyze import norms
from plantigrade.arrays import Array, Float, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError

PELVIS = ("pelvis_tilt", "pelvis_list", "pelvis_rotation")
LEG = (
    *("hip_flexion", "hip_adduction", "hip_rotation"),
    *("knee_angle", "ankle_angle", "foot_progression"),
)
ANGLES = (*PELVIS, *LEG)  #: The nine angles in order

MIN_IMPORTANT_DIFFERENCE = 1.6
"""Minimal clinically important difference of the score for children [deg] [Baker2012]_."""


@dataclass(frozen=True)
class GaitProfile:
    """Differences of a gait from the mean of a population [deg]."""

    #: Angle with its side → RMS difference from the mean of the population
    difference: Mapping[str, float]
    #: Angle without side → standard deviation in the population, RMS over the cycle
    usual: Mapping[str, float]

    def score(self, side: str = "") -> float:
        """Return the Gait Profile Score of a side, or of both if ``side`` is empty."""
        if side:
            return root_mean_square(
                np.array([self.difference[f"{name}_{side}"] for name in ANGLES])
            )
        own = [f"{name}_r" for name in PELVIS] + [f"{name}_{s}" for s in SIDES for name in LEG]
        return root_mean_square(np.array([self.difference[name] for name in own]))

    @property
    def usual_score(self) -> float:
        """Root mean square of the score of a side over the people of the population."""
        return root_mean_square(np.array([self.usual[name] for name in ANGLES]))

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
    """Return the gait profile relative to a population.

    Args:
        percent: Percent of the gait cycle.
        angles: Cycles of every angle [deg], by name and side, pelvis included
            (:func:`plantigrade.analyze.clinical.clinical_angles`).
        population: Population for comparison.
        speed_class: Speed class of children, see :func:`plantigrade.analyze.norms.speed_class`.

    Raises:
        ParameterError: If an angle of the person or of the population is missing.
    """
    required = [f"{name}_{side}" for side in SIDES for name in ANGLES]
    published = norms.names(population)
    missing = [n for n in required if not np.isfinite(angles.get(n, ())).any()]
    missing += [n for n in ANGLES if n not in published]
    if missing:
        raise ParameterError(f"a gait profile needs {', '.join(missing)} as well")
    difference, usual = {}, {}
    for name in ANGLES:
        band = norms.norm(name, speed_class, population=population)
        mean = np.interp(percent, band.percent, band.mean)
        for side in SIDES:
            full = f"{name}_{side}"
            difference[full] = root_mean_square(np.nanmean(angles[full], axis=0) - mean)
        usual[name] = root_mean_square(band.sd)
    return GaitProfile(difference, usual)

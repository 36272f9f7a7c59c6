r"""Gait Profile Score and Movement Analysis Profile [Baker2009]_.

The profile holds, for each of nine angles, the root mean square difference over the gait cycle
between a person's mean curve and the mean of a population; the score is the root mean square of
the profile: of the pelvis and one leg, or of the pelvis and both.

A constant offset of convention between two body models is part of every difference, as in the
original; so is a difference of speed. Beside each value stands the population's own standard
deviation, root mean square over the cycle: what is usual for somebody of it.

References:
    [Baker2009]_.
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


@dataclass(frozen=True)
class GaitProfile:
    """How far a gait is from the mean of a population [deg]."""

    #: Angle (with its side, but of the pelvis) → RMS difference from the mean of the population
    difference: Mapping[str, float]
    #: Angle without side → standard deviation in the population, RMS over the cycle
    usual: Mapping[str, float]

    def score(self, side: str = "") -> float:
        """Return the Gait Profile Score of a side, or of both where ``side`` is empty."""
        legs = [f"{name}_{s}" for s in (side or "rl") for name in LEG]
        return _rms([self.difference[name] for name in (*PELVIS, *legs)])

    @property
    def usual_score(self) -> float:
        """The score of somebody who is one standard deviation off in every angle."""
        return _rms([self.usual[name] for name in (*PELVIS, *LEG)])


def gait_profile(
    percent: Float[Array, " n_percent"],
    angles: Mapping[str, Float[Array, "n_cycles n_percent"]],
    population: norms.Population = norms.ADULTS,
) -> GaitProfile:
    """Return how far a gait is from the mean of a population with all nine angles.

    Args:
        percent: Percent of the gait cycle.
        angles: Cycles of every angle [deg], by name and side; the pelvis by the right foot.
        population: Whom it is compared with.

    Raises:
        ParameterError: If an angle is missing, of the person or of the population.
    """
    wanted = [*PELVIS, *(f"{name}_{side}" for side in SIDES for name in LEG)]
    published = norms.names(population)
    missing = [n for n in wanted if not len(angles.get(n, ()))]
    missing += [n for n in (*PELVIS, *LEG) if n not in published]
    if missing:
        raise ParameterError(f"a gait profile needs {', '.join(missing)} as well")
    difference, usual = {}, {}
    for name in wanted:
        band = norms.norm(name, population=population)
        mean = np.interp(percent, band.percent, band.mean)
        difference[name] = _rms(np.nanmean(angles[name], axis=0) - mean)
        usual[band.name] = _rms(band.sd)
    return GaitProfile(difference, usual)


def _rms(values) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))

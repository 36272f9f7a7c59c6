"""Inverse dynamics and contact wrenches."""

from plantigrade.dynamics.centroid import (
    Centroid,
    centre_of_pressure,
    centroid,
    zero_moment_point,
)
from plantigrade.dynamics.derivatives import Derivatives, differentiate
from plantigrade.dynamics.inverse import (
    Moments,
    inverse_dynamics,
    opensim_moments,
    residual_metrics,
)
from plantigrade.dynamics.plates import FootForces, PlateUse, assign_plates, sole_points

__all__ = [
    "Centroid",
    "Derivatives",
    "FootForces",
    "Moments",
    "PlateUse",
    "assign_plates",
    "centre_of_pressure",
    "centroid",
    "differentiate",
    "inverse_dynamics",
    "opensim_moments",
    "residual_metrics",
    "sole_points",
    "zero_moment_point",
]

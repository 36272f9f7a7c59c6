"""Motion from a task alone: trajectories on splines, and the problems that choose them."""

from plantigrade.synthesize.band import Band
from plantigrade.synthesize.basis import Basis
from plantigrade.synthesize.knots import clamped_knots, periodic_knots, uniform_knots
from plantigrade.synthesize.splines import PolynomialBasis, TrigonometricBasis

__all__ = [
    "Band",
    "Basis",
    "PolynomialBasis",
    "TrigonometricBasis",
    "clamped_knots",
    "periodic_knots",
    "uniform_knots",
]

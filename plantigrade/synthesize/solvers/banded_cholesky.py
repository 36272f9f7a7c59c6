"""Symmetric banded matrices: factorised where positive definite, or made so."""

import numpy as np
from scipy.linalg import LinAlgError, cho_solve_banded, cholesky_banded

from plantigrade.arrays import Array

GROWTH = 8.0
"""Factor by which the shift grows where it was too small."""

SMALL = 0.5
"""A last shift below which none is tried first."""


def factorised(band: Array, shift: float) -> Array | None:
    """Return the Cholesky factor of a matrix plus a multiple of the identity; None if indefinite.

    Args:
        band: The matrix in lower form: entry (i, j) at ``[i - j, j]``.
        shift: What is added to the diagonal.
    """
    trial = band.copy(order="F")
    trial[0] += shift
    try:
        return cholesky_banded(trial, overwrite_ab=True, lower=True, check_finite=False)
    except LinAlgError:
        return None


def factorised_with_least_shift(band: Array, before: float) -> tuple[Array | None, float]:
    """Return the Cholesky factor, and the shift that it took; None if no shift was enough.

    Args:
        band: The matrix in lower form.
        before: The shift that a similar matrix took.
    """
    shift = 0.0 if before < SMALL else before / 4.0
    for _ in range(40):
        factor = factorised(band, shift + 1e-12)
        if factor is not None:
            return factor, shift
        shift = shift * GROWTH if shift else max(before / 3.0, 1e-3)
    return None, shift


def solved(factor: Array, right: Array) -> Array:
    """Return the solution of the equations with a factor and a right side."""
    return np.asarray(cho_solve_banded((factor, True), right, check_finite=False))

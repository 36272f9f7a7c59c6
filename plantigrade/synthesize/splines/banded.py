"""A matrix of basis functions, stored by its non-zero entries."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from plantigrade.arrays import Array, Float, Int


@dataclass(frozen=True, eq=False)
class BandedMatrix:
    """The non-zero entries of a collocation matrix, row by row.

    Attributes:
        values: Entries, the leftmost function first [1/s^derivative].
        first: Coefficient of the first entry of each row; the others follow it, wrapping round if
            the basis is periodic.
        n_coefficients: Number of columns.
    """

    values: Float[Array, "n_times order"]
    first: Int[Array, " n_times"]
    n_coefficients: int

    @property
    def columns(self) -> Int[Array, "n_times order"]:
        """Coefficient of each entry."""
        order = np.arange(self.values.shape[1])
        return (self.first[:, None] + order) % self.n_coefficients

    def matrix(self) -> sparse.csr_array:
        """Return the matrix, ``(n_times, n_coefficients)``, with sorted indices."""
        n_times, order = self.values.shape
        starts = np.arange(0, (n_times + 1) * order, order)
        entries = (self.values.ravel(), self.columns.ravel(), starts)
        matrix = sparse.csr_array(entries, shape=(n_times, self.n_coefficients), copy=True)
        matrix.sort_indices()
        return matrix

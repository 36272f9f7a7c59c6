"""A basis matrix by its non-zero entries alone."""

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from plantigrade.arrays import Array, Float, Int


@dataclass(frozen=True, eq=False)
class BandedMatrix:
    """The non-zero entries of a basis matrix, row by row.

    Attributes:
        values: Entries, the leftmost function first [1/s^derivative].
        first: Coefficient the first entry of each row belongs to; the others follow it, round the
            end where the basis is periodic.
        n_coefficients: Columns of the matrix.
    """

    values: Float[Array, "n_times order"]
    first: Int[Array, " n_times"]
    n_coefficients: int

    @property
    def columns(self) -> Int[Array, "n_times order"]:
        """Coefficient that each entry belongs to."""
        order = np.arange(self.values.shape[1])
        return (self.first[:, None] + order) % self.n_coefficients

    def matrix(self) -> sparse.csr_array:
        """Return the matrix, ``(n_times, n_coefficients)``, its entries in order of column."""
        n_times, order = self.values.shape
        starts = np.arange(0, (n_times + 1) * order, order)
        entries = (self.values.ravel(), self.columns.ravel(), starts)
        matrix = sparse.csr_array(entries, shape=(n_times, self.n_coefficients), copy=True)
        matrix.sort_indices()
        return matrix

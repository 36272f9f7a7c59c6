"""A symmetric band to which dense blocks are added."""

import numpy as np

from plantigrade.arrays import Array, Float


class Band:
    """The lower triangle of a symmetric band, in memory that is used again.

    Columns in memory are longer than the band is wide: what a block on the diagonal has above it
    falls into the end of the column before, where nothing is read.

    Args:
        size: Number of rows and columns.
        half_band: How far from the diagonal entries lie at most.
        widest: Number of columns of the widest block.

    Attributes:
        lower: Entry (i, j) at ``[i - j, j]``, a view (half_band + 1, size).
    """

    def __init__(self, size: int, half_band: int, widest: int):
        self._start, self._column = widest, half_band + max(widest, 1)
        self._memory = np.zeros(widest + size * self._column)
        columns = self._memory[widest:].reshape(size, self._column)
        self.lower: Float[Array, "half_band_1 size"] = columns[:, : half_band + 1].T

    def clear(self) -> None:
        """Set all entries to zero."""
        self._memory[:] = 0.0

    def block(self, row: int, column: int, shape: tuple[int, int]) -> Array:
        """Return the view of a block, of which only what lies in the lower triangle counts."""
        at = self._start + row - column + column * self._column
        size = self._memory.itemsize
        strides = size, size * (self._column - 1)
        return np.ndarray(shape, self._memory.dtype, self._memory.data, size * at, strides)

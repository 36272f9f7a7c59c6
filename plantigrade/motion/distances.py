"""Distances between markers, which are constant on a segment."""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float, spread

MIN_FRAMES = 5  # with both markers
MAX_FRAMES = 60  # that are evaluated


@dataclass(frozen=True)
class Distances:
    """Distances between markers in a recording; NaN for pairs with too few common frames."""

    usual: Float[Array, "n_markers n_markers"]  #: Median over frames [m]
    #: Half of the range of the middle two thirds of the frames [m], a robust standard deviation
    spread: Float[Array, "n_markers n_markers"]


def distances(positions: Float[Array, "n_frames n_markers 3"]) -> Distances:
    """Return the distances between all markers, from frames spread over the recording."""
    x = positions[spread(len(positions), MAX_FRAMES)]
    i, j = np.triu_indices(x.shape[1], 1)
    apart = np.sort(np.linalg.norm(x[:, i] - x[:, j], axis=-1), axis=0)  # NaN come last
    count = np.isfinite(apart).sum(axis=0)
    columns = np.arange(len(i))
    low, usual, high = (
        apart[np.rint(share * np.maximum(count - 1, 0)).astype(int), columns]
        for share in (0.16, 0.50, 0.84)
    )
    few = count < min(MIN_FRAMES, len(x))
    n = x.shape[1]
    found = Distances(np.zeros((n, n)), np.zeros((n, n)))
    for matrix, values in ((found.usual, usual), (found.spread, (high - low) / 2)):
        matrix[i, j] = matrix[j, i] = np.where(few, np.nan, values)
    return found

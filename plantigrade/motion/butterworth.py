"""A Butterworth low-pass, run forwards and backwards.

SciPy has both, in a package that takes longer to import (a quarter of a second of processor) than a
recording takes to filter.
"""

import numpy as np

from plantigrade.arrays import Array, Float


def there_and_back(
    values: Float[Array, "n_frames n_channels"],
    *,
    cutoff: float,
    rate: float,
    order: int,
    reflection: int,
) -> Float[Array, "n_frames n_channels"]:
    """Return signals after a low-pass forwards and one backwards, which leave no lag.

    Before the first frame and after the last the signal goes on as its own odd reflection, and
    each pass starts at rest on its first value.

    Args:
        values: Signals, finite, at even times.
        cutoff: Frequency of half power after one pass [Hz].
        rate: Frames per second [Hz].
        order: Order of one pass.
        reflection: Number of frames reflected at each end; fewer than there are.

    References:
        [Winter2009]_, chapter 3.
    """
    first = 2 * values[0] - values[reflection:0:-1]
    last = 2 * values[-1] - values[-2 : -reflection - 2 : -1]
    signal = np.concatenate([first, values, last])
    sections = _sections(cutoff, rate, order)
    for _ in range(2):
        start = signal[0].copy()
        signal = signal - start
        for numerator, denominator in sections:
            signal = _filtered(signal, numerator, denominator)
        signal = (signal + start)[::-1]
    return np.ascontiguousarray(signal[reflection : len(signal) - reflection])


def _sections(cutoff: float, rate: float, order: int) -> list[tuple[Array, Array]]:
    """Return numerator and denominator of every section, each of unit gain at rest.

    The analogue poles lie evenly on a half circle whose radius is the cut-off, and the bilinear
    transform, which keeps the cut-off where it is, makes them digital.
    """
    radius = np.tan(np.pi * cutoff / rate)
    angles = np.pi * (2 * np.arange(order // 2 + order % 2) + order + 1) / (2 * order)
    found = []
    for angle in angles:
        pole = radius * np.exp(1j * angle)
        pole = (1 + pole) / (1 - pole)
        alone = order % 2 and np.isclose(angle, np.pi)
        below = [1.0, -pole.real] if alone else [1.0, -2 * pole.real, abs(pole) ** 2]
        above = np.array([1.0, 1.0] if alone else [1.0, 2.0, 1.0])
        found.append((above * sum(below) / above.sum(), np.array(below)))
    return found


def _filtered(signal: Array, numerator: Array, denominator: Array) -> Array:
    """Return signals after a section that starts at rest at zero.

    The recursion is a solution with a triangular band, which LAPACK does for all signals at once.
    """
    from scipy.linalg.lapack import dtbtrs  # pyright: ignore[reportAttributeAccessIssue] (compiled)

    moved = numerator[0] * signal
    for k in range(1, len(numerator)):
        moved[k:] += numerator[k] * signal[:-k]
    band = np.repeat(denominator[:, None], len(signal), axis=1)
    return dtbtrs(band, moved, uplo="L")[0]

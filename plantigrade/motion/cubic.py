"""Piecewise cubics through samples: their slopes at the samples, and their values."""

import numpy as np

from plantigrade.arrays import Array, Float


def monotone(
    knots: Float[Array, " n"], values: Float[Array, " n *channels"], times: Float[Array, " m"]
) -> Float[Array, " m *channels"]:
    """Return the cubic through samples that rises and falls only where they do [Fritsch1984]_.

    Args:
        knots: Times of at least two samples [s], increasing.
        values: The samples, of any unit.
        times: Where it is wanted [s]; beyond the ends the last pieces go on.
    """
    step, rise = _steps(knots, values)
    if len(step) == 1:
        return hermite(knots, values, np.repeat(rise, 2, axis=0), times)
    before, after, h, k = rise[:-1], rise[1:], step[:-1], step[1:]
    alike = before * after > 0
    one, other = (np.where(alike, x, 1.0) for x in (before, after))
    mean = 3 * (h + k) / ((2 * k + h) / one + (k + 2 * h) / other)
    first, last = _end(h[0], k[0], rise[0], rise[1]), _end(k[-1], h[-1], rise[-1], rise[-2])
    slopes = np.concatenate([[first], np.where(alike, mean, 0.0), [last]])
    return hermite(knots, values, slopes, times)


def smooth_slopes(
    knots: Float[Array, " n"], values: Float[Array, " n *channels"], *, clamped: bool = False
) -> Float[Array, " n *channels"]:
    """Return the slopes of the cubic through samples whose second derivative is continuous.

    At its ends it is at rest if ``clamped``; otherwise the third derivative is continuous at the
    second and last but one knot as well, of at least four [deBoor1978]_.
    """
    from scipy.linalg import solve_banded

    step, rise = _steps(knots, values)
    h, n = step.reshape(len(step)), len(step) + 1
    band, right = np.zeros((3, n)), np.zeros(np.shape(values))
    band[1, 1:-1] = 2 * (h[:-1] + h[1:])
    band[0, 2:], band[2, :-2] = h[:-1], h[1:]
    right[1:-1] = 3 * (step[1:] * rise[:-1] + step[:-1] * rise[1:])
    if clamped:
        band[1, 0] = band[1, -1] = 1.0
    else:
        for end, by, near, beyond in ((0, 0, 0, 1), (-1, 2, -1, -2)):
            both = h[near] + h[beyond]
            band[1, end] = h[beyond]
            band[by, beyond] = both  # next to the diagonal, in the column of the neighbour
            square = (h[near] + 2 * both) * h[beyond] * rise[near] + h[near] ** 2 * rise[beyond]
            right[end] = square / both
    return solve_banded((1, 1), band, right)


def hermite(
    knots: Float[Array, " n"],
    values: Float[Array, " n *channels"],
    slopes: Float[Array, " n *channels"],
    times: Float[Array, " m"],
) -> Float[Array, " m *channels"]:
    """Return the piecewise cubic with given values and slopes at its knots."""
    step, rise = _steps(knots, values)
    times = np.asarray(times, float)
    k = np.clip(np.searchsorted(knots, times, side="right") - 1, 0, len(step) - 1)
    gone = (times - np.asarray(knots)[k]).reshape(-1, *step.shape[1:])
    part, first, second, mean = gone / step[k], slopes[k], slopes[k + 1], rise[k]
    bend = 3 * mean - 2 * first - second + (first + second - 2 * mean) * part
    return np.asarray(values)[k] + gone * (first + part * bend)


def _steps(knots: Array, values: Array) -> tuple[Array, Array]:
    """Return the time and the slope from sample to sample, both of the samples' dimensions."""
    values = np.asarray(values, float)
    step = np.diff(np.asarray(knots, float)).reshape(-1, *[1] * (values.ndim - 1))
    return step, np.diff(values, axis=0) / step


def _end(h: Array, k: Array, near: Array, next_: Array) -> Array:
    """Return the slope at an end, of a parabola, limited to keep the curve monotone."""
    slope = ((2 * h + k) * near - h * next_) / (h + k)
    steep = (near * next_ <= 0) & (np.abs(slope) > 3 * np.abs(near))
    return np.where(slope * near <= 0, 0.0, np.where(steep, 3 * near, slope))

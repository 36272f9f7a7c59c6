"""Filters for sampled signals: gaps, zero-lag smoothing, derivatives, resampling.

Every function takes the time along the first axis and any shape after it, treats each channel
separately and keeps NaN: a filter never reaches across a gap.
"""

import numpy as np

from plantigrade.arrays import Array, Bool, Float, Int
from plantigrade.errors import ParameterError
from plantigrade.motion.recording import rate_of


def runs(valid: Bool[Array, " n_frames"]) -> list[slice]:
    """Return the contiguous stretches of True, in order.

    Example:
        >>> runs(np.array([True, True, False, True]))
        [slice(0, 2, None), slice(3, 4, None)]
    """
    edges = np.diff(np.concatenate([[0], np.asarray(valid, dtype=int), [0]]))
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    return [slice(int(a), int(b)) for a, b in zip(starts, stops, strict=True)]


def fill_gaps(
    time: Float[Array, " n_frames"], values: Float[Array, " n_frames *channels"], *, longest: float
) -> Float[Array, " n_frames *channels"]:
    """Return the signal with short gaps filled by monotone cubic interpolation (PCHIP).

    Args:
        time: Time of each frame [s], increasing.
        values: Signal; NaN in gaps.
        longest: Longest gap to fill, from the last valid frame to the next [s]. Longer gaps and
            the ends of the recording stay NaN.
    """
    from scipy.interpolate import PchipInterpolator

    check_time(time, values)
    flat, result = _columns(values)
    for column in range(flat.shape[1]):
        seen = np.isfinite(flat[:, column])
        if seen.all() or seen.sum() < 2:
            continue
        curve = PchipInterpolator(time[seen], flat[seen, column])
        for gap in runs(~seen):
            inside = gap.start > 0 and gap.stop < len(time)
            if inside and time[gap.stop] - time[gap.start - 1] <= longest * (1 + 1e-9):
                result[gap, column] = curve(time[gap])
    return result.reshape(values.shape)


def lowpass(
    time: Float[Array, " n_frames"],
    values: Float[Array, " n_frames *channels"],
    *,
    cutoff: float,
) -> Float[Array, " n_frames *channels"]:
    r"""Return the signal after a zero-lag fourth-order Butterworth low-pass, there and back.

    Each pass is of second order; its cut-off is moved by :math:`(2^{1/2} - 1)^{-1/4}`, so that the
    amplitude after both passes is :math:`1/\sqrt 2` at ``cutoff``.

    Args:
        time: Time of each frame [s], evenly spaced.
        values: Signal; contiguous stretches are filtered separately, NaN stays NaN.
        cutoff: Frequency of half power after both passes [Hz].

    References:
        [Winter2009]_, chapter 3.
    """
    from scipy.signal import butter, sosfiltfilt

    check_time(time, values)
    if len(time) < 2:
        return np.array(values, dtype=float)
    rate = rate_of(time)
    corrected = cutoff * (np.sqrt(2.0) - 1.0) ** -0.25
    if not 0 < corrected < rate / 2:
        highest = rate / 2 * (np.sqrt(2.0) - 1.0) ** 0.25
        raise ParameterError(
            f"{cutoff=} [Hz] must lie between 0 and {highest:.4g} at {rate:.4g} frames per second"
        )
    sections = butter(2, corrected, fs=rate, output="sos")
    # Odd reflection over nine time constants of the filter, as much as the stretch has.
    reflection = int(np.ceil(9 * rate / (2 * np.pi * corrected))) + 6
    flat, result = _columns(values)

    def smooth(block):
        if len(block) < 4 or not block.shape[1]:
            return block
        return sosfiltfilt(sections, block, axis=0, padlen=min(reflection, len(block) - 1))

    if np.isfinite(flat).all():
        return smooth(flat).reshape(values.shape)
    for column in range(flat.shape[1]):
        for stretch in runs(np.isfinite(flat[:, column])):
            result[stretch, [column]] = smooth(flat[stretch, [column]])
    return result.reshape(values.shape)


def derivative(
    time: Float[Array, " n_frames"],
    values: Float[Array, " n_frames *channels"],
    *,
    order: int = 1,
    cutoff: float | None = None,
) -> Float[Array, " n_frames *channels"]:
    """Return the first or second time derivative, after smoothing if a cut-off is given.

    The derivative is that of a cubic spline through the (smoothed) samples, evaluated at the
    samples; stretches of fewer than four frames give NaN.

    Args:
        time: Time of each frame [s], increasing; evenly spaced if ``cutoff`` is given.
        values: Signal, NaN in gaps.
        order: 1 or 2.
        cutoff: Low-pass before differentiation [Hz]; see :func:`lowpass`.
    """
    from scipy.interpolate import CubicSpline

    if order not in (1, 2):
        raise ParameterError(f"{order=} of a derivative must be 1 or 2")
    check_time(time, values)
    if cutoff is not None:
        values = lowpass(time, values, cutoff=cutoff)
    flat, _ = _columns(values)
    result = np.full_like(flat, np.nan)
    if np.isfinite(flat).all() and len(flat) >= 4:
        return CubicSpline(time, flat)(time, order).reshape(values.shape)
    for column in range(flat.shape[1]):
        for stretch in runs(np.isfinite(flat[:, column])):
            if stretch.stop - stretch.start >= 4:
                spline = CubicSpline(time[stretch], flat[stretch, column])
                result[stretch, column] = spline(time[stretch], order)
    return result.reshape(values.shape)


def resample(
    time: Float[Array, " n_frames"],
    values: Float[Array, " n_frames *channels"],
    new_time: Float[Array, " n_new"],
) -> Float[Array, " n_new *channels"]:
    """Return the signal at other instants, by cubic splines over each contiguous stretch.

    Before reducing the rate, low-pass the signal (:func:`lowpass` below half the new rate) to avoid
    aliasing.

    Args:
        time: Time of each frame [s], increasing.
        values: Signal, NaN in gaps.
        new_time: New instants [s]; the result is NaN outside the signal.
    """
    from scipy.interpolate import CubicSpline

    check_time(time, values)
    flat, _ = _columns(values)
    result = np.full((len(new_time), flat.shape[1]), np.nan)
    order = np.argsort(new_time, kind="stable")
    rising = np.asarray(new_time)[order]
    finite = np.isfinite(flat)
    whole = finite.all(axis=0)
    # Channels without gaps share one spline.
    pieces = [(slice(0, len(time)), np.flatnonzero(whole))] if len(time) and whole.any() else []
    for column in np.flatnonzero(~whole).tolist():
        pieces += [(stretch, np.array([column])) for stretch in runs(finite[:, column])]
    for stretch, columns in pieces:
        t, y = time[stretch], flat[stretch][:, columns]
        slack = 1e-9 * max(1.0, abs(t[-1]))
        first = np.searchsorted(rising, t[0] - slack, "left")
        last = np.searchsorted(rising, t[-1] + slack, "right")
        if first == last:
            continue
        times = np.clip(rising[first:last], t[0], t[-1])
        if len(t) >= 4:
            found = CubicSpline(t, y)(times)
        else:
            found = interpolate(times, t, y)
        result[np.ix_(order[first:last], columns)] = found
    return result.reshape((len(new_time), *values.shape[1:]))


def interpolate(
    time: Float[Array, " n"] | Int[Array, " n"],
    clock: Float[Array, " m"] | Int[Array, " m"],
    values: Float[Array, " m *channels"],
) -> Float[Array, " n *channels"]:
    """Return a signal at other times [s], linearly interpolated, and constant beyond its ends."""
    columns = values.reshape(len(values), -1).T
    found = np.stack([np.interp(time, clock, column) for column in columns], axis=1)
    return found.reshape(len(time), *values.shape[1:])


def bridged_gaps(
    values: Float[Array, " n *channels"], known: Bool[Array, " n"]
) -> Float[Array, " n *channels"]:
    """Return a signal with straight lines across its gaps, and constant beyond its known ends.

    Zero where nothing is known.
    """
    if not known.any():
        return np.zeros_like(values)
    frames = np.arange(len(values))
    return interpolate(frames, frames[known], values[known])


def _columns(values):
    """Return the signal as (frames, channels), and a copy to write into."""
    flat = np.asarray(values, dtype=float).reshape(len(values), -1)
    return flat, flat.copy()


def check_time(time, values):
    """Raise a ParameterError unless there is one instant per frame and time increases."""
    if len(time) != len(values):
        raise ParameterError(f"{len(time)} instants but {len(values)} frames: one time per frame")
    if len(time) > 1 and not (np.diff(time) > 0).all():
        raise ParameterError("time must increase from frame to frame")


def vertex(curve: Float[Array, " n"], k: int | np.integer) -> float:
    """Return how far, in steps, the vertex of a curve is from sample ``k``, its extreme one."""
    before, extreme, after = curve[k - 1 : k + 2]
    return float(0.5 * (before - after) / (before - 2 * extreme + after))


def crossing(time: Float[Array, " n"], signal: Float[Array, " n"], k: int, level: float) -> float:
    """Return the instant between samples ``k`` and ``k + 1`` at which a signal passes a level."""
    a, b = signal[k], signal[k + 1]
    part = 0.5 if a == b else float(np.clip((level - a) / (b - a), 0.0, 1.0))
    return float(time[k] + part * (time[k + 1] - time[k]))

"""The motion of a run at the rate of a file."""

import numpy as np

from plantigrade.errors import ParameterError
from plantigrade.motion import Motion
from plantigrade.motion.motion import resampled

RATES = (1.0, 1000.0)  # [Hz] allowed frames per second of an exported motion


MAX_UNEVENNESS = 0.01
"""Deviation from equal steps [steps] above which a clock is not that of a format with one rate."""


def require_rate(rate: float | None) -> None:
    """Raise a ParameterError for a rate that is not allowed."""
    if rate is not None and not RATES[0] <= rate <= RATES[1]:
        raise ParameterError(f"{rate=} [Hz] must lie between {RATES[0]:g} and {RATES[1]:g}")


def at_rate(motion: Motion, rate: float | None) -> Motion:
    """Return a motion in equal steps of time, from its first instant on.

    Args:
        rate: Frames per second [Hz]. If None the motion stays as it is, unless its steps differ, as
            those between the nodes of an optimised one do: then its mean rate is rounded to a whole
            number.

    Raises:
        ParameterError: If the rate is not allowed.
    """
    require_rate(rate)
    if motion.n_frames < 2:
        return motion
    if rate is None:
        even = np.linspace(motion.time[0], motion.time[-1], motion.n_frames)
        if np.abs(motion.time - even).max() <= MAX_UNEVENNESS / motion.rate:
            return motion
        rate = float(np.ceil(motion.rate))
    count = int(np.floor(motion.duration * rate + 1e-6)) + 1
    return resampled(motion, motion.time[0] + np.arange(count) / rate)

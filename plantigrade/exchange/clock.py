"""The motion of a run at the rate of a file."""

import numpy as np

from plantigrade.errors import ParameterError
from plantigrade.motion import Motion
from plantigrade.motion.resample import resampled

RATES = (1.0, 1000.0)
"""Allowed frames per second of an exported motion [Hz]."""


def at_rate(motion: Motion, rate: float | None) -> Motion:
    """Return a motion at another rate, from its first instant on.

    Args:
        motion: The motion.
        rate: Frames per second [Hz]; None leaves the motion as it is.

    Raises:
        ParameterError: If the rate is not allowed.
    """
    if rate is None or motion.n_frames < 2:
        return motion
    if not RATES[0] <= rate <= RATES[1]:
        raise ParameterError(f"{rate=} [Hz] must lie between {RATES[0]:g} and {RATES[1]:g}")
    count = int(np.floor(motion.duration * rate + 1e-6)) + 1
    return resampled(motion, motion.time[0] + np.arange(count) / rate)

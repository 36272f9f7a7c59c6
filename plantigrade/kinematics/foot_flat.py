"""Duration of the heel rocker, from heel strike to foot flat."""

from collections.abc import Iterable

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion.filters import crossing

DOWN_HEIGHT = 0.004
"""Height of the forefoot above its level in midstance at foot flat [m]; 1.5° of pitch."""
MID_STANCE = 0.15, 0.30
"""Interval after heel strike in which the foot is flat, which defines the forefoot's level [s]."""
MAX_TIME = 0.25  # [s] maximum time from heel strike to foot flat
START_TOLERANCE = 0.02
"""Maximum time from a heel strike to the start of a motion that still includes it [s]."""


def foot_flat_time(
    time: Float[Array, " n"], forefoot: Float[Array, " n"], strikes: Iterable[float]
) -> float:
    """Return the mean time from heel strike to contact of ball and toes [s].

    Args:
        time: Time of each frame [s].
        forefoot: Height of the lowest point of ball and toes [m].
        strikes: Heel strikes of that foot [s].

    Returns:
        Mean time; NaN without a stance from heel strike to midstance, 0 for a flat landing.
    """
    found = []
    for strike in strikes:
        flat = (time >= strike + MID_STANCE[0]) & (time <= strike + MID_STANCE[1])
        if (
            time[0] > strike + START_TOLERANCE
            or time[-1] < strike + MID_STANCE[1]
            or not flat.any()
        ):
            continue
        above = forefoot - float(np.median(forefoot[flat])) - DOWN_HEIGHT
        down = np.flatnonzero((time >= strike) & (time <= strike + MAX_TIME) & (above <= 0.0))
        if len(down):
            k = int(down[0])
            lands = k > 0 and above[k - 1] > 0.0
            instant = crossing(time, above, k - 1, 0.0) if lands else float(time[k])
            found.append(max(instant - strike, 0.0))
    return float(np.mean(found)) if found else float("nan")

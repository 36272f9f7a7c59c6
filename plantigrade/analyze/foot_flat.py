"""Duration of the heel rocker: from heel strike until the whole foot is down."""

from collections.abc import Iterable

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion.filters import crossing

DOWN_HEIGHT = 0.004
"""Height of a forefoot above its level in mid stance below which it is down [m]; 1.5° of pitch."""
MID_STANCE = 0.15, 0.30
"""Interval after heel strike in which a walking foot is flat [s]; it gives the forefoot's level."""
MAX_TIME = 0.25
"""Longest time from heel strike until the forefoot is down [s]."""
START_TOLERANCE = 0.02
"""Longest time from a heel strike to the start of a motion that still shows it [s]."""


def foot_flat_time(
    time: Float[Array, " n"],
    forefoot: Float[Array, " n"],
    strikes: Iterable[float],
) -> float:
    """Return the time from heel strike until ball and toes are down [s], mean over the strikes.

    Args:
        time: Time of each frame [s].
        forefoot: Height of the lowest point of ball and toes [m].
        strikes: Heel strikes of that foot [s].

    Returns:
        NaN where no stance was seen from heel strike to mid stance; 0 for a foot put down flat.
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

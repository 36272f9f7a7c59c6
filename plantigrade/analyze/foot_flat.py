"""How long after heel strike the whole foot is down: the heel rocker of a walk."""

from collections.abc import Iterable

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.motion.filters import crossing

DOWN = 0.004
"""A forefoot no higher than this above its level in mid stance is down [m]: 1.5° of a foot."""
LEVEL = 0.15, 0.30
"""When a walking foot is flat, after heel strike [s]: its forefoot tells its level."""
LATEST = 0.25
"""The forefoot comes down within this time [s]."""
EARLIER = 0.02
"""A motion may begin this long after a heel strike and still show it [s]."""


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
        flat = (time >= strike + LEVEL[0]) & (time <= strike + LEVEL[1])
        if time[0] > strike + EARLIER or time[-1] < strike + LEVEL[1] or not flat.any():
            continue
        above = forefoot - float(np.median(forefoot[flat])) - DOWN
        down = np.flatnonzero((time >= strike) & (time <= strike + LATEST) & (above <= 0.0))
        if len(down):
            k = int(down[0])
            lands = k > 0 and above[k - 1] > 0.0
            instant = crossing(time, above, k - 1, 0.0) if lands else float(time[k])
            found.append(max(instant - strike, 0.0))
    return float(np.mean(found)) if found else float("nan")

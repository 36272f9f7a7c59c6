"""What a walk was, in words and figures: how fast, how well feet landed."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

SHORT = 0.01
"""A step counts as shortened where it is farther than this from where the law has it [m]."""


@dataclass(frozen=True)
class Landed:
    """How a foot came down.

    Attributes:
        time: When [s].
        side: Which foot.
        error: How far from the predicted place [m].
        short: How far that was from where the law had it, for its being out of reach [m].
    """

    time: float
    side: str
    error: float
    short: float


def walk_told(landings: Sequence[Landed], speeds: tuple[float, float, float]) -> tuple[str, ...]:
    """Return sentences on a walk.

    Args:
        landings: Of the feet.
        speeds: Mean speed, that of the recording [m/s], and how far aside it ended [m].
    """
    if not landings:
        return ()
    own, recorded, aside = speeds
    off = 100 * float(np.median([x.error for x in landings]))
    told = [
        f"Walked at {own:.2f} m/s, the recording at {recorded:.2f} m/s; ended "
        f"{100 * abs(aside):.0f} cm {'left' if aside > 0 else 'right'} of its line. "
        f"{len(landings)} steps, in the median {off:.1f} cm from where they were predicted."
    ]
    short = sum(x.short > SHORT for x in landings)
    if short:
        were = "was" if short == 1 else "were"
        told.append(f"{short} of them {were} shortened, since their place was out of reach.")
    return tuple(told)


def walk_figures(
    landings: Sequence[Landed], speeds: tuple[float, float, float]
) -> dict[str, float]:
    """Return figures of a walk; see :func:`walk_told`."""
    own, recorded, aside = speeds
    off = [x.error for x in landings]
    return {
        "speed_m_s": own,
        "recorded_speed_m_s": recorded,
        "aside_m": aside,
        "landings": len(landings),
        "landing_error_median_m": float(np.median(off)) if off else 0.0,
        "landings_shortened": sum(x.short > SHORT for x in landings),
    }

"""What a force plate shows while nobody stands on it: its baseline.

A plate that was not set to zero reads some newtons with nothing on it, usually the same throughout
a trial. A stretch counts as unloaded where the vertical force is small and flat. The ground cannot
pull, so a flat force below zero can be nothing else; a small push might be a foot that rests
lightly, as of somebody who sits, and counts only where the force leaves it steeply, as it does when
a foot lands or lifts off.
"""

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.motion.filters import runs
from plantigrade.motion.recording import rate_of

LARGEST = 30.0
"""A larger force is a load [N]."""

SMALLEST = 2.0
"""A smaller baseline is left alone [N]."""

SHORTEST = 0.15
"""Shortest time without load [s]: shorter than any swing."""

TRIM = 0.04
"""Of it, left out at either end, where a foot comes or goes [s]."""

FLAT = 6.0
"""Spread of an unloaded force, 10th to 90th percentile of its 20 ms means [N]."""

STEP = 200.0
"""A foot that lands or lifts off changes the force by this … [N]"""

STEP_TIME = 0.1
"""… within this time [s]; who rises from a chair takes three times as long."""


def unloaded(
    time: Float[Array, " n_samples"], vertical: Float[Array, " n_samples"]
) -> Bool[Array, " n_samples"] | None:
    """Return the samples that show the baseline of a plate; None if it has none worth removing.

    Args:
        time: Time of each sample [s].
        vertical: Force of the ground on the body, upward positive [N].
    """
    if len(time) < 8 or not np.isfinite(vertical).all() or not vertical.max() > STEP:
        return None
    rate = rate_of(time)
    width = max(1, int(round(0.02 * rate)))
    mean = np.convolve(np.pad(vertical, width // 2, mode="edge"), np.ones(width) / width, "valid")
    mean = mean[: len(time)]
    trim = int(round(TRIM * rate))
    found = np.zeros(len(time), dtype=bool)
    steep = False
    for run in runs(np.abs(mean) < LARGEST):
        if run.stop - run.start < SHORTEST * rate:
            continue
        start = run.start + (trim if run.start > 0 else 0)
        stop = run.stop - (trim if run.stop < len(time) else 0)
        low, high = np.percentile(mean[start:stop], [10, 90])
        if high - low > FLAT:
            continue
        found[start:stop] = True
        reach = int(round(STEP_TIME * rate))
        before, after = mean[max(run.start - reach, 0) : run.start], mean[run.stop :][:reach]
        steep |= max(before.max(initial=0.0), after.max(initial=0.0)) > STEP
    if not found.any():
        return None
    level = float(np.median(vertical[found]))
    found &= np.abs(mean - level) < FLAT
    if abs(level) < SMALLEST or not found.any() or (level > 0 and not steep):
        return None
    return found


def baseline_note(name: str, level: float) -> str:
    """Return the sentence that says that a baseline was removed."""
    return (
        f"force plate {name}: it shows {level:.0f} N while nobody stands on it; this baseline was "
        "removed"
    )

"""Baseline of a force plate, its signal without load.

A plate that was not zeroed has an offset of some newtons, usually constant during a trial. An
interval counts as unloaded if the vertical force is small and flat. A negative flat force must be
an offset, because the ground cannot pull. A positive one may be a lightly loaded foot, as in
sitting, and counts only if the force leaves it steeply, as at touchdown or lift-off.
"""

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.motion.filters import runs
from plantigrade.motion.recording import rate_of

MAX_BASELINE = 30.0  # Maximum baseline [N]; a larger force is a load
MIN_BASELINE = 2.0  # [N] minimum baseline that is removed
MIN_DURATION = 0.15  # Minimum duration without load [s], shorter than any swing
EDGE_TIME = 0.04  # [s] time excluded at either end, because of touchdown and lift-off
MAX_SPREAD = 6.0
"""Maximum spread of an unloaded force, 10th to 90th percentile of its 20 ms means [N]."""
MIN_STEP = 200.0  # [N] minimum change of force at touchdown or lift-off
MAX_STEP_TIME = 0.1
"""Maximum duration of that change [s]; rising from a chair takes three times as long."""


def unloaded(
    time: Float[Array, " n_samples"], vertical: Float[Array, " n_samples"]
) -> Bool[Array, " n_samples"] | None:
    """Return the unloaded samples of a plate; None without a significant baseline.

    Args:
        time: Time of each sample [s].
        vertical: Force of the ground on the body, upward positive [N].
    """
    if len(time) < 8 or not np.isfinite(vertical).all() or not vertical.max() > MIN_STEP:
        return None
    rate = rate_of(time)
    width = max(1, int(round(0.02 * rate)))
    mean = np.convolve(np.pad(vertical, width // 2, mode="edge"), np.ones(width) / width, "valid")
    mean = mean[: len(time)]
    trim = int(round(EDGE_TIME * rate))
    found = np.zeros(len(time), dtype=bool)
    steep = False
    for run in runs(np.abs(mean) < MAX_BASELINE):
        if run.stop - run.start < MIN_DURATION * rate:
            continue
        start = run.start + (trim if run.start > 0 else 0)
        stop = run.stop - (trim if run.stop < len(time) else 0)
        low, high = np.percentile(mean[start:stop], [10, 90])
        if high - low > MAX_SPREAD:
            continue
        found[start:stop] = True
        reach = int(round(MAX_STEP_TIME * rate))
        before, after = mean[max(run.start - reach, 0) : run.start], mean[run.stop :][:reach]
        steep |= max(before.max(initial=0.0), after.max(initial=0.0)) > MIN_STEP
    if not found.any():
        return None
    level = float(np.median(vertical[found]))
    found &= np.abs(mean - level) < MAX_SPREAD
    if abs(level) < MIN_BASELINE or not found.any() or (level > 0 and not steep):
        return None
    return found


def baseline_note(name: str, level: float) -> str:
    """Return the note that a baseline was removed."""
    return (
        f"force plate {name}: its signal without load is {level:.0f} N; this baseline was removed"
    )

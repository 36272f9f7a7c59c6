r"""Whether measured forces are tilted against the vertical of the motion.

Over a whole stride the mean horizontal force on a walker is the mass times the change of velocity
over the stride's duration, which in steady walking is about zero. A mean that the motion does not
have is a share of the weight in the horizontal axes: the plates, or the belts of a treadmill, are
not level with the cameras, or the vertical force leaks into the horizontal channels.
"""

from dataclasses import replace

import numpy as np

from plantigrade.constants import GRAVITY
from plantigrade.dynamics.inverse import Moments
from plantigrade.dynamics.plates import FootForces
from plantigrade.motion.cycles import Cycle

MAX_TILT = 0.01
"""Largest horizontal force over whole strides that the motion does not have, as a share of the
vertical one [1]. At the height of the hips it is 0.09 N m/kg, a tenth of the peak moment. Two
recordings of walks and two of runs with whole strides have up to 0.004, one treadmill 0.015."""

HIP_HEIGHT = 0.9  # [m] of an adult, for the error of hip moments


def force_tilt(
    time: np.ndarray, forces: FootForces, moments: Moments, cycles: tuple[Cycle, ...]
) -> tuple[float, float] | None:
    """Return the horizontal force forward and to the left in excess of the motion's [1].

    It is the mean over the cycles in which the plates measured both feet, as a share of the
    vertical force; None without such a cycle.
    """
    whole = np.zeros(len(time), dtype=bool)
    for cycle in cycles:
        inside = (time >= cycle.start) & (time < cycle.stop)
        if inside.any() and np.asarray(forces.valid)[inside].all():
            whole |= inside
    if not whole.any():
        return None
    load = forces.force[whole].sum(axis=1)[:, 2].mean()
    forward, left, _ = -moments.residual_force[whole].mean(axis=0) / load
    return float(forward), float(left)


def levelled(forces: FootForces, tilt: tuple[float, float]) -> FootForces:
    """Return forces without the tilt of :func:`force_tilt`; centres of pressure stay."""
    lean = np.array([*tilt, 0.0]) * forces.force[..., 2:]
    return replace(forces, force=forces.force - lean)


def tilt_note(tilt: tuple[float, float] | None) -> str:
    """Return a warning where measured forces are tilted; empty otherwise."""
    if tilt is None or np.hypot(*tilt) <= MAX_TILT:
        return ""
    forward, left = tilt
    if abs(forward) >= abs(left):
        way = "forward" if forward > 0 else "backward"
    else:
        way = "to the left" if left > 0 else "to the right"
    share = float(np.hypot(forward, left))
    angle, moment = np.rad2deg(np.arctan(share)), GRAVITY * HIP_HEIGHT * share
    return (
        f"the measured forces lean {way} by {angle:.1f}°: over whole strides {100 * share:.1f} % "
        "of the weight is left that the motion does not have, where a steady walk has none. The "
        "plates are not level with the cameras, or their vertical force leaks into the others; hip "
        f"moments are wrong by up to {moment:.1f} N m/kg."
    )

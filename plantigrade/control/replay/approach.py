"""A motion whose swing feet clear the ground until they come down to it at a steady speed.

A planned sole may glide a millimetre over the ground for 80 ms before it lands, as uphill. A body
that stands on soles that yield misses such a plan by several millimetres, and lands that much
sooner, with a foot that still moves, or later.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.ground import Ground
from plantigrade.control.gait.reference import STEP, ReferenceTables
from plantigrade.control.gait.swing_lift import smooth, swings, with_lift


@dataclass(frozen=True, kw_only=True)
class ApproachSettings:
    """How swing feet leave the ground and come down to it."""

    clearance: float = 0.004
    """Least height of a swinging sole over the ground [m], twice that up to which a sphere touches.
    With 8 mm, a walk uphill took steps 1 cm short, and a level one had larger force peaks."""
    speed: float = 0.1
    """Speed at which that height grows after lift-off and shrinks before touchdown [m/s]. Chosen:
    with 0.06 m/s, feet uphill met the ground 28 ms too soon, now and then while they still moved;
    with 0.2 m/s (and 8 mm), force peaks were 2.0 body weights in place of 1.5."""
    smoothing_time: float = 0.008
    """Standard deviation of the filter of the lift [s]. Chosen."""


def with_approach(
    reference: ReferenceTables,
    of_side: Sequence[Array],
    ground: Ground,
    settings: ApproachSettings | None = None,
) -> ReferenceTables:
    """Return a motion whose feet are lifted where they swing too near the ground.

    A swing that the end of the motion cuts is left as it is: when it would land is not known.

    Args:
        of_side: Contact spheres of the right foot and of the left one.
    """
    settings, periodic = settings or ApproachSettings(), reference.period is not None

    def lift_of(stands: Array, low: Array) -> Array:
        height = ground.gap(low).min(axis=1)
        lift = np.maximum(_least_height(stands, periodic, settings) - height, 0.0)
        lift[stands] = 0.0
        lift = smooth(lift, settings.smoothing_time, periodic=periodic)
        lift[stands] = 0.0
        return lift

    return with_lift(reference, of_side, lift_of, 1.0 / ground.normal[2])


def _least_height(
    stands: Bool[Array, " n"], periodic: bool, settings: ApproachSettings
) -> Float[Array, " n"]:
    """Return the least height of the sole at every instant [m]; none in stance."""
    n, out = len(stands), np.zeros(len(stands))
    for swing in swings(stands, periodic=periodic):
        k = np.arange(swing.start, swing.stop)
        since = k - swing.start if swing.start else np.full(len(k), len(k))
        ramp = settings.speed * STEP * np.minimum(since, swing.stop - k)
        out[k % n] = np.minimum(ramp, settings.clearance)
    return out

"""A recorded walk whose swing feet clear the ground where they pass too near, and land in time.

Fitted soles are in the ground by up to a centimetre somewhere in a swing and well above it
elsewhere. The missing clearance is known from the recording, and none is added where none is
missing: a foot that is lifted by the same amount in every swing comes down from too high and
strikes the ground. At the end of a swing feet are lowered to the ground where recorded soles are
still above it.
"""

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import maximum_filter1d

from plantigrade.arrays import Array, Bool, Float
from plantigrade.control.gait.reference import STEP, ReferenceTables
from plantigrade.control.gait.swing_lift import smooth, swings, with_lift
from plantigrade.control.pendulum.swing import SwingPathSettings
from plantigrade.motion.blends import cubic_rise


def with_clearance(
    reference: ReferenceTables,
    leg_length: float,
    of_side: Sequence[Array],
    settings: SwingPathSettings | None = None,
) -> ReferenceTables:
    """Return a walk on level ground whose feet pass over the ground, and land in time.

    Args:
        leg_length: Length of the leg [m].
        of_side: Contact spheres of the right foot and of the left one.
    """
    own, periodic = settings or SwingPathSettings(), reference.period is not None

    def lift_of(stands: Array, low: Array) -> Array:
        height = low[:, :, 2].min(axis=1)
        weight = _fading(stands, periodic, own.clearance_fading)
        lack = np.maximum(own.clearance * leg_length * weight - height, 0.0) * (weight > 0.0)
        size, mode = 2 * round(own.lift_time / STEP) + 1, "wrap" if periodic else "nearest"
        wide = maximum_filter1d(lack, size, mode=mode)
        lift = smooth(wide, own.lift_smoothing, periodic=periodic) * weight
        lift = smooth(lift, 0.5 * own.lift_smoothing, periodic=periodic)
        return lift - _lowering(height, stands, periodic, own.landing_depth * leg_length, own)

    return with_lift(reference, of_side, lift_of)


def _fading(stands: Bool[Array, " n"], periodic: bool, end_share: float) -> Float[Array, " n"]:
    """Return 1 in the middle of swings, 0 in stance, and smooth steps between them.

    A swing that the end of a motion cuts has no middle that is known, and gets 0.
    """
    n, out = len(stands), np.zeros(len(stands))
    for swing in swings(stands, periodic=periodic):
        if swing.start:
            u = np.linspace(0.0, 1.0, swing.stop - swing.start)
            rise = cubic_rise(np.minimum(u, 1.0 - u) / end_share)
            out[np.arange(swing.start, swing.stop) % n] = rise
    return out


def _lowering(
    height: Float[Array, " n"],
    stands: Bool[Array, " n"],
    periodic: bool,
    depth: float,
    settings: SwingPathSettings,
) -> Float[Array, " n"]:
    """Return by how much feet are lowered at the end of swings, to land in time [m].

    It lasts a little after the swing: a late foot goes on to the ground.

    Args:
        height: Height of the lowest point of the sole [m].
        stands: When it stands.
        periodic: Whether the last row is followed by the first.
        depth: Depth below the ground at which a swing ends [m].
        settings: In which part of a swing, and for how long after it.
    """
    n, out = len(stands), np.zeros(len(stands))
    for swing in swings(stands, periodic=periodic):
        if not swing.start:
            continue
        u = np.arange(swing.stop - swing.start) / (swing.stop - swing.start)
        share = np.maximum(1.0 - (1.0 - u) / settings.landing_share, 0.0)
        excess = height[swing.stop % n] + depth
        out[np.arange(swing.start, swing.stop) % n] = excess * share * share * (3.0 - 2.0 * share)
        after = swing.stop + np.arange(round(settings.lift_time / STEP))
        out[after % n if periodic else after[after < n]] = excess
    return out

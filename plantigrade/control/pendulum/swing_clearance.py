"""A recorded walk whose swing feet clear the ground where they pass too near, and land in time.

Fitted soles are in the ground by up to a centimetre somewhere in a swing and well above it
elsewhere. The missing clearance is known from the recording, and none is added where none is
missing: a foot that is lifted by the same amount in every swing comes down from too high and
strikes the ground. At the end of a swing feet are lowered to the ground where recorded soles are
still above it.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d, maximum_filter1d

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.reference import STEP, ReferenceTables
from plantigrade.control.pendulum.swing import SwingPathSettings
from plantigrade.motion.filters import runs


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
    own = settings or SwingPathSettings()
    found = replace(reference, table=reference.table.copy())
    rows, periodic = found.rows, reference.period is not None
    n = len(found.table) - int(periodic)
    mode = "wrap" if periodic else "nearest"
    for i, mine in enumerate(of_side[: len(SIDES)]):
        stands = np.any(rows.contact[:n][:, mine] > 0.5, axis=1)
        weight = _fading(stands, periodic, own.clearance_fading)
        height = rows.contact_position[:n][:, mine, 2].min(axis=1)
        lack = np.maximum(own.clearance * leg_length * weight - height, 0.0) * (weight > 0.0)
        wide = maximum_filter1d(lack, 2 * round(own.lift_time / STEP) + 1, mode=mode)
        lift = gaussian_filter1d(wide, own.lift_smoothing / STEP, mode=mode) * weight
        lift = gaussian_filter1d(lift, 0.5 * own.lift_smoothing / STEP, mode=mode)
        lift -= _lowering(height, stands, periodic, own.landing_depth * leg_length, own)
        lift = np.append(lift, lift[0]) if periodic else lift
        speed = np.gradient(lift, STEP)
        rows.foot_position[:, i, 2] += lift
        rows.foot_velocity[:, i, 2] += speed
        rows.foot_acceleration[:, i, 2] += np.gradient(speed, STEP)
    return found


def _fading(stands: Bool[Array, " n"], periodic: bool, end_share: float) -> Float[Array, " n"]:
    """Return 1 in the middle of swings, 0 in stance, and smooth steps between them.

    A swing that the end of a motion cuts has no middle that is known, and gets 0.
    """
    n = len(stands)
    rows, out = np.concatenate([stands, stands]) if periodic else stands, np.zeros(n)
    for swing in runs(~rows):
        if swing.start == 0 or swing.stop == len(rows):
            continue
        u = np.linspace(0.0, 1.0, swing.stop - swing.start)
        share = np.minimum(np.minimum(u, 1.0 - u) / end_share, 1.0)
        out[np.arange(swing.start, swing.stop) % n] = share * share * (3.0 - 2.0 * share)
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
    n = len(stands)
    rows, out = np.concatenate([stands, stands]) if periodic else stands, np.zeros(n)
    for swing in runs(~rows):
        if swing.start == 0 or swing.stop == len(rows):
            continue
        u = np.arange(swing.stop - swing.start) / (swing.stop - swing.start)
        share = np.maximum(1.0 - (1.0 - u) / settings.landing_share, 0.0)
        excess = height[swing.stop % n] + depth
        out[np.arange(swing.start, swing.stop) % n] = excess * share * share * (3.0 - 2.0 * share)
        after = swing.stop + np.arange(round(settings.lift_time / STEP))
        out[after % n if periodic else after[after < n]] = excess
    return out

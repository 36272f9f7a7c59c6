"""A motion whose feet are lifted while they swing, or lowered."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import SIDES
from plantigrade.control.gait.reference import STEP, ReferenceTables
from plantigrade.motion.filters import runs

Lift = Callable[[Bool[Array, " n"], Float[Array, "n k 3"]], Float[Array, " n"]]
"""Lift of a foot [m], from when it stands and where its contact spheres are lowest, world [m]."""


def with_lift(
    reference: ReferenceTables, of_side: Sequence[Array], lift_of: Lift, up: float = 1.0
) -> ReferenceTables:
    """Return a motion with lifted feet.

    Args:
        of_side: Contact spheres of the right foot and of the left one.
        up: Height by lift, on a slope more than 1.
    """
    found = replace(reference, table=reference.table.copy())
    rows, periodic = found.rows, reference.period is not None
    n = len(found.table) - int(periodic)
    for i, own in enumerate(of_side[: len(SIDES)]):
        stands = np.any(rows.contact[:n][:, own] > 0.5, axis=1)
        lift = lift_of(stands, rows.contact_position[:n][:, own])
        lift = np.append(lift, lift[0]) if periodic else lift
        speed = np.gradient(lift, STEP)
        rows.foot_position[:, i, 2] += up * lift
        rows.foot_velocity[:, i, 2] += up * speed
        rows.foot_acceleration[:, i, 2] += up * np.gradient(speed, STEP)
    return found


def swings(stands: Bool[Array, " n"], *, periodic: bool) -> Iterator[slice]:
    """Yield the swings of a foot whose ends are known; of a periodic motion, in two periods.

    In other motions the beginning of the first may be unknown.
    """
    rows = np.concatenate([stands, stands]) if periodic else stands
    for swing in runs(~rows):
        if swing.stop < len(rows) and not (periodic and swing.start == 0):
            yield swing


def smooth(lift: Float[Array, " n"], time: float, *, periodic: bool) -> Float[Array, " n"]:
    """Return a lift after a Gaussian filter of a standard deviation [s]."""
    return gaussian_filter1d(lift, time / STEP, mode="wrap" if periodic else "nearest")

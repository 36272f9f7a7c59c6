r"""Body mass from force plates, where they carry the whole person and nothing else does.

The ground's vertical force is that of the whole body's motion, :math:`F = m\,(g + \ddot z)`, with
the height :math:`z` of the centre of mass. The mass is weighed

- in quiet, upright standing: the median of :math:`F / g`;
- in gait: :math:`\sum F / \sum (g + \ddot z)` over whole cycles in which the force under both feet
  is known throughout, or else over all frames in which it is.

In a landing, on a chair or beside the plates nobody is weighed: the acceleration is too large to be
known from markers, or part of the weight is carried elsewhere.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY
from plantigrade.dynamics.plates import FootForces
from plantigrade.motion.cycles import Cycle
from plantigrade.motion.filters import runs
from plantigrade.motion.recording import ForcePlate, GaitEvent

QUIET_SPEED = 0.1
"""Fastest centre of mass in quiet standing [m/s]; people sway at 0.01 to 0.03 m/s."""

QUIET_LIFT = 0.05
"""Largest vertical acceleration in quiet standing, as a fraction of gravity."""

UPRIGHT = 0.9
"""Lowest pelvis of somebody who stands, as a fraction of its height in the neutral pose."""

SHORTEST_REST = 0.5
"""Shortest quiet standing [s]."""

SHORTEST_GAIT = 0.3
"""Shortest time of gait with every force known [s]: a single support."""


@dataclass(frozen=True)
class Weighing:
    """A body mass that plates showed."""

    mass: float  #: [kg]
    seconds: float  #: How long the person was weighed
    how: str  #: ``"standing"`` or ``"gait"``


def weigh_standing(
    time: Float[Array, " n_frames"],
    plates: Sequence[ForcePlate],
    carried: Bool[Array, " n_frames"],
    com_vel: Float[Array, "n_frames 3"],
    lift: Float[Array, " n_frames"],
    height: Float[Array, " n_frames"],
) -> Weighing | None:
    r"""Return the body mass in quiet standing; None if nobody stands quietly on the plates alone.

    Args:
        time: Time of each frame [s].
        plates: Measured ground reactions.
        carried: Frames in which nothing but the plates carries the feet.
        com_vel: Velocity of the centre of mass [m/s].
        lift: Its vertical acceleration and gravity, :math:`g + \ddot z` [m/s²].
        height: Height of the pelvis above the soles, as a fraction of that in the neutral pose.
    """
    total = np.zeros(len(time))
    for plate in plates:
        push = np.nan_to_num(plate.force[:, 2])
        total += np.interp(time, plate.time, push, left=0.0, right=0.0)
    quiet = (
        carried
        & (np.linalg.norm(com_vel, axis=1) < QUIET_SPEED)
        & (np.abs(lift / GRAVITY - 1.0) < QUIET_LIFT)
        & (height > UPRIGHT)
        & (total > 50.0)
    )
    step = float(np.median(np.diff(time)))
    for rest in runs(quiet):
        if (rest.stop - rest.start) * step < SHORTEST_REST:
            quiet[rest] = False
    if not quiet.any():
        return None
    mass = float(np.median(total[quiet]) / GRAVITY)
    return Weighing(mass, float(quiet.sum() * step), "standing")


def weigh_gait(
    time: Float[Array, " n_frames"],
    forces: FootForces,
    events: Sequence[GaitEvent],
    cycles: Sequence[Cycle],
    lift: Float[Array, " n_frames"],
) -> Weighing | None:
    """Return the body mass that the forces of a gait carry; None where too few are known.

    Args:
        time: Time of each frame [s].
        forces: Ground reaction on each foot, smoothed like the motion.
        events: Gait events by time: from the first to the last the person walks or runs.
        cycles: Gait cycles.
        lift: Vertical acceleration of the centre of mass and gravity [m/s²].
    """
    if not events:
        return None
    inside = (time >= events[0].time) & (time <= events[-1].time)
    whole = np.zeros(len(time), dtype=bool)
    for cycle in cycles:
        frames = (time >= cycle.start) & (time < cycle.stop)
        if forces.valid[frames].all():
            whole |= frames
    known = whole if whole.any() else inside & forces.valid
    seconds = float(known.sum() * np.median(np.diff(time)))
    total = forces.force[known, :, 2].sum()
    if seconds < SHORTEST_GAIT or not total > 0:
        return None
    return Weighing(float(total / lift[known].sum()), seconds, "gait")

r"""Body mass from force plates that carry the whole person.

The vertical ground reaction force is :math:`F = m\,(g + \ddot z)` with the height :math:`z` of the
centre of mass. The mass is computed

- in quiet, upright standing: the median of :math:`F / g`;
- in gait: :math:`\sum F / \sum (g + \ddot z)` over complete cycles with known force under both
  feet, or else over all such frames;
- in jumps: the same from one flight to the next.

Other landings, sitting and contact off the plates are excluded, because the acceleration is too
large to be computed from markers, or a part of the weight is unmeasured. Over a whole contact only
the velocities of the flights before and after it count.
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

MAX_QUIET_SPEED = 0.1
"""Maximum speed of the centre of mass in quiet standing [m/s]; people sway at 0.01 to 0.03 m/s."""
MAX_QUIET_ACCELERATION = 0.05
"""Maximum vertical acceleration in quiet standing, as a fraction of gravity."""
MIN_PELVIS_HEIGHT = 0.9
"""Minimum height of the pelvis in standing, as a fraction of that in the neutral pose."""
MIN_REST = 0.5  # [s] minimum duration of quiet standing
MIN_GAIT = 0.3  # Minimum duration of gait with all forces known [s], about a single support
FLIGHT_MARGIN = 0.08
"""Part of the flights before and after a contact that is weighed with it [s], over which filters of
15 Hz smear its force."""
WEIGHINGS = {"standing": "quiet standing", "gait": "gait", "jumps": "jumps"}
"""Method of weighing → its name in a sentence, from the most to the least accurate. OpenCap's
subject 4 weighs 60.0 kg in quiet standing, and 62.0 kg in a jump."""


@dataclass(frozen=True)
class MeasuredMass:
    """Body mass measured by force plates."""

    mass: float  #: Body mass [kg]
    seconds: float  #: Duration of the measurement [s]
    method: str  #: How: a key of :data:`WEIGHINGS`


def weigh_standing(
    time: Float[Array, " n_frames"],
    plates: Sequence[ForcePlate],
    carried: Bool[Array, " n_frames"],
    com_vel: Float[Array, "n_frames 3"],
    lift: Float[Array, " n_frames"],
    height: Float[Array, " n_frames"],
) -> MeasuredMass | None:
    r"""Return the body mass in quiet standing on the plates alone; None without such standing.

    Args:
        time: Time of each frame [s].
        carried: Frames in which the plates alone carry the feet.
        com_vel: Velocity of the centre of mass [m/s].
        lift: Vertical acceleration plus gravity, :math:`g + \ddot z` [m/s²].
        height: Height of the pelvis above the soles, as a fraction of that in the neutral pose.
    """
    total = np.zeros(len(time))
    for plate in plates:
        push = np.nan_to_num(plate.force[:, 2])
        total += np.interp(time, plate.time, push, left=0.0, right=0.0)
    quiet = (
        carried
        & (np.linalg.norm(com_vel, axis=1) < MAX_QUIET_SPEED)
        & (np.abs(lift / GRAVITY - 1.0) < MAX_QUIET_ACCELERATION)
        & (height > MIN_PELVIS_HEIGHT)
        & (total > 50.0)
    )
    step = float(np.median(np.diff(time)))
    for rest in runs(quiet):
        if (rest.stop - rest.start) * step < MIN_REST:
            quiet[rest] = False
    if not quiet.any():
        return None
    mass = float(np.median(total[quiet]) / GRAVITY)
    return MeasuredMass(mass, float(quiet.sum() * step), "standing")


def weigh_gait(
    time: Float[Array, " n_frames"],
    forces: FootForces,
    events: Sequence[GaitEvent],
    cycles: Sequence[Cycle],
    lift: Float[Array, " n_frames"],
) -> MeasuredMass | None:
    """Return the body mass in gait; None if too few forces are known.

    Args:
        time: Time of each frame [s].
        forces: Ground reaction on each foot, filtered like the motion.
        events: Gait events in order of time.
        lift: Vertical acceleration of the centre of mass plus gravity [m/s²].
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
    if seconds < MIN_GAIT or not total > 0:
        return None
    return MeasuredMass(float(total / lift[known].sum()), seconds, "gait")


def weigh_jumps(
    time: Float[Array, " n_frames"], forces: FootForces, lift: Float[Array, " n_frames"]
) -> MeasuredMass | None:
    """Return the body mass in contacts between two flights; None without any.

    Args:
        time: Time of each frame [s].
        forces: Ground reaction on each foot, filtered like the motion.
        lift: Vertical acceleration of the centre of mass plus gravity [m/s²].
    """
    total, step = forces.force[..., 2].sum(axis=1), float(np.median(np.diff(time)))
    margin = int(np.ceil(FLIGHT_MARGIN / step))
    weighed = np.zeros(len(time), dtype=bool)
    for run in runs(total > 0.0):
        a, b = run.start - margin, run.stop + margin
        if a < 0 or b > len(time) or not forces.valid[a:b].all():
            continue
        if not total[a : run.start].any() and not total[run.stop : b].any():
            weighed[a:b] = True
    seconds, needed = float((weighed & (total > 0.0)).sum() * step), float(lift[weighed].sum())
    if seconds < MIN_GAIT or not needed > 0.0:
        return None
    return MeasuredMass(float(total[weighed].sum()) / needed, seconds, "jumps")

"""Repetition of a single recorded gait cycle; many files hold exactly one, meant to be looped.

A file with one cycle has no two heel strikes of one foot. If its last posture and velocity match
the first, the cycle is repeated; each repetition continues from the pelvis position and heading at
the end of the previous one. The closing error is distributed evenly over the cycle. Some files hold
half a cycle, whose end is the mirror image of its beginning; they continue with their mirror image.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float, root_mean_square
from plantigrade.constants import SIDES
from plantigrade.models import Human
from plantigrade.models.mirror import mirrored_name
from plantigrade.spatial.conventions import (
    about_vertical,
    facing,
    turned,
    wxyz_to_xyzw,
    xyzw_to_wxyz,
)

LEG_COORDINATES = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")
AXIAL_COORDINATES = ("bending", "rotation")  # trunk coordinates that change sign under mirroring


@dataclass(frozen=True, kw_only=True)
class LoopSettings:
    """Criteria for a closed motion; differences are the RMS over the leg coordinates."""

    max_posture_error: float = float(np.deg2rad(6.0))
    """Maximum difference of the end postures [rad]. Measured cycles differ by 1° to 4°; postures
    half a cycle apart differ by about 20°."""
    max_velocity_error: float = 0.9
    """Maximum difference of the end velocities, relative to the RMS velocity of the cycle [1]. Two
    independent instants of a motion differ by √2."""
    repeat_ratio: float = 2.0
    """Maximum ratio of the end postures' distance to the distance one frame later for which the
    last frame repeats the first [1]. Above one, because most files repeat the first frame."""
    min_period: float = 0.6
    """Minimum period of a whole cycle [s]. Chosen."""
    max_period: float = 3.0
    """Maximum period of a whole cycle [s]. Chosen."""
    min_speed: float = 0.1
    """RMS joint velocity of the legs below which the body stands still [rad/s]. Chosen."""
    min_frames: int = 10
    """Minimum number of frames. Chosen."""


@dataclass(frozen=True)
class Loop:
    """Closure of a motion that can be repeated."""

    period: float  #: Duration until the motion closes [s]
    #: Whether the last frame repeats the first; otherwise the frame after the last would
    repeats_first_frame: bool
    mirrored: bool = False  #: Whether the motion is half a cycle, which closes on its mirror image


def find_loop(
    human: Human, time: Float[Array, " n_frames"], qpos: Float[Array, "n_frames nq"]
) -> Loop | None:
    """Return the closure of an evenly sampled motion; None if it does not close or stands still."""
    n, s = len(time), LoopSettings()
    if n < s.min_frames or not np.isfinite(qpos).all():
        return None
    columns = [7 + human.hinge(f"{name}_{side}") for name in LEG_COORDINATES for side in SIDES]
    step = (time[-1] - time[0]) / (n - 1)
    legs = qpos[:, columns]
    rates = np.diff(legs, axis=0) / step
    rms_rate = root_mean_square(rates)
    if rms_rate < s.min_speed:
        return None
    for mirrored in (False, True):
        image = mirror(human, qpos)[:, columns] if mirrored else legs
        first_rate = (image[1] - image[0]) / step
        gap = image[0] - legs[-1]
        gap_after = gap - 0.5 * step * (first_rate + rates[-1])
        repeats_first_frame = bool(
            np.linalg.norm(gap) <= s.repeat_ratio * np.linalg.norm(gap_after)
        )
        misfit = root_mean_square(gap if repeats_first_frame else gap_after)
        rate_error = root_mean_square(first_rate - rates[-1])
        period = float(step * (n - 1 if repeats_first_frame else n))
        whole = 2 * period if mirrored else period
        closes = misfit <= s.max_posture_error and rate_error <= s.max_velocity_error * rms_rate
        if closes and s.min_period <= whole <= s.max_period:
            return Loop(period, repeats_first_frame, mirrored)
    return None


def mirror(human: Human, qpos: Float[Array, "n nq"]) -> Float[Array, "n nq"]:
    """Return the mirror image of a motion about the x-z plane, with right and left exchanged."""
    image = qpos.copy()
    image[:, 1] *= -1
    image[:, [4, 6]] *= -1  # turns about x and z
    names = human.joint_names[1:]
    for i, name in enumerate(names):
        if (other := mirrored_name(name)) != name:
            image[:, 7 + i] = qpos[:, 7 + names.index(other)]
        elif name.endswith(AXIAL_COORDINATES):
            image[:, 7 + i] *= -1
    return image


def repeat_cycle(
    human: Human,
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    loop: Loop,
    *,
    times: int = 3,
) -> tuple[Float[Array, " n"], Float[Array, "n nq"]]:
    """Return a repeated motion; each repetition starts where the previous one ended.

    Args:
        time: Time of each frame [s], evenly spaced.
        qpos: The motion of one cycle or of half a cycle.

    Returns:
        Time [s] and configurations.
    """
    n = len(time)
    m = n - 1 if loop.repeats_first_frame else n  # frames until it closes
    image = mirror(human, qpos) if loop.mirrored else qpos
    # If the first frame is not repeated, one more step at the mean rate of both ends follows.
    last, heading = qpos[-1].copy(), _heading(qpos)
    turn = heading[-1] - heading[0]
    if not loop.repeats_first_frame:
        last += 0.5 * (image[1] - image[0] + qpos[-1] - qpos[-2])
        turn += 0.5 * (np.diff(_heading(image[:2]))[0] + heading[-1] - heading[-2])
    gap = image[0] - last
    upright = _rotations(turned(qpos[:, 3:7], -heading))
    initial = _rotations(turned(image[0, 3:7], -_heading(image[:1])[0]))
    lean = (initial * upright[-1].inv()).as_rotvec() if loop.repeats_first_frame else np.zeros(3)
    share = (np.arange(m) / m)[:, None]
    one = qpos[:m].copy()
    one[:, 2] += gap[2] * share[:, 0]
    one[:, 7:] += gap[7:] * share
    leaning = Rotation.from_rotvec(lean * share) * upright[:m]
    one[:, 3:7] = turned(xyzw_to_wxyz(leaning.as_quat()), heading[:m])
    pieces = [(one, heading[0], turn, last[:2] - qpos[0, :2])]
    if loop.mirrored:
        pieces.append((mirror(human, one), -heading[0], -turn, pieces[0][3] * [1.0, -1.0]))
    cycles, place, facing = [], qpos[0, :2], heading[0]
    for _ in range(times):
        for piece, begin, more, way in pieces:
            flat = about_vertical(facing - begin)[:2, :2]
            cycle = piece.copy()
            cycle[:, :2] = place + (piece[:, :2] - piece[0, :2]) @ flat.T
            cycle[:, 3:7] = turned(piece[:, 3:7], facing - begin)
            cycles.append(cycle)
            place, facing = place + flat @ way, facing + more
    whole = np.concatenate(cycles)
    return time[0] + loop.period / m * np.arange(len(whole)), whole


def _rotations(quat: Float[Array, "*n 4"]) -> Rotation:
    return Rotation.from_quat(wxyz_to_xyzw(quat))


def _heading(qpos: Float[Array, "n nq"]) -> Float[Array, " n"]:
    """Return the heading of the pelvis about the vertical [rad]."""
    x, y = facing(qpos[:, 3:7]).T
    return np.unwrap(np.arctan2(y, x))

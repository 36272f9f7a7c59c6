"""Repetition of one recorded gait cycle; many files hold exactly one, meant to be looped.

Such a file shows no two heel strikes of one foot. Where its end meets its beginning (the same
posture, moving the same way, a step further on) it is continued with itself: every repetition
starts where and in which direction the pelvis of the one before ended. What does not quite meet is
spread evenly over the cycle. Some files hold half a cycle, whose end is the mirror image of its
beginning; they are continued with their mirror image.
"""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.models import Human
from plantigrade.spatial.conventions import wxyz_to_xyzw, xyzw_to_wxyz

LEG = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")
TURNED = ("bending", "rotation")  # coordinates of the middle that change sign in a mirror


@dataclass(frozen=True, kw_only=True)
class LoopSettings:
    """When a motion closes on itself; differences are those of the legs, root mean square."""

    max_posture_error: float = float(np.deg2rad(6.0))
    """Greatest difference of the postures at its ends [rad]. Measured cycles differ by one to four
    degrees; a posture half a cycle off differs by some 20°."""
    max_velocity_error: float = 0.9
    """Greatest difference of their velocities, by the velocity of the whole cycle. Between two
    independent instants of one motion it is √2."""
    repeat_ratio: float = 2.0
    """Distance of the ends' postures, by that of the posture one frame on, up to which the last
    frame shows the first again. Files usually end so; that they do not must show."""
    min_period: float = 0.6
    """Shortest period of a whole cycle [s]. Chosen."""
    max_period: float = 3.0
    """Longest [s]. Chosen."""
    min_speed: float = 0.1
    """Velocity of the legs below which a motion rests [rad/s]. Chosen."""
    min_frames: int = 10
    """Fewest frames of a motion that may close. Chosen."""


@dataclass(frozen=True)
class Loop:
    """How a motion closes on itself.

    Attributes:
        period: Duration until it does [s].
        ending: Whether the last frame shows the first again; else the next one would.
        mirrored: Whether it closes on its mirror image: half a cycle.
    """

    period: float
    ending: bool
    mirrored: bool = False


def find_loop(
    human: Human,
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    settings: LoopSettings | None = None,
) -> Loop | None:
    """Return how an evenly sampled motion closes on itself; None if it does not, or rests."""
    n, s = len(time), settings or LoopSettings()
    if n < s.min_frames or not np.isfinite(qpos).all():
        return None
    columns = [7 + human.hinge(f"{name}_{side}") for name in LEG for side in SIDES]
    step = (time[-1] - time[0]) / (n - 1)
    legs = qpos[:, columns]
    rates = np.diff(legs, axis=0) / step
    usual = np.sqrt(np.mean(rates**2))
    if usual < s.min_speed:
        return None
    for mirrored in (False, True):
        image = mirror(human, qpos)[:, columns] if mirrored else legs
        begins = (image[1] - image[0]) / step
        gap = image[0] - legs[-1]
        onward = gap - 0.5 * step * (begins + rates[-1])
        ending = bool(np.linalg.norm(gap) <= s.repeat_ratio * np.linalg.norm(onward))
        misfit = np.sqrt(np.mean((gap if ending else onward) ** 2))
        turned = np.sqrt(np.mean((begins - rates[-1]) ** 2))
        period = float(step * (n - 1 if ending else n))
        whole = 2 * period if mirrored else period
        alike = misfit <= s.max_posture_error and turned <= s.max_velocity_error * usual
        if alike and s.min_period <= whole <= s.max_period:
            return Loop(period, ending, mirrored)
    return None


def mirror(human: Human, qpos: Float[Array, "n nq"]) -> Float[Array, "n nq"]:
    """Return a motion seen in a mirror that stands along x: right is left, left is right."""
    image = qpos.copy()
    image[:, 1] *= -1
    image[:, [4, 6]] *= -1  # turns about x and z
    names = human.joint_names[1:]
    for i, name in enumerate(names):
        if name.endswith(("_r", "_l")):
            other = name[:-1] + ("l" if name.endswith("r") else "r")
            image[:, 7 + i] = qpos[:, 7 + names.index(other)]
        elif name.endswith(TURNED):
            image[:, 7 + i] *= -1
    return image


def unroll(
    human: Human,
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    loop: Loop,
    *,
    times: int = 3,
) -> tuple[Float[Array, " n"], Float[Array, "n nq"]]:
    """Return a motion repeated, each repetition starting where the previous one ended.

    Args:
        human: The person.
        time: Time of each frame [s], evenly spaced.
        qpos: The motion of one cycle, or of half a cycle.
        loop: How it closes.
        times: Number of whole cycles.

    Returns:
        Time [s] and configurations.
    """
    n = len(time)
    m = n - 1 if loop.ending else n  # frames until it closes
    image = mirror(human, qpos) if loop.mirrored else qpos
    # How it goes on after its last frame: not at all, or by one more step at the mean of both ends.
    last, heading = qpos[-1].copy(), _heading(qpos)
    turn = heading[-1] - heading[0]
    if not loop.ending:
        last += 0.5 * (image[1] - image[0] + qpos[-1] - qpos[-2])
        turn += 0.5 * (np.diff(_heading(image[:2]))[0] + heading[-1] - heading[-2])
    gap = image[0] - last
    upright = _about_vertical(-heading) * _root(qpos)
    begins = (_about_vertical(-_heading(image[:1])) * _root(image[:1]))[0]
    lean = (begins * upright[-1].inv()).as_rotvec() if loop.ending else np.zeros(3)
    share = (np.arange(m) / m)[:, None]
    one = qpos[:m].copy()
    one[:, 2] += gap[2] * share[:, 0]
    one[:, 7:] += gap[7:] * share
    leaning = Rotation.from_rotvec(lean * share) * upright[:m]
    one[:, 3:7] = xyzw_to_wxyz((_about_vertical(heading[:m]) * leaning).as_quat())
    pieces = [(one, heading[0], turn, last[:2] - qpos[0, :2])]
    if loop.mirrored:
        pieces.append((mirror(human, one), -heading[0], -turn, pieces[0][3] * [1.0, -1.0]))
    cycles, place, facing = [], qpos[0, :2], heading[0]
    for _ in range(times):
        for piece, begin, more, way in pieces:
            turned = _about_vertical(np.full(1, facing - begin))[0]
            flat = turned.as_matrix()[:2, :2]
            cycle = piece.copy()
            cycle[:, :2] = place + (piece[:, :2] - piece[0, :2]) @ flat.T
            cycle[:, 3:7] = xyzw_to_wxyz((turned * _root(piece)).as_quat())
            cycles.append(cycle)
            place, facing = place + flat @ way, facing + more
    whole = np.concatenate(cycles)
    return time[0] + loop.period / m * np.arange(len(whole)), whole


def _root(qpos: Float[Array, "n nq"]) -> Rotation:
    """Return the rotations of the root."""
    return Rotation.from_quat(wxyz_to_xyzw(qpos[:, 3:7]))


def _heading(qpos: Float[Array, "n nq"]) -> Float[Array, " n"]:
    """Return the direction the pelvis faces, about the vertical [rad]."""
    forward = _root(qpos).apply([1.0, 0.0, 0.0])
    return np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))


def _about_vertical(angle: Float[Array, " n"]) -> Rotation:
    """Return rotations about the vertical."""
    return Rotation.from_rotvec(angle[:, None] * [0.0, 0.0, 1.0])

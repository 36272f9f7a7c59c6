"""One recorded cycle of walking, repeated: many files hold exactly one, meant to be looped.

Such a file shows no two heel strikes of one foot. Where its end meets its beginning (the same
posture, moving the same way, a step further on) it is continued with itself: every repetition
starts where and in which direction the pelvis of the one before ended. What does not quite meet is
spread evenly over the cycle.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.models import Human
from plantigrade.spatial.conventions import wxyz_to_xyzw, xyzw_to_wxyz

LEG = ("hip_flexion", "hip_adduction", "knee_angle", "ankle_angle")
# A posture half a cycle off differs by some 20° on the mean over these joints; measured cycles
# differ by one to four.
POSTURE = np.deg2rad(6.0)  # of the legs, root mean square [rad]
# Of two independent instants of one motion, the difference of velocities has √2 times its spread.
VELOCITY = 0.9  # of the legs, root mean square, in that of the whole cycle
# Files usually end with the frame they begin with; that they do not must show.
CLEARLY = 2.0
SHORTEST, LONGEST = 0.6, 3.0  # of one cycle [s]


@dataclass(frozen=True)
class Loop:
    """How a motion closes on itself.

    Attributes:
        period: Duration of a cycle [s].
        ending: Whether the last frame shows the first again; else the next one would.
    """

    period: float
    ending: bool


def find_loop(
    human: Human, time: Float[Array, " n_frames"], qpos: Float[Array, "n_frames nq"]
) -> Loop | None:
    """Return how a motion closes on itself; None where it does not, or does not move.

    Args:
        human: The person.
        time: Time of each frame [s], evenly spaced.
        qpos: The motion.
    """
    n = len(time)
    if n < 10 or not np.isfinite(qpos).all():
        return None
    columns = [7 + human.hinge(f"{name}_{side}") for name in LEG for side in ("r", "l")]
    step = (time[-1] - time[0]) / (n - 1)
    legs = qpos[:, columns]
    rates = np.diff(legs, axis=0) / step
    usual = np.sqrt(np.mean(rates**2))
    if usual < 0.1:
        return None
    gap = legs[0] - legs[-1]
    onward = gap - 0.5 * step * (rates[0] + rates[-1])
    ending = bool(np.linalg.norm(gap) <= CLEARLY * np.linalg.norm(onward))
    misfit = np.sqrt(np.mean((gap if ending else onward) ** 2))
    turned = np.sqrt(np.mean((rates[0] - rates[-1]) ** 2))
    period = step * (n - 1 if ending else n)
    if misfit > POSTURE or turned > VELOCITY * usual or not SHORTEST <= period <= LONGEST:
        return None
    return Loop(period, ending)


def unroll(
    time: Float[Array, " n_frames"],
    qpos: Float[Array, "n_frames nq"],
    loop: Loop,
    *,
    times: int = 3,
) -> tuple[Float[Array, " n"], Float[Array, "n nq"]]:
    """Return a motion repeated: each repetition goes on where the one before ended.

    Args:
        time: Time of each frame [s], evenly spaced.
        qpos: The motion of one cycle.
        loop: How it closes.
        times: Number of cycles.

    Returns:
        Time [s] and configurations.
    """
    from scipy.spatial.transform import Rotation

    n = len(time)
    m = n - 1 if loop.ending else n  # frames of one cycle
    root = Rotation.from_quat(wxyz_to_xyzw(qpos[:, 3:7]))
    forward = root.apply([1.0, 0.0, 0.0])
    heading = np.unwrap(np.arctan2(forward[:, 1], forward[:, 0]))
    upright = _about_vertical(-heading) * root
    # What is left at the end of a cycle: the last frame, or one more step at the mean of both ends.
    onward = np.zeros(qpos.shape[1])
    turn = heading[-1] - heading[0]
    if not loop.ending:
        onward = 0.5 * (qpos[1] - qpos[0] + qpos[-1] - qpos[-2])
        turn += 0.5 * (heading[1] - heading[0] + heading[-1] - heading[-2])
    gap = qpos[0] - qpos[-1] - onward
    lean = (upright[0] * upright[-1].inv()).as_rotvec() if loop.ending else np.zeros(3)
    share = (np.arange(m) / m)[:, None]
    one = qpos[:m].copy()
    one[:, 2] += gap[2] * share[:, 0]
    one[:, 7:] += gap[7:] * share
    upright = Rotation.from_rotvec(lean * share) * upright[:m]
    way = -gap[:2]
    cycles, place = [], qpos[0, :2]
    for k in range(times):
        turned = _about_vertical(np.full(1, k * turn)).as_matrix()[0, :2, :2]
        cycle = one.copy()
        cycle[:, :2] = place + (one[:, :2] - qpos[0, :2]) @ turned.T
        cycle[:, 3:7] = xyzw_to_wxyz((_about_vertical(heading[:m] + k * turn) * upright).as_quat())
        cycles.append(cycle)
        place = place + turned @ way
    return time[0] + loop.period / m * np.arange(m * times), np.concatenate(cycles)


def _about_vertical(angle: Float[Array, " n"]):
    """Return rotations about the vertical."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(angle[:, None] * [0.0, 0.0, 1.0])

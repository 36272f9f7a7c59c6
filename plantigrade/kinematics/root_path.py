"""Path of the pelvis in motions without one: the stance foot stays at its position."""

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.models import Human
from plantigrade.motion.filters import lowpass
from plantigrade.spatial.conventions import rotation_matrix

MIN_PASSING_SPEED = 0.3  # [m/s] minimum relative speed of feet that pass each other
MAX_STANCE_HEIGHT = 0.04  # [m] maximum height of the stance foot above the other
PELVIS_CUTOFF = 6.0  # [Hz] low-pass of the pelvis in walking [Winter2009]_


def forward_path(
    human: Human, qpos: Float[Array, "n_frames nq"], *, rate: float, vertical: bool = True
) -> Float[Array, "n_frames nq"]:
    """Return the motion with a root path on which the standing foot stays where it is.

    For motions that say nothing of where the pelvis goes. In every step of time the points of
    the soles nearest to the ground stand still on the mean. The standing foot is the lower one; of
    two feet that pass each other near the ground it is the one that falls behind the pelvis (in
    walking backward: that gets ahead of it), for a swinging foot may come as near to the ground as
    the standing one. How fast the pelvis goes is smoothed: with angles that are not those of this
    body it would jump by 1 m/s from one foot to the other.

    Args:
        qpos: The motion; its horizontal root position is replaced.
        rate: Frames per second [Hz].
        vertical: Whether the height is replaced too: lowest point of the standing foot at 0.
    """
    n = len(qpos)
    result = qpos.copy()
    result[:, :2] = 0.0
    contact = sole_paths(human, result)
    position, sides = contact.position, np.array([SIDES.index(s.side) for s in contact.sites])
    bottom = position[..., 2].min(axis=1)
    close = np.exp(-(position[..., 2] - bottom[:, None]) / 0.006)
    close *= _falls_behind(result, position, sides, rate)
    step = np.zeros((n, 2))
    for k in range(n - 1):
        w = close[k] + close[k + 1]
        moved = position[k + 1, :, :2] - position[k, :, :2]
        step[k + 1] = -(w @ moved) / w.sum()
    if rate > 3.0 * PELVIS_CUTOFF:
        step[1:] = lowpass(np.arange(1, n) / rate, step[1:], cutoff=PELVIS_CUTOFF)
    result[:, :2] = np.cumsum(step, axis=0)
    if vertical:
        result[:, 2] -= bottom
    return result


def _falls_behind(qpos, position, sides, rate: float) -> Float[Array, "n_frames n_points"]:
    """Return 1 for points of feet that may stand, nearly 0 for those of a foot that swings past.

    The motion has the pelvis on one spot.
    """
    ahead = rotation_matrix(qpos[:, 3:7])[:, :2, 0]
    ahead = ahead / np.maximum(np.linalg.norm(ahead, axis=1), 1e-9)[:, None]
    speed, low = np.empty((len(qpos), 2)), np.empty((len(qpos), 2))
    for k in (0, 1):
        mine = position[:, sides == k]
        moved = np.gradient(mine[..., :2].mean(axis=1), axis=0) * rate
        speed[:, k] = np.einsum("nd,nd->n", moved, ahead)
        low[:, k] = mine[..., 2].min(axis=1)
    apart = np.abs(speed[:, 0] - speed[:, 1]) > MIN_PASSING_SPEED
    passing = apart & (np.abs(low[:, 0] - low[:, 1]) < MAX_STANCE_HEIGHT)
    behind, rows = speed.argmin(axis=1), np.arange(len(qpos))
    # Walking forward, the foot that falls behind is the lower one on the mean; backward, the other.
    if np.sum((low[rows, behind] - low[rows, 1 - behind])[apart]) > 0:
        behind = 1 - behind
    may = np.ones(position.shape[:2])
    may[passing[:, None] & (sides[None] != behind[:, None])] = 1e-3
    return may

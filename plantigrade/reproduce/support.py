r"""The path of the centre of mass that the soles can carry.

With mass :math:`m`, angular momentum :math:`L` and gravity :math:`g`, a centre of mass at height
:math:`z` has its zero-moment point on the ground at

.. math:: p = c - a \, \ddot c - \ell, \qquad a = \frac{z}{\ddot z + g},

(:math:`\ell` is the share of :math:`\dot L`). Forces can only be found where :math:`p` lies in the
hull of the points that touch; a recorded motion, smoothed and fitted to somebody else's masses,
now and then has it outside. Moving :math:`p` by :math:`\delta p` into the hull takes the
centre of mass by :math:`\delta c`,

.. math:: \delta c - a \, \delta \ddot c = \delta p,

with :math:`\delta c = 0` at both ends: the one solution that does not fall over, which begins to
give way a few tenths of a second before.
"""

import numpy as np
from scipy.linalg import solve_banded
from scipy.optimize import nnls

from plantigrade.arrays import Array, Float
from plantigrade.constants import GRAVITY
from plantigrade.dynamics.centroid import centroid
from plantigrade.kinematics.sole_paths import sole_paths
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.reproduce.reference import Reference
from plantigrade.reproduce.schedule import ContactSchedule

LIGHTEST = 0.3  # a body that is carried by less than this hardly stands [body weights]


def carried_path(reference: Reference, schedule: ContactSchedule) -> Trajectory:
    """Return the path of the centre of mass nearest to the recorded one that soles can carry."""
    human, motion, time = reference.human, reference.motion, reference.motion.time
    whole = centroid(human, motion.qpos, motion.qvel, motion.qacc)
    assert whole.force is not None and whole.zmp is not None
    weight = human.mass * GRAVITY
    place = sole_paths(human, motion.qpos).position[:, :, :2]
    away = np.zeros((len(time), 2))
    for k, t in enumerate(time):
        on = schedule(float(t))
        if on.any() and np.isfinite(whole.zmp[k]).all():
            away[k] = into_hull(place[k, on], whole.zmp[k, :2])
    inside = (time >= reference.start) & (time <= reference.stop)
    moved = np.zeros((len(time), 3))
    push = np.maximum(whole.force[inside, 2], LIGHTEST * weight)
    moved[inside, :2] = give_way(
        time[inside], whole.com[inside, 2] * human.mass / push, away[inside]
    )
    return Trajectory(time, whole.com + moved)


def into_hull(points: Float[Array, "n 2"], place: Float[Array, " 2"]) -> Float[Array, " 2"]:
    """Return the shortest way from a place into the convex hull of points [m]."""
    about = points - place
    firm = 1e3 * max(1.0, float(np.abs(about).max()))  # holds the sum of the shares at one
    matrix = np.vstack([about.T, np.full(len(points), firm)])
    share = nnls(matrix, np.array([0.0, 0.0, firm]))[0]
    return share @ about / share.sum()


def give_way(
    time: Float[Array, " n"], a: Float[Array, " n"], away: Float[Array, "n 2"]
) -> Float[Array, "n 2"]:
    """Return the solution of the boundary value problem of this module [m]."""
    n = len(time)
    if n < 3 or not away.any():
        return np.zeros_like(away)
    h = (time[-1] - time[0]) / (n - 1)
    band = np.zeros((3, n))
    band[1] = 1.0
    band[1, 1:-1] += 2 * a[1:-1] / h**2
    band[0, 2:] = band[2, :-2] = -a[1:-1] / h**2
    right = away.copy()
    right[[0, -1]] = 0.0
    return solve_banded((1, 1), band, right)

r"""A feasible path of the centre of mass: as recorded, with the pressure inside the support.

A body whose angular momentum rests is a pendulum: with :math:`k = (z - z_0) / (g + \ddot z)`, its
centre of mass :math:`c` over the ground and the centre of pressure :math:`p`,

.. math:: p = c - k \ddot c .

Where the :math:`p` of a motion is outside of what its feet span (mass that is elsewhere than the
model's, a foot taken to be down that is not, noise), it is brought to the nearest place towards
their middle that is inside; and from there on the equation is read the other way, as a boundary
value problem for :math:`c`, over the pressure at its beginning and at its end.
Its solution is :math:`p` smoothed over :math:`\sqrt k`, some 0.3 s to both sides: the body leans
before it has to, and stays close to the motion, for a bounded change of the
pressure cannot move it farther than that change. Postures follow by the least change of joints that
leaves both feet where they are.
"""

from dataclasses import replace

import numpy as np
from scipy.linalg import solve_banded

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY, SIDES
from plantigrade.control.balance.postures import rates_of
from plantigrade.control.balance.reference import MotionReference
from plantigrade.control.gait.step import StepSettings
from plantigrade.control.gait.support import inside
from plantigrade.kinematics.state import State, integrate
from plantigrade.models import Human
from plantigrade.motion import Motion

CARRIED = 0.3
"""The ground carries at least so much of the body where feet press, in this sum [body weights]."""
LEAST = 3
"""Fewer points span nothing: the motion is left as it is."""
FOOT, OVER, HIGH, ROOT, JOINT = 30.0, 30.0, 10.0, 1.0, 0.3
"""How much the rows of a posture weigh: feet that stay, centre of mass over the ground and its
height, root, joints."""
ROUNDS = 2
"""Gauss-Newton steps of every posture."""


def feasible_path(
    time: Float[Array, " n"],
    com: Float[Array, "n 3"],
    places: Float[Array, "n n_sites 3"],
    presses: Bool[Array, "n n_sites"],
) -> Float[Array, "n 3"]:
    """Return the path of the centre of mass with the pressure inside the support throughout.

    Args:
        time: Evenly spaced [s].
        com: The path [m].
        places: Where the contact spheres of the feet are [m].
        presses: Which of them press.
    """
    n = len(time)
    if n < 3:
        return com
    step = float(time[-1] - time[0]) / (n - 1)
    bend = np.zeros_like(com)
    bend[1:-1] = np.diff(com, 2, axis=0) / step**2
    k, pressure = np.zeros(n), com[:, :2].copy()
    for i in range(n):
        points = places[i, presses[i]]
        if len(points) < LEAST:
            k[i] = -1.0
            continue
        k[i] = (com[i, 2] - points[:, 2].mean()) / max(GRAVITY + bend[i, 2], CARRIED * GRAVITY)
        pressure[i] = inside(
            points[:, :2], com[i, :2] - k[i] * bend[i, :2], StepSettings.support_margin
        )
    free = k < 0
    k[free] = np.maximum(com[free, 2], 0.1) / GRAVITY
    pressure[free] = com[free, :2] - k[free, None] * bend[free, :2]
    across = k / step**2
    matrix = np.zeros((3, n))
    matrix[0, 2:], matrix[1], matrix[2, :-2] = -across[1:-1], 1 + 2 * across, -across[1:-1]
    matrix[1, [0, -1]] = 1.0
    return np.column_stack([solve_banded((1, 1), matrix, pressure), com[:, 2]])


def feasible_motion(human: Human, reference: MotionReference) -> Motion:
    """Return a motion whose centre of mass stays where the feet can carry it.

    Args:
        human: The person.
        reference: The motion, and which spheres are on the ground in it.
    """
    motion = reference.motion
    com = feasible_path(reference.time, reference.com, reference.spheres, reference.contact)
    feet = [human.body(f"foot_{side}") for side in SIDES]
    state, qpos = State(human, motion.qpos[0]), motion.qpos.copy()
    nv = human.model.nv
    own = np.concatenate([np.full(6, ROOT), np.full(nv - 6, JOINT)])
    for q, wanted in zip(qpos, com, strict=True):
        state = state.moved_to(q)
        start, places = q.copy(), np.array([state.origin(foot) for foot in feet])
        turns = [state.rotation(foot).copy() for foot in feet]
        for k in range(ROUNDS):
            state = state.moved_to(q) if k else state
            J, _, _ = state.touched(np.array(feet), places)
            off = places - [state.origin(foot) for foot in feet]
            rows = [FOOT * J.reshape(6, -1), state.com_jacobian * [[OVER], [OVER], [HIGH]]]
            right = [FOOT * off.ravel(), (wanted - state.com) * [OVER, OVER, HIGH]]
            for foot, turn in zip(feet, turns, strict=True):
                rows.append(FOOT * state.angular_jacobian(foot))
                away = np.cross(state.rotation(foot), turn, axis=0).sum(axis=1)
                right.append(0.5 * FOOT * away)
            A, b, back = np.concatenate(rows), np.concatenate(right), -state.difference(start)
            step = np.linalg.solve(A.T @ A + np.diag(own**2), A.T @ b + own**2 * back)
            q[:] = integrate(state.model, state.qpos, step)
            q[7:] = np.clip(q[7:], *human.limits)
    return replace(motion, qpos=qpos, qvel=rates_of(human, qpos, motion.rate), qacc=None)

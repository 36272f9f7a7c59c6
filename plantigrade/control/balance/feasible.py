r"""A feasible path of the centre of mass: as recorded, with the pressure inside the support.

A body whose angular momentum rests is a pendulum: with :math:`k = (z - z_0) / (g + \ddot z)`, its
centre of mass :math:`c` over the ground and the centre of pressure :math:`p`,

.. math:: p = c - k \ddot c .

Where the :math:`p` of a motion is outside the support (mass distributed otherwise than the model's,
a foot taken to be down that is not, noise), it is brought straight towards the middle until it is
inside; and from there on the equation is read the other way, as a boundary value problem for
:math:`c`, over the pressure at its beginning and at its end.
Its solution is :math:`p` smoothed over :math:`\sqrt k`, some 0.3 s to both sides: the body leans
before it has to, and stays close to the motion, for a bounded change of the
pressure cannot move it farther than that change. Postures follow by the least change of joints that
leaves both feet where they are.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import solve_banded

from plantigrade.arrays import Array, Bool, Float
from plantigrade.constants import GRAVITY
from plantigrade.control.balance.postures import (
    N_ITERATIONS,
    PostureSolverSettings,
    posture_step,
    velocities_of,
)
from plantigrade.control.balance.reference import MotionReference
from plantigrade.control.gait.loads import LoadSettings
from plantigrade.control.gait.pendulum_state import MIN_PENDULUM_HEIGHT
from plantigrade.control.gait.step import StepSettings
from plantigrade.control.gait.support import inside
from plantigrade.kinematics.state import BodyState
from plantigrade.models import Human
from plantigrade.motion import Motion
from plantigrade.wbc.rows import Rows
from plantigrade.wbc.tasks.point import axis_error


@dataclass(frozen=True, kw_only=True)
class FeasibleSettings:
    """Path of the centre of mass, and weights of the postures that follow it."""

    support_margin: float = StepSettings.support_margin
    """Distance of the pressure from the edge of the support [m]; as for balance."""
    min_load: float = LoadSettings.min_unknown_load
    """Least load on the feet while they are on the ground [body weights]; as of feet of which
    nothing is known."""
    solver: PostureSolverSettings = PostureSolverSettings()
    """Weights of the postures, as in scripts; feet and the centre of mass over the ground count as
    ankles do."""


def feasible_path(
    time: Float[Array, " n"],
    com: Float[Array, "n 3"],
    spheres: Float[Array, "n n_sites 3"],
    contact: Bool[Array, "n n_sites"],
    settings: FeasibleSettings | None = None,
) -> Float[Array, "n 3"]:
    """Return the path of the centre of mass with the pressure inside the support throughout.

    Args:
        time: Evenly spaced [s].
        com: The path [m].
        spheres: Positions of the contact spheres of the feet [m].
        contact: Which of them are on the ground; fewer than three span no support.
    """
    s, n = settings or FeasibleSettings(), len(time)
    if n < 3:
        return com
    step = float(time[-1] - time[0]) / (n - 1)
    acceleration = np.zeros_like(com)
    acceleration[1:-1] = np.diff(com, 2, axis=0) / step**2
    k, pressure, free = np.zeros(n), com[:, :2].copy(), contact.sum(axis=1) < 3
    for i in np.flatnonzero(~free):
        points = spheres[i, contact[i]]
        lift = max(GRAVITY + acceleration[i, 2], s.min_load * GRAVITY)
        k[i] = (com[i, 2] - points[:, 2].mean()) / lift
        needed = com[i, :2] - k[i] * acceleration[i, :2]
        pressure[i] = inside(points[:, :2], needed, s.support_margin)
    free |= k < 0  # a body below its feet, too
    k[free] = np.maximum(com[free, 2], MIN_PENDULUM_HEIGHT) / GRAVITY
    pressure[free] = com[free, :2] - k[free, None] * acceleration[free, :2]
    across = k / step**2
    matrix = np.zeros((3, n))
    matrix[0, 2:], matrix[1], matrix[2, :-2] = -across[1:-1], 1 + 2 * across, -across[1:-1]
    matrix[1, [0, -1]] = 1.0
    return np.column_stack([solve_banded((1, 1), matrix, pressure), com[:, 2]])


def feasible_motion(
    human: Human, reference: MotionReference, settings: FeasibleSettings | None = None
) -> Motion:
    """Return a motion whose centre of mass stays where the feet can carry it.

    Args:
        human: The person.
        reference: The motion, and which spheres are on the ground in it.
        settings: Limits and weights.
    """
    s, motion = settings or FeasibleSettings(), reference.motion
    com = feasible_path(reference.time, reference.com, reference.spheres, reference.contact, s)
    feet = human.both("foot")
    state, qpos = BodyState(human, motion.qpos[0]), motion.qpos.copy()
    solver = s.solver
    own = np.full(human.model.nv, solver.joint_weight)
    own[:6] = solver.pelvis_weight
    hold, com_weight = solver.ankle_weight, np.full(3, solver.ankle_weight)
    com_weight[2] = solver.support_weight
    for q, goal in zip(qpos, com, strict=True):
        state = state.moved_to(q)
        start, positions = q.copy(), np.array([state.origin(foot) for foot in feet])
        rotations = [state.rotation(foot).copy() for foot in feet]
        for k in range(N_ITERATIONS):
            state = state.moved_to(q) if k else state
            J, _, _ = state.touched(np.array(feet), positions)
            moved = positions - [state.origin(foot) for foot in feet]
            rows = [
                Rows(J.reshape(6, -1), moved.ravel(), hold),
                Rows(state.com_jacobian, goal - state.com, com_weight),
            ]
            for foot, rotation in zip(feet, rotations, strict=True):
                turn = axis_error(rotation, state.rotation(foot))
                rows.append(Rows(state.angular_jacobian(foot), turn, hold))
            q[:] = posture_step(state, rows, start, own)
    return replace(motion, qpos=qpos, qvel=velocities_of(human, qpos, motion.rate), qacc=None)

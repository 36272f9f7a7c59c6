r"""A gait from prioritised tasks computed with forces: joint moments and ground reactions.

The unknowns are joint accelerations and contact forces. The acceleration of the root follows from
the equations of motion (:mod:`plantigrade.wbc.forces`), which therefore hold at every instant;
velocities are continuous. The hierarchy, from the top:

0. friction, unilateral contact, joint limits (bounds); strength of the joints; no point of the sole
   below the floor;
1. contact: soles stay where they landed;
2. *task 1*: the swing heel on its path in the horizontal plane, displaced as the body is;
3. *task 2*: the centre of mass on its path, together with the angular momentum about it and the
   ground reaction on each foot; conflicts are resolved by least squares;
4. landing: a heel descends as recorded and reaches the ground at its touchdown time;
5. *task 3*: the posture at the end of each phase, passed at its recorded velocity; finally, small
   contact forces close to those of the previous instant.

Between the postures the body follows the smooth curve through them
(:func:`curve_through`); no other recorded angle is used. A control law
towards the next posture alone becomes stiff as the remaining time shrinks and restarts with each
phase; its bursts of acceleration appear first in the hip moment, which moves the whole leg. The
return to the curve is overdamped because deviations come from the levels above.

During roll-off the foot turns about its toes, and the floor constraint excludes the forefoot: the
ball of a recorded foot dips by a millimetre, and a floor constraint above the contact would
conflict with it.

The ground reactions are those of the recorded motion and the path is consistent with them
(:mod:`plantigrade.ordered_tasks.gait_support`). The ground reactions and the angular momentum are
additions to the paper's three tasks, whose order is kept. Without them the load sharing between
the feet and their internal forces are undetermined: in double support the upper tasks gained a
millimetre of path accuracy for shear of a third of body weight.

During roll-off only the posture task moves the heel: two feet on the ground and a heel path would
leave the pelvis no freedom.

The gains of the centre of mass suit balance: correcting an error :math:`e` with
:math:`\lambda^2 e` moves the centre of pressure by :math:`\lambda^2 e z / g`. At
:math:`\lambda = 7/s`, one centimetre takes five of the foot's twenty-five; the 20/s of
the kinematic hierarchy would take forty.

**The smooth curve** minimises :math:`\int |\dddot q|^2 dt`: a quintic between consecutive postures,
with accelerations at the postures that make the jerk continuous and zero at either end. Cubics
(least acceleration) would have discontinuous accelerations there, and so would joint moments.
"""

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.interpolate import BPoly
from scipy.linalg import solve_banded

from plantigrade.arrays import Array, Float
from plantigrade.dynamics.derivatives import MotionDerivatives, differentiate
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.models import Human
from plantigrade.ordered_tasks.gait import GaitSettings, GaitTasks, gait_order, phase_ends
from plantigrade.ordered_tasks.gait_reference import GaitReference
from plantigrade.ordered_tasks.gait_support import GaitSupport
from plantigrade.ordered_tasks.schedule import ContactSchedule
from plantigrade.spatial.conventions import continuous_poses
from plantigrade.wbc.order import TaskOrder
from plantigrade.wbc.tasks import (
    AngularMomentumTask,
    ComTask,
    ContactTask,
    FloorTask,
    LandingTask,
    PlacingHeelTask,
    PostureTask,
    SoleContactTask,
    Task,
)

DIFFERENCE_STEP = 1e-4  # [s] step of the finite difference of positions


@dataclass(frozen=True, kw_only=True)
class ForcedGaitSettings:
    """Gains of a gait reproduced with forces."""

    com_stiffness: float = 49.0
    """Stiffness of the centre of mass, critically damped; see the module for the value [1/s²]."""
    momentum_stiffness: float = 25.0
    """Stiffness of the integrated angular momentum [1/s²], critically damped. Chosen."""
    momentum_lever: float = 0.5
    """Lever arm that converts a moment error to a force error [m]. Chosen."""
    sole_rate: float = 30.0
    """Rate at which a landing sole comes to rest [1/s]; from 0.3 m/s it stops within 4 mm."""
    posture_stiffness: float = 300.0
    """Stiffness of the posture about its curve [1/s²]. Chosen."""
    posture_damping: float = 50.0
    """Damping of the posture about its curve [1/s]. Chosen above critical (see the module)."""
    curve_interval: float = 0.005
    """Time between samples of the curve [s]. Chosen equal to the time step."""


def forced_order(
    support: GaitSupport,
    tasks: GaitTasks,
    settings: ForcedGaitSettings | None = None,
    gait: GaitSettings | None = None,
) -> TaskOrder:
    """Return the order of tasks that reproduces a recorded gait with forces."""
    reference, com_path, s = support.reference, support.com, settings or ForcedGaitSettings()
    schedule = ContactSchedule(reference)
    levels: list[list[Task]] = []
    for level in gait_order(reference, tasks, schedule, gait).levels:
        kept: list[Task] = []
        for task in level:
            if isinstance(task, ContactTask):
                kept.append(SoleContactTask(schedule.points, schedule, stiffness=s.sole_rate**2))
            elif isinstance(task, FloorTask):
                kept.append(FloorTask(schedule.points, schedule.guarded))
            elif isinstance(task, ComTask):
                task.target = com_path
                task.stiffness, task.damping = s.com_stiffness, 2 * s.com_stiffness**0.5
                kept.append(task)
            elif task.name.startswith("swing heel"):
                side = task.name[-1]
                args = reference.heel_point[side], reference.heel[side], schedule.swing(side)
                kept.append(PlacingHeelTask(*args, com_path, task.name))
            elif not task.name.startswith("rolling"):
                kept.append(task)
        for task in kept:  # the initial state is the recorded one, lifted out of the ground
            task.initialises = isinstance(task, FloorTask)
        if kept:
            levels.append(kept)
    last = max(i for i, level in enumerate(levels) if any(isinstance(t, ComTask) for t in level))
    levels[last].append(_momentum(support, s))
    levels.append([_landing(reference, schedule)])
    return TaskOrder(levels, _posture(reference, tasks, s) if tasks.posture else None)


def _momentum(support: GaitSupport, s: ForcedGaitSettings) -> AngularMomentumTask:
    motion = support.reference.motion
    posture = Trajectory(motion.time, motion.qpos)
    return AngularMomentumTask(
        support.momentum,
        posture,
        turn=support.turn,
        lever=s.momentum_lever,
        stiffness=s.momentum_stiffness,
    )


def _landing(reference: GaitReference, schedule: ContactSchedule) -> LandingTask:
    time, landings, paths = reference.motion.time, [], []
    height = schedule.points.path(reference.motion.qpos)[:, :, 2] - schedule.points.radius
    for contact in reference.contacts:
        mine = (schedule.side == contact.side) & (schedule.region == contact.region)
        if contact.region == "heel" and mine.any():
            landings.append((np.flatnonzero(mine), contact.start))
            paths.append(Trajectory(time, height[:, mine].mean(axis=1)[:, None]))
    return LandingTask(schedule.points, landings, paths)


def _posture(reference: GaitReference, tasks: GaitTasks, s: ForcedGaitSettings) -> PostureTask:
    time = np.concatenate([[reference.start], phase_ends(reference, tasks.phases)])
    passed = np.array([reference.velocity_at(float(t)) for t in time])
    time, curve = curve_through(
        reference.human, time, reference.at(time), passed, interval=s.curve_interval
    )
    q, v, a = (Trajectory(time, values) for values in (curve.qpos, curve.qvel, curve.qacc))
    return PostureTask(
        lambda t: (q(t)[0], v(t)[0], a(t)[0]),
        stiffness=s.posture_stiffness,
        damping=s.posture_damping,
    )


def curve_through(
    human: Human,
    time: Float[Array, " n"],
    postures: Float[Array, "n nq"],
    velocities: Float[Array, "n nv"],
    *,
    interval: float,
) -> tuple[Float[Array, " n_samples"], MotionDerivatives]:
    """Return sample times [s] and the curve with its derivatives at these times.

    Args:
        time: Time of each posture [s], increasing; at least two.
        postures: Configurations; either sign of the quaternion.
        interval: Time between samples [s].
    """
    postures = continuous_poses(postures)
    rates = np.empty_like(postures)
    for posture, velocity, rate in zip(postures, velocities, rates, strict=True):
        ahead, behind = posture.copy(), posture.copy()
        mujoco.mj_integratePos(human.model, ahead, velocity, DIFFERENCE_STEP)
        mujoco.mj_integratePos(human.model, behind, velocity, -DIFFERENCE_STEP)
        rate[:] = (ahead - behind) / (2 * DIFFERENCE_STEP)
    curve = BPoly.from_derivatives(
        time, np.stack([postures, rates, least_jerk_accelerations(time, postures, rates)], axis=1)
    )
    samples = np.linspace(time[0], time[-1], max(int((time[-1] - time[0]) / interval), 1) + 1)
    return samples, differentiate(human, samples, curve(samples), None)


def least_jerk_accelerations(
    time: Float[Array, " n"], values: Float[Array, "n k"], rates: Float[Array, "n k"]
) -> Float[Array, "n k"]:
    """Return the second derivatives of the minimum-jerk curve at its knots."""
    h, rise = np.diff(time)[:, None], np.diff(values, axis=0)
    # jerk of each quintic at its ends, without the contributions of the second derivatives there:
    # -9 a0 / h + 3 a1 / h at the left one, -3 a0 / h + 9 a1 / h at the right one
    left = (60 * rise - h * (36 * rates[:-1] + 24 * rates[1:])) / h**3
    right = (60 * rise - h * (24 * rates[:-1] + 36 * rates[1:])) / h**3
    band, rhs = np.zeros((3, len(time))), np.zeros_like(values)
    band[1, :-1] += 9 / h[:, 0]
    band[1, 1:] += 9 / h[:, 0]
    band[0, 1:] = band[2, :-1] = -3 / h[:, 0]
    rhs[:-1] += left
    rhs[1:] -= right
    return solve_banded((1, 1), band, rhs)

r"""A gait from prioritised tasks computed with forces: joint moments and ground reactions.

The unknowns are joint accelerations and contact forces; the acceleration of the root follows from
the equations of motion (:mod:`plantigrade.wbc.forces`), which therefore hold at every
instant, and between instants nothing jumps. The hierarchy, from the top:

0. friction, unilateral contact, joint limits (bounds); strength of the joints; no point of the sole
   below the floor;
1. contact: soles rest where they landed;
2. *task 1*: the swinging heel on its path in the horizontal plane, displaced as the body is;
3. *task 2*: the centre of mass on its path, with it the angular momentum about it and the ground
   reaction on each foot: where they disagree, all give way;
4. landing: a heel comes down as recorded and is at the ground when it is to touch it;
5. *task 3*: the posture at the end of each phase, passed at its speed, as near as possible; and at
   last the least contact forces, near those of the instant before.

Between the postures the body follows the smooth curve through them
(:mod:`plantigrade.ordered_tasks.posture_curve`): nothing else is known of the recorded angles
there. A law that aims at the next posture alone grows stiff as time runs out and starts anew with
each phase; its bursts of acceleration are seen first in the moment of the hip, which moves the
whole leg. What is off the curve comes back above critical damping: the levels above put it there,
and to swing back would be to fight them.

A foot that rolls off turns about its toes; the floor does not ask its forefoot for more. The ball
of a recorded foot dips by a millimetre, and the floor above the contact would tear at both.

The ground reactions are those of the recorded motion (:mod:`plantigrade.ordered_tasks.support`)
and the path is the one that they carry. They and the angular momentum are ours; the paper's three
tasks and their order are kept. Without them mechanics leaves open how two feet share the load and
push against each other, and in double support the upper tasks bought a millimetre of path with a
third of body weight of shear.

The heel of a foot that rolls off is led by posture alone: two feet on the ground and a heel on its
path would leave the pelvis no freedom.

The gains of the centre of mass are those of a body that balances: to undo an error :math:`e` by
:math:`\lambda^2 e` the centre of pressure must move by :math:`\lambda^2 e z / g`. At
:math:`\lambda = 7/s`, one centimetre takes five of the foot's twenty-five; the 20/s of
the kinematic hierarchy would take forty.
"""

from dataclasses import dataclass

import numpy as np

from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.ordered_tasks.gait import GaitSettings, GaitTasks, gait_order, phase_ends
from plantigrade.ordered_tasks.posture_curve import curve_through
from plantigrade.ordered_tasks.reference import Reference
from plantigrade.ordered_tasks.schedule import ContactSchedule
from plantigrade.ordered_tasks.support import Support
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


@dataclass(frozen=True, kw_only=True)
class ForcedGaitSettings:
    """Gains of a gait that forces move."""

    com_stiffness: float = 49.0
    """Stiffness of the centre of mass, critically damped, as of a body that balances (see the
    module) [1/s²]."""
    momentum_stiffness: float = 25.0
    """Stiffness of the whole body's turn [1/s²], critically damped. Chosen."""
    momentum_lever: float = 0.5
    """Lever arm at which an error of the angular momentum counts as one of force [m]. Chosen."""
    sole_rate: float = 30.0
    """Rate at which a landing sole comes to rest [1/s]: 0.3 m/s stop within 4 mm."""
    posture_stiffness: float = 300.0
    """Stiffness of the posture on its curve [1/s²]. Chosen."""
    posture_damping: float = 50.0
    """Its damping [1/s]. Chosen above critical (see the module)."""
    curve_interval: float = 0.005
    """Time between samples of the curve [s]. Chosen equal to the time step."""


def forced_order(
    support: Support,
    tasks: GaitTasks,
    settings: ForcedGaitSettings | None = None,
    gait: GaitSettings | None = None,
) -> TaskOrder:
    """Return the order of tasks that reproduces a recorded gait with forces."""
    reference, carried, s = support.reference, support.com, settings or ForcedGaitSettings()
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
                task.target = carried
                task.stiffness, task.damping = s.com_stiffness, 2 * s.com_stiffness**0.5
                kept.append(task)
            elif task.name.startswith("swing heel"):
                side = task.name[-1]
                args = reference.heel_point[side], reference.heel[side], schedule.swing(side)
                kept.append(PlacingHeelTask(*args, carried, task.name))
            elif not task.name.startswith("rolling"):
                kept.append(task)
        for task in kept:  # a body with forces begins as recorded, lifted out of the ground
            task.initialises = isinstance(task, FloorTask)
        if kept:
            levels.append(kept)
    last = max(i for i, level in enumerate(levels) if any(isinstance(t, ComTask) for t in level))
    levels[last].append(_momentum(support, s))
    levels.append([_landing(reference, schedule)])
    return TaskOrder(levels, _posture(reference, tasks, s) if tasks.posture else None)


def _momentum(support: Support, s: ForcedGaitSettings) -> AngularMomentumTask:
    motion = support.reference.motion
    posture = Trajectory(motion.time, motion.qpos)
    return AngularMomentumTask(
        support.momentum,
        posture,
        turn=support.turn,
        lever=s.momentum_lever,
        stiffness=s.momentum_stiffness,
    )


def _landing(reference: Reference, schedule: ContactSchedule) -> LandingTask:
    time, landings, paths = reference.motion.time, [], []
    height = schedule.points.path(reference.motion.qpos)[:, :, 2] - schedule.points.radius
    for contact in reference.contacts:
        mine = (schedule.side == contact.side) & (schedule.region == contact.region)
        if contact.region == "heel" and mine.any():
            landings.append((np.flatnonzero(mine), contact.start))
            paths.append(Trajectory(time, height[:, mine].mean(axis=1)[:, None]))
    return LandingTask(schedule.points, landings, paths)


def _posture(reference: Reference, tasks: GaitTasks, s: ForcedGaitSettings) -> PostureTask:
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

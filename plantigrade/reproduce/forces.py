r"""A gait from ordered tasks that moves by forces: joint moments and ground reactions come with it.

The unknowns are joint accelerations and contact forces; the acceleration of the root follows from
the equations of motion (:mod:`plantigrade.wbc.forces`), which therefore hold at every
instant, and between instants nothing jumps. The hierarchy, from the top:

0. friction, unilateral contact, joint limits (bounds); strength of the joints, how fast a foot may
   be loaded; no point of the sole below the floor;
1. contact: soles rest where they landed;
2. *task 1*: the swinging heel on its path in the horizontal plane, displaced as the body is;
3. *task 2*: the centre of mass on its path, and with it the angular momentum about it: when the
   soles are too small for both, both give way;
4. landing: a heel arrives at the ground when it is to touch it;
5. *task 3*: the posture at the end of the phase, passed at its speed, as near as possible; and at
   last the least contact forces, near those of the instant before. This decides what mechanics
   leaves open: how points of one foot, and of two feet, share the load.

The heel of a foot that rolls off is led by posture alone: two feet on the ground and a heel on its
path would leave the pelvis no freedom.

The gains of the centre of mass are those of a body that balances: to undo an error :math:`e` by
:math:`\lambda^2 e` the centre of pressure must move by :math:`\lambda^2 e z / g`. At
:math:`\lambda = 7/s`, one centimetre takes five of the foot's twenty-five; the 20/s of
the kinematic hierarchy would take forty.
"""

import numpy as np

from plantigrade.constants import SIDES
from plantigrade.dynamics.centroid import centroid
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.reproduce.gait import GaitTasks, Steps, gait_order, phase_ends
from plantigrade.reproduce.reference import Reference
from plantigrade.reproduce.schedule import ContactSchedule
from plantigrade.reproduce.support import carried_path
from plantigrade.wbc.order import TaskOrder
from plantigrade.wbc.tasks import (
    AngularMomentumTask,
    ComTask,
    ContactTask,
    LandingTask,
    PassingPosture,
    PlacingHeelTask,
    SoleContactTask,
    Task,
)
from plantigrade.wbc.tasks.contact import SOLE

BALANCE = 49.0  # stiffness of the centre of mass [1/s²]
LOADING = 13.0  # steepest loading and unloading of a foot, body weights per second


def forced_order(reference: Reference, tasks: GaitTasks) -> TaskOrder:
    """Return the order of tasks that rebuilds a recorded gait by forces."""
    schedule = ContactSchedule(reference)
    carried = carried_path(reference, schedule)
    levels: list[list[Task]] = []
    for level in gait_order(reference, tasks, schedule).levels:
        kept: list[Task] = []
        for task in level:
            if isinstance(task, ContactTask):
                kept.append(SoleContactTask(schedule.points, schedule, stiffness=SOLE**2))
            elif isinstance(task, ComTask):
                task.target = carried
                task.stiffness, task.damping = BALANCE, 2 * BALANCE**0.5
                kept.append(task)
            elif task.name.startswith("swing heel"):
                side = task.name[-1]
                args = reference.heel_point[side], reference.heel[side], schedule.swing(side)
                kept.append(PlacingHeelTask(*args, carried, task.name))
            elif not task.name.startswith("rolling"):
                kept.append(task)
        if kept:
            levels.append(kept)
    last = max(i for i, level in enumerate(levels) if any(isinstance(t, ComTask) for t in level))
    levels[last].append(_momentum(reference))
    levels.append([_landing(reference, schedule)])
    return TaskOrder(levels, _posture(reference, tasks) if tasks.posture else None)


def _momentum(reference: Reference) -> AngularMomentumTask:
    motion = reference.motion
    recorded = centroid(reference.human, motion.qpos, motion.qvel)
    return AngularMomentumTask(
        Trajectory(motion.time, recorded.angular_momentum), Trajectory(motion.time, motion.qpos)
    )


def _landing(reference: Reference, schedule: ContactSchedule) -> LandingTask:
    landings = []
    for contact in reference.contacts:
        mine = (schedule.side == contact.side) & (schedule.region == contact.region)
        if contact.region == "heel" and mine.any():
            landings.append((np.flatnonzero(mine), contact.start))
    return LandingTask(schedule.points, landings)


def _posture(reference: Reference, tasks: GaitTasks) -> PassingPosture:
    ends = phase_ends(reference, tasks.phases)
    passed = Steps(ends, np.array([reference.velocity_at(float(t)) for t in ends]))
    return PassingPosture(Steps(ends, reference.at(ends)), lambda t: passed(t)[0])


class LoadLimit:
    """How much a foot may carry, that has just landed or is about to leave.

    Rigid contact would let the load of a foot jump. On six recordings with force plates the
    smoothed load rose by at most 8 to 23 and fell by at most 9 to 13 body weights per second; it
    may therefore be at most :data:`LOADING` times the time since the foot landed, and times the
    time until it leaves. How much it carries within that is left to mechanics. The number was
    settled on those same recordings: from 13 upwards, and without any limit, vertical forces stay
    within 0.05 to 0.08 body weights of the plates'; at 10 and below a quick walk cannot shift its
    weight in time and falls.

    Args:
        reference: The recorded gait, which says when each foot stands.
    """

    def __init__(self, reference: Reference):
        first, last = reference.motion.time[0], reference.motion.time[-1]
        seen = 0.03  # a stance that reaches an end of the recording was not seen whole [s]
        self.stances: dict[str, list[tuple[float, float]]] = {}
        for side in SIDES:
            merged: list[list[float]] = []
            mine = [c for c in reference.contacts if c.side == side]
            for c in sorted(mine, key=lambda c: c.start):
                if merged and c.start <= merged[-1][1] + 0.02:
                    merged[-1][1] = max(merged[-1][1], c.stop)
                else:
                    merged.append([c.start, c.stop])
            self.stances[side] = [
                (a if a > first + seen else -np.inf, b if b < last - seen else np.inf)
                for a, b in merged
            ]

    def __call__(self, side: str, time: float) -> float:
        """Return the greatest vertical force [body weights]."""
        for start, stop in self.stances[side]:
            if start - 1e-9 <= time <= stop + 1e-9:
                return max(LOADING * min(time - start, stop - time), 0.0)
        return np.inf

r"""A gait from three prioritised tasks [Boukheddimi]_, with a finer division of swing by default.

The hierarchy, from the top:

0. joint position, velocity and acceleration limits (bounds), no point of the sole below the floor;
1. contact: points on the ground stay at rest (:math:`a_c = 0`);
2. *task 1*: the swing heel on its path in the horizontal plane (contact holds the stance heel);
3. *task 2*: the centre of mass on its path, in three dimensions;
4. *task 1* again, during roll-off (heel up, forefoot down): the heel along its direction of
   travel; the contact determines the other directions;
5. *task 3*: the posture at the end of the phase, a fixed vector of all coordinates.

The paper gives the highest priority to the heel of the swing foot, whose path makes the foot roll;
it does not specify the priority of the heel during roll-off. Above the centre of mass it would
overconstrain a nearly straight leg.

The paper leaves open how a posture is reached. A body that came to rest at the end of every phase
would start again from standstill, unlike human walking; here each posture is passed at the velocity
of the natural cubic spline through the fixed postures.

The three tasks do not determine the leg's flexion in swing: they specify the leg at toe-off and at
landing. A human shortens it in between, with a toe clearance of a centimetre or two [Winter1992]_.
The default divides swing into its three parts [Perry1992]_: initial swing ends where the leg is
shortest from hip to ankle, mid swing where the shank is vertical. A cycle then has eight phases,
and each posture is passed at its recorded velocity, as in the gait with forces. There are still
three tasks, and no angle is tracked between these instants.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import BodyState, PointSet
from plantigrade.models import Human
from plantigrade.ordered_tasks.gait_reference import GaitReference
from plantigrade.ordered_tasks.phases import Phase
from plantigrade.ordered_tasks.schedule import ContactSchedule
from plantigrade.spatial.conventions import continuous_poses
from plantigrade.wbc.order import UPPER_BODY, TaskOrder
from plantigrade.wbc.tasks import ComTask, ContactTask, FloorTask, PointTask, Task, TimedPosture


@dataclass(frozen=True, kw_only=True)
class GaitSettings:
    """Gains of a gait's tasks."""

    stiffness: float = 400.0
    """Stiffness of heels, centre of mass and contacts [1/s²], critically damped. Chosen."""
    min_time_left: float = 0.04
    """Lower limit of the time to go in the posture law [s]. Chosen."""
    max_rolling_error: float = 0.02
    """Saturation of the position error of a rolling heel [m]. Chosen."""


@dataclass(frozen=True)
class GaitTasks:
    """The tasks of a gait."""

    #: ``"eight"`` (swing in three parts), ``"six"`` (swing divided where the leg is shortest),
    #: ``"four"`` (the paper's) or ``"two"`` (heel strike to heel strike)
    phases: str = "eight"
    com: str = "whole"  #: ``"whole"`` or ``"split"`` (horizontal above vertical)
    posture: bool = True  #: Whether there is a posture task
    #: Whether postures are passed at their recorded velocity; otherwise at that of the smooth curve
    #: through them
    rates: bool = True


TASKS = {
    "default": GaitTasks(),
    "paper": GaitTasks(phases="four", rates=False),
    "six-phases": GaitTasks(phases="six"),
    "no-rates": GaitTasks(rates=False),
    "two-phases": GaitTasks(phases="two", rates=False),
    "split-com": GaitTasks(phases="four", com="split", rates=False),
    "no-posture": GaitTasks(phases="four", posture=False, rates=False),
}
"""The default, its ablations, the paper's tasks and the paper's ablations."""


def gait_tasks(name: str) -> GaitTasks:
    """Return a named set of tasks.

    Raises:
        ParameterError: If the set is unknown.
    """
    if name not in TASKS:
        raise ParameterError(f"tasks={name!r}; allowed are {', '.join(TASKS)}")
    return TASKS[name]


def gait_order(
    reference: GaitReference,
    tasks: GaitTasks,
    schedule: ContactSchedule | None = None,
    settings: GaitSettings | None = None,
) -> TaskOrder:
    """Return the task hierarchy that reproduces a recorded gait.

    Args:
        schedule: Contact schedule; by default points touch while they are stationary.
    """
    s = settings or GaitSettings()
    k = s.stiffness
    schedule = schedule or ContactSchedule(reference, reference.held)
    floor = FloorTask(schedule.points, lambda t: ~schedule(t))
    contact = ContactTask(schedule.points, schedule, stiffness=k)

    def heels(task_name: str, directions, **options) -> list[Task]:
        points, paths = reference.heel_point, reference.heel
        return [
            PointTask(
                points[i], paths[i], directions(i), f"{task_name} {i}", stiffness=k, **options
            )
            for i in SIDES
        ]

    swing_heels = heels("swing heel", lambda side: schedule.swing(side, contact))
    levels: list[Sequence[Task]] = [[floor], [contact], swing_heels]
    if tasks.com == "split":
        levels += [[ComTask(reference.com, axes, stiffness=k)] for axes in ("xy", "z")]
    else:
        levels += [[ComTask(reference.com, name="centre of mass", stiffness=k)]]
    levels.append(heels("rolling heel", schedule.roll, max_error=s.max_rolling_error))
    for task in (task for level in levels for task in level):
        if not isinstance(task, ContactTask):  # feet below the ground are raised vertically
            task.initialises = True
    posture = posture_task(reference, tasks, s.min_time_left) if tasks.posture else None
    return TaskOrder(levels, posture, spared=UPPER_BODY)


def posture_task(reference: GaitReference, tasks: GaitTasks, min_time_left: float) -> TimedPosture:
    """Return the posture task: the recorded posture at the end of each phase."""
    ends = phase_ends(reference, tasks.phases)
    postures = reference.at(ends)
    if tasks.rates:
        rates = np.array([reference.velocity_at(float(t)) for t in ends])
    else:
        rates = rates_through(
            reference.human,
            np.concatenate([[reference.start], ends]),
            np.concatenate([reference.at(reference.start)[None], postures]),
        )[1:]
    passed = PhaseValues(ends, rates)
    return TimedPosture(
        PhaseValues(ends, postures), lambda t: passed(t)[0], min_time_left=min_time_left
    )


def rates_through(
    human: Human, time: Float[Array, " n"], postures: Float[Array, "n nq"]
) -> Float[Array, "n nv"]:
    """Return the velocities of the natural cubic spline through postures at its knots."""
    curve, h = CubicSpline(time, continuous_poses(postures), bc_type="natural"), 1e-3

    def at(t: float) -> Array:
        qpos = curve(t)
        qpos[3:7] /= np.linalg.norm(qpos[3:7])
        return qpos

    state = BodyState(human, postures[0])
    return np.array(
        [state.moved_to(at(t + h), state.qvel).difference(at(t - h)) / (2 * h) for t in time]
    )


@dataclass(frozen=True)
class PhaseValues:
    """Value and end time of the current phase."""

    ends: Float[Array, " n"]  #: Ends of the phases [s]
    values: Float[Array, "n dimension"]  #: Value of each phase

    def __call__(self, time: float) -> tuple[Float[Array, " dimension"], float]:
        """Return value and end of the phase at a time [s]."""
        k = min(int(np.searchsorted(self.ends, time + 1e-9, side="right")), len(self.ends) - 1)
        return self.values[k], float(self.ends[k])


MIN_PART = 0.02  # Minimum duration of a part of swing that counts as a phase [s]. Chosen.


def phase_ends(reference: GaitReference, phases: str) -> Float[Array, " n_ends"]:
    """Return the times at which phases end [s]; ``phases`` is as in :class:`GaitTasks`."""
    if phases not in ("two", "four", "six", "eight"):
        raise ParameterError(f"phases={phases!r}; allowed are two, four, six, eight")
    ends = []
    for phase in reference.phases:
        if phases == "two" and phase.kind == "double":
            continue
        if phase.kind == "single" and phases in ("six", "eight"):
            shortest = leg_shortest(reference, phase)
            parts = [shortest]
            if phases == "eight":
                parts.append(shank_upright(reference, phase, shortest))
            for end in parts:
                if end - (ends[-1] if ends else phase.start) > MIN_PART < phase.stop - end:
                    ends.append(end)
        ends.append(phase.stop)
    if not ends or ends[-1] < reference.stop:
        ends.append(reference.stop)
    return np.array(ends)


def leg_shortest(reference: GaitReference, phase: Phase) -> float:
    """Return when the swing leg is shortest from hip to ankle in a single support [s]."""
    human = reference.human
    joints = PointSet(human, [f"femur_{phase.swing}", f"foot_{phase.swing}"], np.zeros((2, 3)))
    times = np.linspace(phase.start, phase.stop, 41)
    hip, ankle = np.moveaxis(joints.path(reference.at(times)), 1, 0)
    length = np.linalg.norm(hip - ankle, axis=1)
    return float(times[int(np.argmin(length))])


def shank_upright(reference: GaitReference, phase: Phase, after: float) -> float:
    """Return when the swing shank is most nearly vertical in its plane of travel, after a time [s].

    The plane of travel contains the vertical and the displacement of the swing heel.
    """
    human, path = reference.human, reference.heel[phase.swing]
    joints = PointSet(human, [f"tibia_{phase.swing}", f"foot_{phase.swing}"], np.zeros((2, 3)))
    times = np.linspace(after, phase.stop, 41)
    knee, ankle = np.moveaxis(joints.path(reference.at(times)), 1, 0)
    travel = (path(phase.stop)[0] - path(phase.start)[0])[:2]
    ahead = (ankle - knee)[:, :2] @ travel
    return float(times[int(np.argmin(np.abs(ahead)))])

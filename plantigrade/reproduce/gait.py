r"""A gait from three ordered tasks [Boukheddimi]_, and the default with one more.

The hierarchy, from the top:

0. joint position, velocity and acceleration limits (bounds), no point of the sole below the floor;
1. contact: points that touch the ground rest (:math:`a_c = 0`);
2. *task 1*: the heel in the horizontal plane: the swinging one on its path, the one on the ground
   at its place (which the contact does);
3. *task 2*: the centre of mass on its path, in three dimensions;
4. *task 1* again, while a foot rolls off (heel up, forefoot down): its heel along the way it goes;
   across it the contact already decides;
5. *task 3*: the posture at the end of the phase, a fixed vector of all coordinates.

The paper gives the first place to the heel of the swinging foot, and says that the path of the
foot is what makes it roll; it does not say where the heel of a foot stands that rolls off. Above
the centre of mass it would be a second demand on a leg that is nearly straight.

What the three tasks leave free is how the leg folds while it swings: they know the leg where it
takes off and where it lands. A human shortens it in between, to clear the ground by a centimetre or
two [Winter1992]_. The default adds one posture, at the instant at which the swinging leg is
shortest from hip to ankle. The tasks stay three; the single support counts as two phases.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import PointSet
from plantigrade.reproduce.phases import Phase
from plantigrade.reproduce.reference import Reference
from plantigrade.reproduce.schedule import ContactSchedule
from plantigrade.wbc.order import UPPER_BODY, TaskOrder
from plantigrade.wbc.tasks import (
    ComTask,
    ContactTask,
    FloorTask,
    PointTask,
    PostureTask,
    Task,
)

# A foot is light: it is brought to the posture it lands with early in swing, not on landing. How
# early was settled on the walks of ``gait-table``, with the gains of the posture.
FOOT_HORIZON = 0.25  # [s]
FOOT_JOINTS = ("ankle_", "subtalar_", "mtp", "cuboid_", "heel_")
FARTHEST = 0.02  # a rolling heel is not pulled harder than if it were this far off its path [m]


@dataclass(frozen=True)
class GaitTasks:
    """Which tasks make the gait.

    Attributes:
        phases: ``"six"`` (single supports divided where the leg is shortest), ``"four"`` (the
            paper's) or ``"two"`` (heel strike to heel strike).
        com: ``"whole"`` or ``"split"`` (horizontal above vertical).
        posture: Whether there is a posture task.
    """

    phases: str = "six"
    com: str = "whole"
    posture: bool = True


TASKS = {
    "default": GaitTasks(),
    "paper": GaitTasks(phases="four"),
    "two-phases": GaitTasks(phases="two"),
    "split-com": GaitTasks(phases="four", com="split"),
    "no-posture": GaitTasks(phases="four", posture=False),
}
"""The default, the paper's, and what the paper tried without."""


def gait_tasks(name: str) -> GaitTasks:
    """Return a named set of tasks.

    Raises:
        ParameterError: If the set is unknown.
    """
    if name not in TASKS:
        raise ParameterError(f"tasks={name!r}; allowed are {', '.join(TASKS)}")
    return TASKS[name]


def gait_order(reference: Reference, tasks: GaitTasks) -> TaskOrder:
    """Return the order of tasks that rebuilds a recorded gait."""
    schedule = ContactSchedule(reference)
    floor = FloorTask(schedule.points, lambda t: ~schedule(t))
    contact = ContactTask(schedule.points, schedule)

    def heels(what: str, directions, farthest: float = np.inf) -> list[Task]:
        points, paths = reference.heel_point, reference.heel
        return [
            PointTask(points[s], paths[s], directions(s), f"{what} {s}", farthest) for s in SIDES
        ]

    levels: list[Sequence[Task]] = [[floor], [contact], heels("swing heel", schedule.swing)]
    if tasks.com == "split":
        levels += [[ComTask(reference.com, "xy")], [ComTask(reference.com, "z")]]
    else:
        levels += [[ComTask(reference.com, name="centre of mass")]]
    levels.append(heels("rolling heel", schedule.roll, FARTHEST))
    posture = posture_task(reference, tasks) if tasks.posture else None
    return TaskOrder(levels, posture, spared=UPPER_BODY)


def posture_task(reference: Reference, tasks: GaitTasks) -> PostureTask:
    """Return the posture task: the recorded posture at the end of each phase."""
    ends = phase_ends(reference, tasks.phases)
    horizon = np.full(reference.human.model.nv, np.inf)
    for i, name in enumerate(reference.human.coordinates):
        if name.startswith(FOOT_JOINTS):
            horizon[6 + i] = FOOT_HORIZON
    return PostureTask(Steps(ends, reference.at(ends)), horizon=horizon)


@dataclass(frozen=True)
class Steps:
    """The value of the present phase and the time at which it ends [s], at any time.

    Attributes:
        ends: Ends of the phases [s].
        values: Value of each.
    """

    ends: Float[Array, " n"]
    values: Float[Array, "n dimension"]

    def __call__(self, time: float) -> tuple[Float[Array, " dimension"], float]:
        """Return value and end of the phase at a time [s]."""
        k = min(int(np.searchsorted(self.ends, time + 1e-9, side="right")), len(self.ends) - 1)
        return self.values[k], float(self.ends[k])


def phase_ends(reference: Reference, phases: str) -> Float[Array, " n_ends"]:
    """Return the times at which phases end [s].

    Args:
        reference: The recorded gait.
        phases: As in :class:`GaitTasks`.

    Raises:
        ParameterError: If the division is unknown.
    """
    if phases not in ("two", "four", "six"):
        raise ParameterError(f"phases={phases!r}; allowed are two, four, six")
    ends = []
    for phase in reference.phases:
        if phases == "two" and phase.kind == "double":
            continue
        if phases == "six" and phase.kind == "single":
            ends.append(leg_shortest(reference, phase))
        ends.append(phase.stop)
    if not ends or ends[-1] < reference.stop:
        ends.append(reference.stop)
    return np.array(ends)


def leg_shortest(reference: Reference, phase: Phase) -> float:
    """Return when the swinging leg is shortest from hip to ankle in a single support [s]."""
    human = reference.human
    joints = PointSet(human, [f"femur_{phase.swing}", f"foot_{phase.swing}"], np.zeros((2, 3)))
    times = np.linspace(phase.start, phase.stop, 41)
    hip, ankle = np.moveaxis(joints.path(reference.at(times)), 1, 0)
    length = np.linalg.norm(hip - ankle, axis=1)
    return float(times[int(np.argmin(length))])

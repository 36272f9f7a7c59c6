r"""A gait from three ordered tasks [Boukheddimi]_, and the default with one more.

The hierarchy, from the top:

0. joint position, velocity and acceleration limits (bounds), no point of the sole below the floor;
1. contact: points that touch the ground rest (:math:`a_c = 0`);
2. *task 1*: the heel in the horizontal plane: the swinging one on its path, the one on the ground
   at its place (which the contact does);
3. *task 2*: the centre of mass on its path, in three dimensions;
4. *task 3*: the posture at the end of the phase, a fixed vector of all coordinates.

While a foot rolls off (heel up, forefoot down) its heel follows the path along the foot; across
it the contact already decides. The paper speaks of the swinging foot only, but also says that the
heel's path is what makes the foot roll.

What the three tasks leave free is how the leg folds while it swings: they know the leg where it
takes off and where it lands. The default adds one posture, at the instant at which the swinging
foot passes the standing one (*feet adjacent* [Whittle2007]_): mid-swing is where a human regulates
the clearance of the foot [Winter1992]_. The tasks stay three; the single support counts as two
phases.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.kinematics.ground import contact_points
from plantigrade.kinematics.state import PointSet
from plantigrade.kinematics.tasks import (
    ComTask,
    ContactTask,
    FloorTask,
    PointTask,
    PostureTask,
    Task,
)
from plantigrade.reproduce.ordered_motion import TaskOrder
from plantigrade.reproduce.reference import SIDES, Reference

LAST_TO_LEAVE = "toe_1"  # the hallux leaves the ground last


@dataclass(frozen=True)
class GaitTasks:
    """Which tasks make the gait.

    Attributes:
        phases: ``"six"`` (single supports divided where the feet are adjacent), ``"four"`` (the
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
        ParameterError: If there is no such set.
    """
    if name not in TASKS:
        raise ParameterError(f"tasks={name!r}; allowed are {', '.join(TASKS)}")
    return TASKS[name]


def gait_order(reference: Reference, tasks: GaitTasks) -> TaskOrder:
    """Return the order of tasks that rebuilds a recorded gait.

    Args:
        reference: The recorded gait.
        tasks: Which tasks.
    """
    schedule = ContactSchedule(reference)
    floor = FloorTask(schedule.points, schedule.radius, lambda t: ~schedule(t))
    contact = ContactTask(schedule.points, schedule.radius, schedule)
    heels: list[Task] = [
        PointTask(
            reference.heel_point[side],
            reference.heel[side],
            schedule.heel_directions(side),
            name=f"heel {side}",
        )
        for side in SIDES
    ]
    levels: list[Sequence[Task]] = [[floor], [contact], heels]
    if tasks.com == "split":
        levels += [[ComTask(reference.com, "xy")], [ComTask(reference.com, "z")]]
    else:
        levels += [[ComTask(reference.com, name="centre of mass")]]
    return TaskOrder(levels, posture_task(reference, tasks) if tasks.posture else None)


class ContactSchedule:
    """Which points of the soles touch the ground when.

    Args:
        reference: The recorded gait.
    """

    def __init__(self, reference: Reference):
        human = reference.human
        place = contact_points(human, human.standing()[None])
        self.points = PointSet(human, list(place.body), place.centre)
        self.radius = place.radius
        self.side, self.region = np.array(place.side), np.array(place.region)
        names = [name for name, _, _ in human.contact_points]
        self._tip = np.array([LAST_TO_LEAVE in name for name in names])
        of = [
            (i, c.start, c.stop)
            for i in range(len(names))
            for c in reference.contacts
            if c.side == self.side[i] and c.region == self.region[i]
        ]
        self._index = np.array([o[0] for o in of], dtype=int)
        self._start, self._stop = np.array([o[1] for o in of]), np.array([o[2] for o in of])

    def __call__(self, time: float) -> np.ndarray:
        """Return which points touch (n_points,).

        Of toes alone on the ground only the hallux' tip touches: the others have left with the
        ball, and a foot that is about to leave turns about it freely.
        """
        on = np.zeros(len(self.side), dtype=bool)
        on[self._index[(self._start <= time) & (time < self._stop)]] = True
        for side in SIDES:
            mine = self.side == side
            toes = on & mine & (self.region == "toes")
            if toes.any() and not (on & mine & (self.region != "toes")).any():
                on[toes] = False
                on[mine & self._tip] = True
        return on

    def heel_directions(self, side: str):
        """Return the directions in which a heel is led: a function of state and time.

        None while the heel touches, along the foot while the foot rolls off, both horizontal ones
        in swing.
        """
        mine = self.side == side
        heel, forefoot = mine & (self.region == "heel"), mine & (self.region != "heel")
        nothing, plane = np.zeros((0, 3)), np.eye(3)[:2]
        body = f"foot_{side}"

        def directions(state, time: float) -> np.ndarray:
            on = self(time)
            if on[heel].any():
                return nothing
            if not on[forefoot].any():
                return plane
            along = state.rotation(body)[:, 0] * [1.0, 1.0, 0.0]
            return along[None] / np.linalg.norm(along)

        return directions


def posture_task(reference: Reference, tasks: GaitTasks) -> PostureTask:
    """Return the posture task: the recorded posture at the end of each phase.

    Args:
        reference: The recorded gait.
        tasks: Which tasks.
    """
    ends = phase_ends(reference, tasks.phases)
    postures = reference.at(ends)

    def target(time: float) -> tuple[Float[Array, " nq"], float]:
        k = min(int(np.searchsorted(ends, time + 1e-9, side="right")), len(ends) - 1)
        return postures[k], float(ends[k])

    return PostureTask(target)


def phase_ends(reference: Reference, phases: str) -> Float[Array, " n_ends"]:
    """Return the times at which phases end [s].

    Args:
        reference: The recorded gait.
        phases: As in :class:`GaitTasks`.

    Raises:
        ParameterError: If there is no such division.
    """
    if phases not in ("two", "four", "six"):
        raise ParameterError(f"phases={phases!r}; allowed are two, four, six")
    ends = []
    for phase in reference.phases:
        if phases == "two" and phase.kind == "double":
            continue
        if phases == "six" and phase.kind == "single":
            ends.append(feet_adjacent(reference, phase))
        ends.append(phase.stop)
    if not ends or ends[-1] < reference.stop:
        ends.append(reference.stop)
    return np.array(ends)


def feet_adjacent(reference: Reference, phase) -> float:
    """Return when the swinging heel passes the standing one in a single support [s].

    The middle of the phase is taken where it does not.
    """
    stand = "l" if phase.swing == "r" else "r"
    times = np.linspace(phase.start, phase.stop, 41)
    between = np.array(
        [reference.heel[phase.swing](t)[0, :2] - reference.heel[stand](t)[0, :2] for t in times]
    )
    way = between[-1] - between[0]
    ahead = between @ way
    passed = np.flatnonzero((ahead[:-1] < 0) & (ahead[1:] >= 0))
    if not len(passed):
        return (phase.start + phase.stop) / 2
    k = int(passed[0])
    return float(times[k] + (times[k + 1] - times[k]) * -ahead[k] / (ahead[k + 1] - ahead[k]))

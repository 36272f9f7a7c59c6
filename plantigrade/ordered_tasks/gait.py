r"""A gait from three prioritised tasks [Boukheddimi]_, and the default with one more.

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

The paper leaves open how a posture is reached. A body that came to rest at the end of every phase
would start anew from there, which nobody walking does; each posture is passed on the way to the
next one, at the rate of the smooth curve (a natural cubic spline) through the fixed postures alone.

What the three tasks leave free is how the leg folds while it swings: they know the leg where it
takes off and where it lands. A human shortens it in between, to clear the ground by a centimetre or
two [Winter1992]_. The default divides swing in its three parts [Perry1992]_: initial swing ends
where the leg is shortest from hip to ankle, mid swing where the shank is upright. A cycle then has
eight phases; and the default passes each posture at its recorded rate, as the gait moved by forces
does. The tasks stay three, and between these instants nothing is known of any angle.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from plantigrade.arrays import Array, Float
from plantigrade.constants import SIDES
from plantigrade.dynamics.derivatives import continuous
from plantigrade.errors import ParameterError
from plantigrade.kinematics.state import PointSet, State
from plantigrade.models import Human
from plantigrade.ordered_tasks.phases import Phase
from plantigrade.ordered_tasks.reference import Reference
from plantigrade.ordered_tasks.schedule import ContactSchedule
from plantigrade.wbc.order import UPPER_BODY, TaskOrder
from plantigrade.wbc.tasks import (
    ComTask,
    ContactTask,
    FloorTask,
    PassingPosture,
    PointTask,
    Task,
)


@dataclass(frozen=True, kw_only=True)
class GaitSettings:
    """Gains of a gait's tasks."""

    stiffness: float = 400.0
    """Stiffness of heels, centre of mass and contacts [1/s²], critically damped. Chosen."""
    min_time_left: float = 0.04
    """Time left below which the pull to a posture grows no further [s]. Chosen."""
    max_rolling_error: float = 0.02
    """Error of a rolling heel beyond which the pull grows no further [m]. Chosen."""


@dataclass(frozen=True)
class GaitTasks:
    """The tasks of a gait.

    Attributes:
        phases: ``"eight"`` (swing in its three parts), ``"six"`` (swing divided where the leg is
            shortest), ``"four"`` (the paper's) or ``"two"`` (heel strike to heel strike).
        com: ``"whole"`` or ``"split"`` (horizontal above vertical).
        posture: Whether there is a posture task.
        rates: Whether postures are passed at their recorded rate; else at that of the smooth curve
            through them.
    """

    phases: str = "eight"
    com: str = "whole"
    posture: bool = True
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
"""The default and without its parts, the paper's, and what the paper tried without."""


def gait_tasks(name: str) -> GaitTasks:
    """Return a named set of tasks.

    Raises:
        ParameterError: If the set is unknown.
    """
    if name not in TASKS:
        raise ParameterError(f"tasks={name!r}; allowed are {', '.join(TASKS)}")
    return TASKS[name]


def gait_order(
    reference: Reference,
    tasks: GaitTasks,
    schedule: ContactSchedule | None = None,
    settings: GaitSettings | None = None,
) -> TaskOrder:
    """Return the order of tasks that reproduces a recorded gait.

    Args:
        reference: The recorded gait.
        tasks: Which tasks.
        schedule: When which points touch; as long as they are where they rested if absent.
        settings: Gains.
    """
    s = settings or GaitSettings()
    k = s.stiffness
    schedule = schedule or ContactSchedule(reference, reference.held)
    floor = FloorTask(schedule.points, lambda t: ~schedule(t))
    contact = ContactTask(schedule.points, schedule, stiffness=k)

    def heels(what: str, directions, **options) -> list[Task]:
        points, paths = reference.heel_point, reference.heel
        return [
            PointTask(points[i], paths[i], directions(i), f"{what} {i}", stiffness=k, **options)
            for i in SIDES
        ]

    led = heels("swing heel", lambda side: schedule.swing(side, contact))
    levels: list[Sequence[Task]] = [[floor], [contact], led]
    if tasks.com == "split":
        levels += [[ComTask(reference.com, axes, stiffness=k)] for axes in ("xy", "z")]
    else:
        levels += [[ComTask(reference.com, name="centre of mass", stiffness=k)]]
    levels.append(heels("rolling heel", schedule.roll, max_error=s.max_rolling_error))
    for task in (task for level in levels for task in level):
        if not isinstance(task, ContactTask):  # sunken feet are lifted where they are
            task.initialises = True
    posture = posture_task(reference, tasks, s.min_time_left) if tasks.posture else None
    return TaskOrder(levels, posture, spared=UPPER_BODY)


def posture_task(reference: Reference, tasks: GaitTasks, min_time_left: float) -> PassingPosture:
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
    passed = Steps(ends, rates)
    return PassingPosture(
        Steps(ends, postures), lambda t: passed(t)[0], min_time_left=min_time_left
    )


def rates_through(
    human: Human, time: Float[Array, " n"], postures: Float[Array, "n nq"]
) -> Float[Array, "n nv"]:
    """Return the velocities at which the smooth curve through postures passes each.

    The curve is the natural cubic spline: of all that pass the postures the one that bends least.
    """
    curve, h = CubicSpline(time, continuous(postures), bc_type="natural"), 1e-3

    def at(t: float) -> Array:
        qpos = curve(t)
        qpos[3:7] /= np.linalg.norm(qpos[3:7])
        return qpos

    state = State(human, postures[0])
    return np.array(
        [state.moved_to(at(t + h), state.qvel).difference(at(t - h)) / (2 * h) for t in time]
    )


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


def phase_ends(
    reference: Reference, phases: str, min_part: float = 0.02
) -> Float[Array, " n_ends"]:
    """Return the times at which phases end [s].

    Args:
        reference: The recorded gait.
        phases: As in :class:`GaitTasks`.
        min_part: Duration below which a part of swing is none [s].

    Raises:
        ParameterError: If the division is unknown.
    """
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
                if end - (ends[-1] if ends else phase.start) > min_part < phase.stop - end:
                    ends.append(end)
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


def shank_upright(reference: Reference, phase: Phase, after: float) -> float:
    """Return when the swinging shank is nearest to upright, seen from the side, after a time [s].

    From the side: in the direction in which the heel of the swinging foot goes.
    """
    human, path = reference.human, reference.heel[phase.swing]
    joints = PointSet(human, [f"tibia_{phase.swing}", f"foot_{phase.swing}"], np.zeros((2, 3)))
    times = np.linspace(after, phase.stop, 41)
    knee, ankle = np.moveaxis(joints.path(reference.at(times)), 1, 0)
    way = (path(phase.stop)[0] - path(phase.start)[0])[:2]
    ahead = (ankle - knee)[:, :2] @ way
    return float(times[int(np.argmin(np.abs(ahead)))])

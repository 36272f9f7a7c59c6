r"""Motion from prioritised tasks: the hierarchy's acceleration, integrated at every tick.

At every tick the rows of a :class:`~plantigrade.wbc.order.TaskOrder` become a hierarchical
quadratic program (Eqs. 2-9 of [Boukheddimi]_), whose answer is integrated over the step.

The unknowns are the generalised acceleration, or, where
:class:`~plantigrade.wbc.forces.Footing` are given, joint accelerations and contact forces that
satisfy the equations of motion. Without forces, velocities jump where a contact begins
(:func:`velocity_after_impact`).

Least squares in the coordinates would use every joint alike. Without forces the unknowns are
scaled, so that an order can spare some where others can do what a task asks: in walking, arms and
neck.

Example:
    >>> import numpy as np
    >>> from plantigrade.wbc.tasks import ComTask
    >>> from plantigrade.kinematics.trajectory import Trajectory
    >>> from plantigrade.models import Human
    >>> human = Human.create()
    >>> here = BodyState(human, human.standing()).com
    >>> down = ComTask(Trajectory.fixed(here - np.array([0.0, 0.0, 0.1])))
    >>> motion = move(human, TaskOrder([[down]]), human.standing(), stop=1.0)
    >>> round(float(BodyState(human, motion.qpos[-1]).com[2] - here[2]), 3)
    -0.1
"""

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field
from math import sqrt
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.contact.site import ContactSite
from plantigrade.errors import SolverError
from plantigrade.kinematics.state import BodyState, integrate
from plantigrade.models import Human
from plantigrade.motion.motion import Motion
from plantigrade.record import Record
from plantigrade.wbc.forces import Footing, ForceUnknowns
from plantigrade.wbc.hierarchy import solve_hierarchy
from plantigrade.wbc.joint_limits import JointLimits
from plantigrade.wbc.order import TaskOrder, scaled, stacked
from plantigrade.wbc.rows import Rows

MAX_CORRECTIONS = 10  # steps from a recorded posture to one that is not in the ground
MAX_CORRECTION = 0.1  # [rad, m] greatest change of any coordinate in one of them


@dataclass(frozen=True, kw_only=True)
class MotionSettings:
    """Integration of an order's answers, and the correction of its first posture."""

    step: float = 0.005
    """Time step [s]. Chosen."""
    min_gain: float = 0.02
    """Motion of a task per unit of joint acceleration below which a direction is singular and left
    to the levels below. Chosen: a straight knee lengthens the leg by nothing, and would
    need infinite speed. It also lets short toes give way a little where a foot rigid as a
    machine's would pull at the whole body: of contacts, turns of a segment that move its points by
    less per radian are not held."""
    leg_readiness: float = 0.5
    """Readiness of hip, knee and ankle to move in the correction, that of joints within the foot
    being 1. Chosen: the foot before the leg, the leg before the rest of the body."""
    other_readiness: float = 0.02
    """That of all other joints. Chosen."""

    def readiness(self, human: Human) -> Float[Array, " nv"]:
        """Return the readiness of every coordinate to move in a correction."""
        starts = (
            (("mtp", "cuboid_", "heel_"), 1.0),
            (("ankle_", "subtalar_", "knee_", "hip_"), self.leg_readiness),
            (("",), self.other_readiness),
        )
        hinges = [next(r for s, r in starts if c.startswith(s)) for c in human.coordinates]
        return np.array([self.other_readiness] * 6 + hinges)


@dataclass(frozen=True)
class OrderedMotion:
    """The resulting motion, tick by tick.

    Attributes:
        human: The person.
        order: The tasks.
        time: Time of each tick [s].
        qpos: Configurations.
        qvel: Velocities; after the impact where there is one.
        qacc: Accelerations, from each tick to the next.
        active: Whether each task had rows.
        residual: Error of each task's acceleration [its unit per s²].
        solver_time: Time in the hierarchical program [s].
        kinematics_time: Time in kinematics, Jacobians and rows [s].
        exact: Whether no inequality was in the way.
        qfrc: Generalised forces: what the equations of motion leave unexplained at the root
            [N, N m], then joint moments [N m]; None for a motion without forces, as are the next
            two.
        contact_force: Ground reaction at each site, world [N]; zero where it carries none.
        contact_point: Where it acts, world [m]; NaN where it carries none.
        sites: The sites that may carry force.
        stopped: Why it ended early; empty where it did not.
    """

    human: Human = field(repr=False)
    order: TaskOrder = field(repr=False)
    time: Float[Array, " n"]
    qpos: Float[Array, "n nq"]
    qvel: Float[Array, "n nv"]
    qacc: Float[Array, "n nv"]
    active: Bool[Array, "n n_tasks"]
    residual: Float[Array, "n n_tasks"]
    solver_time: Float[Array, " n"] = field(repr=False)
    kinematics_time: Float[Array, " n"] = field(repr=False)
    exact: Bool[Array, " n"] = field(repr=False)
    qfrc: Float[Array, "n nv"] | None = None
    contact_force: Float[Array, "n k 3"] | None = None
    contact_point: Float[Array, "n k 3"] | None = None
    sites: tuple[ContactSite, ...] = ()
    stopped: str = ""

    def record(self) -> Record:
        """Return what happened, with the tasks' residuals as signals."""
        return Record(
            self.human,
            Motion(self.time, self.qpos, self.qvel, self.human.joint_names, self.qacc),
            qfrc_actuator=self.qfrc,
            sites=self.sites,
            contact_force=self.contact_force,
            contact_point=self.contact_point,
            signals={
                "tasks.names": np.array(self.order.names, dtype=np.str_),
                "tasks.level": np.array([level for level, _ in self.order.numbered]),
                "tasks.meanings": np.array(self.order.meanings, dtype=np.str_),
                "tasks.active": self.active,
                "tasks.residual": self.residual,
                "exact": self.exact,
                "stopped": np.array(self.stopped, dtype=np.str_),
            },
        )


class AccelerationUnknowns:
    """The hierarchical program of one tick in the generalised acceleration."""

    impacts = True  # velocities jump where a contact begins
    sites: tuple[ContactSite, ...] = ()

    def __init__(self, state: BodyState, order: TaskOrder):
        self.ready = order.readiness(state.human) if order.spared else None

    def program(
        self, state: BodyState, time: float, rows: list[list[Rows]], desired, bounds
    ) -> dict[str, Any]:
        """Return the arguments of :func:`~plantigrade.wbc.hierarchy.solve_hierarchy`."""
        (low, high), ready = bounds, self.ready
        levels = [stacked([row.level for row in level]) for level in rows]
        if ready is not None:
            levels = [scaled(level, ready) for level in levels]
            low, high, desired = low / ready, high / ready, desired / ready
        return {"levels": levels, "lower": low, "upper": high, "preferred": desired}

    def answer(self, state: BodyState, x: Float[Array, " n"]) -> dict[str, Array]:
        """Return the acceleration of an answer."""
        return {"qacc": x if self.ready is None else self.ready * x}


def _begun(
    state: BodyState, order: TaskOrder, impacts: bool, now: float, settings: MotionSettings
) -> BodyState:
    """Return the state in which tasks have begun; where contacts begin, after their impact."""
    begins = [task.begin(state, now) for task in order.tasks]
    if not (any(begins) and impacts):
        return state
    return state.moved_to(state.qpos, velocity_after_impact(state, order, now, settings))


def _tick(
    state: BodyState,
    order: TaskOrder,
    unknowns: ForceUnknowns | AccelerationUnknowns,
    limits: JointLimits,
    now: float,
    began: float,
    settings: MotionSettings,
) -> dict[str, Any]:
    """Return what is kept of an instant: the state, its acceleration, and what tasks miss.

    Raises:
        SolverError: If the program has no solution.
    """
    rows = order.rows(state, now)
    desired = order.preferred(state, now)
    program = unknowns.program(state, now, rows, desired, limits.bounds(state))
    built = clock.perf_counter()
    solution = solve_hierarchy(**program, singular=settings.min_gain)
    solved = clock.perf_counter()
    answer = unknowns.answer(state, solution.x)
    active, residual = _missed(order, rows, desired, answer["qacc"])
    return {
        "qpos": state.qpos,
        "qvel": state.qvel,
        "active": active,
        "residual": residual,
        "solver_time": solved - built,
        "kinematics_time": built - began,
        "exact": solution.exact,
        **answer,
    }


def move(
    human: Human,
    order: TaskOrder,
    qpos: Float[Array, " nq"],
    qvel: Float[Array, " nv"] | None = None,
    *,
    start: float = 0.0,
    stop: float,
    settings: MotionSettings | None = None,
    limits: JointLimits | None = None,
    ground: Footing | None = None,
    progress: Callable[[float], None] | None = None,
) -> OrderedMotion:
    """Compute the motion of a person from an order of tasks.

    Args:
        human: The person.
        order: The tasks.
        qpos: Configuration to start from.
        qvel: Velocity to start with; rest if absent.
        start: Time of the start [s].
        stop: Time of the end [s].
        settings: Time step, and what counts as singular.
        limits: Joint limits; the person's if absent.
        ground: Forces that the ground can provide; without it the motion needs none.
        progress: Called with the share that is done, now and then.

    Raises:
        ParameterError: If the motion needs forces and the order has no contact task.
        SolverError: If the first tick has no solution.
    """
    state, settings = BodyState(human, qpos, qvel), settings or MotionSettings()
    step = settings.step
    limits = limits or JointLimits(human, step)
    unknowns = ForceUnknowns(state, order, ground) if ground else AccelerationUnknowns(state, order)
    times = start + step * np.arange(max(1, round((stop - start) / step)) + 1)
    ticks, stopped = list[dict[str, Any]](), ""
    for k, now in enumerate(times.tolist()):
        began = clock.perf_counter()
        if k:
            state = state.integrated(ticks[-1]["qacc"], step)
        else:
            state = first_state(state, order, now, settings)
        state = _begun(state, order, unknowns.impacts or not k, now, settings)
        try:
            ticks.append(_tick(state, order, unknowns, limits, now, began, settings))
        except SolverError as error:
            if k < 2:
                raise
            stopped = str(error)
            break
        if progress is not None and k % 50 == 0:
            progress(k / len(times))
    arrays = {name: np.array([tick[name] for tick in ticks]) for name in ticks[0]}
    return OrderedMotion(
        human, order, times[: len(ticks)], **arrays, sites=unknowns.sites, stopped=stopped
    )


def first_state(
    state: BodyState, order: TaskOrder, time: float, settings: MotionSettings | None = None
) -> BodyState:
    """Return the initial state of a motion, lifted out of the ground.

    A recorded posture has its feet some millimetres in the ground; a motion must not begin with a
    jump. Gauss-Newton steps, by the legs. (Feet above the ground come down by themselves.)
    """
    for task in order.tasks:  # an order may have moved somebody before
        task.reset()
    settings, (low, high) = settings or MotionSettings(), state.human.limits
    share, most = settings.readiness(state.human), MAX_CORRECTION
    tasks = [task for task in order.tasks if task.initialises]
    for _ in range(MAX_CORRECTIONS):
        for task in tasks:
            task.begin(state, time)
        rows = [task.position_rows(state, time) for task in tasks]
        lower, upper = np.full(len(share), -most), np.full(len(share), most)
        lower[6:] = np.clip(low - state.qpos[7:], -most, 0.0)
        upper[6:] = np.clip(high - state.qpos[7:], 0.0, most)
        levels = [scaled(row.level, share) for row in rows]
        bounds = {"lower": lower / share, "upper": upper / share}
        step = share * solve_hierarchy(levels, **bounds, singular=settings.min_gain).x
        if np.abs(step).max() < 1e-6:
            break
        state = state.moved_to(integrate(state.model, state.qpos, step), state.qvel)
    for task in order.tasks:
        task.reset()
    return state


def velocity_after_impact(
    state: BodyState, order: TaskOrder, time: float, settings: MotionSettings | None = None
) -> Float[Array, " nv"]:
    r"""Return the velocity right after contacts have begun: an inelastic impact.

    The contacts stop their points, and the rest of the body changes its velocity as little as its
    inertia allows,

    .. math:: \min_{v^+} (v^+ - v^-)^T M (v^+ - v^-) .
    """
    wide = np.full(len(state.qvel), 1e4)
    return solve_hierarchy(
        [task.velocity_rows(state, time).level for task in order.tasks if task.causes_impact],
        lower=-wide,
        upper=wide,
        preferred=state.qvel,
        metric=state.mass_matrix,
        singular=(settings or MotionSettings()).min_gain,
    ).x


def _missed(order: TaskOrder, rows: list[list[Rows]], desired, qacc) -> tuple[Array, Array]:
    """Return which tasks had rows, and the error of an acceleration in each."""
    flat = [row for level in rows for row in level]
    active = [len(row.right) > 0 for row in flat]
    missed = [row.missed(qacc) for row in flat]
    if order.posture is not None:
        active.append(True)
        missed.append(qacc - desired)
    return np.array(active, dtype=bool), np.array([sqrt(m @ m) for m in missed])

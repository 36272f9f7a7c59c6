r"""A gait from ordered tasks that moves by forces: joint moments and ground reactions come with it.

The unknowns are joint accelerations and contact forces; the acceleration of the root follows from
the equations of motion (:mod:`plantigrade.reproduce.ground_forces`), which therefore hold at every
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

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.dynamics.centroid import centroid
from plantigrade.errors import ParameterError, SolverError
from plantigrade.kinematics.state import State
from plantigrade.kinematics.trajectory import Trajectory
from plantigrade.models import Human
from plantigrade.reproduce.gait import ContactSchedule, GaitTasks, gait_order, phase_ends
from plantigrade.reproduce.ground_forces import (
    EDGES,
    FRICTION,
    GREATEST,
    UNIT,
    FrictionPyramid,
    LoadLimit,
    ReducedDynamics,
    reduced_dynamics,
)
from plantigrade.reproduce.reference import SIDES, Reference
from plantigrade.reproduce.support import carried_path
from plantigrade.wbc.force_tasks import (
    SOLE,
    AngularMomentumTask,
    LandingTask,
    PassingPosture,
    PlacingHeelTask,
    SoleContactTask,
)
from plantigrade.wbc.hierarchy import Level, solve_hierarchy
from plantigrade.wbc.joint_limits import JointLimits
from plantigrade.wbc.ordered_motion import (
    REST,
    SINGULAR,
    STEP,
    OrderedMotion,
    TaskOrder,
    arrest,
    ended,
    settle,
    stack,
)
from plantigrade.wbc.tasks import ComTask, ContactTask, Task

BALANCE = 49.0  # stiffness of the centre of mass [1/s²]
REACH = 0.01  # a point higher above the ground than this carries nothing [m]
# What the last level weighs against the squared posture error [rad²/s⁴], per squared unit of force:
SMALL, STEADY = 1.0, 1.0  # its size, its change from the instant before


@dataclass(frozen=True, kw_only=True)
class ForcedMotion(OrderedMotion):
    """A motion with the forces that move it.

    Attributes:
        tau: Generalised forces in the order of ``qvel``: nothing at the root, then joint
            moments [N m].
        contact_force: Ground reaction on each contact point, world [N]; zero where it carries none.
        contact_point: Where it acts, world [m]; NaN where it carries none.
        side: ``"r"`` or ``"l"`` of each contact point.
        segment: Foot segment of each contact point.
        root_residual: What the equations of motion leave unexplained at the root [N, N m].
    """

    tau: Float[Array, "n nv"]
    contact_force: Float[Array, "n k 3"]
    contact_point: Float[Array, "n k 3"]
    side: tuple[str, ...]
    segment: tuple[str, ...]
    root_residual: Float[Array, "n 6"] = field(repr=False)

    def foot(self, side: str) -> tuple[Float[Array, "n 3"], Float[Array, "n 3"]]:
        """Return the ground reaction on a foot [N] and its centre of pressure [m], NaN without."""
        mine = [s == side for s in self.side]
        force = self.contact_force[:, mine]
        point = np.nan_to_num(self.contact_point[:, mine])
        load = force[:, :, 2].sum(axis=1)[:, None]
        moved = (force[:, :, 2:] * point).sum(axis=1)
        centre = np.divide(moved, load, out=np.full_like(moved, np.nan), where=load > 1e-6)
        return force.sum(axis=1), centre


def gait_with_forces(
    reference: Reference,
    tasks: GaitTasks | None = None,
    *,
    friction: float = FRICTION,
    step: float = STEP,
    progress: Callable[[float], None] | None = None,
) -> ForcedMotion:
    """Rebuild a recorded gait by forces.

    Args:
        reference: The recorded gait.
        tasks: Which tasks; the default ones if absent.
        friction: Coefficient of friction.
        step: Time step [s].
        progress: Called with the share that is done, now and then.
    """
    return move_with_forces(
        reference.human,
        forced_order(reference, tasks or GaitTasks()),
        reference.at(reference.start),
        reference.velocity_at(reference.start),
        start=reference.start,
        stop=reference.stop,
        step=step,
        load=LoadLimit(reference),
        friction=friction,
        progress=progress,
    )


def forced_order(reference: Reference, tasks: GaitTasks) -> TaskOrder:
    """Return the order of tasks that rebuilds a recorded gait by forces.

    Args:
        reference: The recorded gait.
        tasks: Which tasks.
    """
    schedule = ContactSchedule(reference)
    momentum = _momentum(reference)
    carried = carried_path(reference, schedule)
    levels: list[list[Task]] = []
    for level in gait_order(reference, tasks).levels:
        kept: list[Task] = []
        for task in level:
            if isinstance(task, ContactTask):
                args = schedule.points, schedule.radius, schedule
                kept.append(SoleContactTask(*args, stiffness=SOLE**2))
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
    levels[last].append(momentum)
    levels.append([_landing(reference, schedule)])
    return TaskOrder(levels, _posture(reference, tasks) if tasks.posture else None)


def _momentum(reference: Reference) -> AngularMomentumTask:
    recorded = centroid(reference.human, reference.qpos, reference.qvel)
    return AngularMomentumTask(
        Trajectory(reference.time, recorded.angular_momentum),
        Trajectory(reference.time, reference.qpos),
    )


def _landing(reference: Reference, schedule: ContactSchedule) -> LandingTask:
    landings = []
    for contact in reference.contacts:
        mine = (schedule.side == contact.side) & (schedule.region == contact.region)
        if contact.region == "heel" and mine.any():
            landings.append((np.flatnonzero(mine), contact.start))
    return LandingTask(schedule.points, schedule.radius, landings)


def _posture(reference: Reference, tasks: GaitTasks) -> PassingPosture:
    ends = phase_ends(reference, tasks.phases)
    postures = reference.at(ends)
    velocities = np.array([reference.velocity_at(float(t)) for t in ends])

    def phase(time: float) -> int:
        return min(int(np.searchsorted(ends, time + 1e-9, side="right")), len(ends) - 1)

    return PassingPosture(
        lambda t: (postures[phase(t)], float(ends[phase(t)])), lambda t: velocities[phase(t)]
    )


def move_with_forces(
    human: Human,
    order: TaskOrder,
    qpos: Float[Array, " nq"],
    qvel: Float[Array, " nv"] | None = None,
    *,
    start: float = 0.0,
    stop: float,
    step: float = STEP,
    load: Callable[[str, float], float] | None = None,
    friction: float = FRICTION,
    limits: JointLimits | None = None,
    progress: Callable[[float], None] | None = None,
) -> ForcedMotion:
    """Move a person by an order of tasks and the forces it takes.

    Args:
        human: Who moves.
        order: The tasks. The points of its contact task carry the forces.
        qpos: Configuration to start from.
        qvel: Velocity to start with; rest if absent.
        start: Time of the start [s].
        stop: Time of the end [s].
        step: Time step [s].
        load: Greatest vertical force of a foot (``"r"`` or ``"l"``) at a time [body weights]; no
            limit if absent.
        friction: Coefficient of friction.
        limits: Joint limits; the person's if absent.
        progress: Called with the share that is done, now and then.

    Raises:
        ParameterError: If the order has no contact task.
    """
    contact = next((t for t in order.tasks if isinstance(t, ContactTask)), None)
    if contact is None:
        raise ParameterError(
            f"the order ({', '.join(order.names)}) has no ContactTask; forces need one to act at"
        )
    state = State(human, qpos, qvel)
    model = human.model
    weight = state.mass * float(np.linalg.norm(model.opt.gravity))
    pyramid = FrictionPyramid(friction, weight)
    strength = np.where(
        model.jnt_actfrclimited[1:, None].astype(bool), model.jnt_actfrcrange[1:], [-1e6, 1e6]
    ).T
    limits = limits or JointLimits(human, step)
    out = _empty(human, order, len(contact.points), start, stop, step)
    before = np.zeros((len(contact.points), EDGES))
    for k, now in enumerate(out.time):
        began = clock.perf_counter()
        time = float(now)
        if k:
            state.integrate(out.qacc[k - 1], step)
            for task in order.tasks:
                task.begin(state, time)
        else:
            _start(state, order, time)
        rows = [[task.level(state, time) for task in level] for level in order.levels]
        height = state.position(contact.points)[:, 2] - contact.radius
        on = np.flatnonzero(contact.on & (height < REACH))
        dynamics = reduced_dynamics(state, contact.points, contact.radius, on, pyramid)
        hard = [dynamics.strength(*strength), *_loads(load, time, out, on, dynamics.n_joints)]
        wanted = -REST * state.qvel
        if order.posture is not None:
            wanted = order.posture.acceleration(state, time)
        low, high = limits.bounds(state)
        n_shares = dynamics.push.shape[1]
        preferred, metric = _preference(dynamics, wanted, before[on].ravel())
        built = clock.perf_counter()
        try:
            solution = solve_hierarchy(
                [stack(hard), *(dynamics.rows(stack(level)) for level in rows)],
                lower=np.concatenate([low[6:], np.zeros(n_shares)]),
                upper=np.concatenate([high[6:], np.full(n_shares, GREATEST / UNIT)]),
                preferred=preferred,
                metric=metric,
                singular=SINGULAR,
            )
        except SolverError as error:
            return ended(out, k, error)
        solved = clock.perf_counter()
        y = solution.x.copy()
        share = y[dynamics.n_joints :]
        np.maximum(share, 0.0, out=share)  # what is left of the solver's tolerance
        before[:] = 0.0
        before[on] = share.reshape(-1, EDGES)
        qacc = dynamics.acceleration(y)
        tau = state.mass_matrix @ qacc + state.bias - dynamics.push @ share
        out.qpos[k], out.qvel[k], out.qacc[k] = state.qpos, state.qvel, qacc
        out.root_residual[k], out.tau[k, 6:] = tau[:6], tau[6:]
        out.contact_force[k, on] = pyramid.force(share)
        out.contact_point[k, on] = state.position(contact.points)[on]
        out.contact_point[k, on, 2] -= contact.radius[on]
        out.exact[k] = solution.exact
        out.solver_time[k], out.state_time[k] = solved - built, built - began
        flat = [row for level in rows for row in level]
        for column, row in enumerate(flat):
            out.active[k, column] = len(row.lower) > 0
            out.residual[k, column] = np.linalg.norm(row.residual(qacc))
        if order.posture is not None:
            out.active[k, -1] = True
            out.residual[k, -1] = np.linalg.norm(qacc - wanted)
        if progress is not None and k % 50 == 0:
            progress(k / len(out.time))
    return out


def _start(state: State, order: TaskOrder, time: float) -> None:
    """Bring a first state into agreement with the contacts."""
    for task in order.tasks:
        task.reset()
    settle(state, order, time)
    if any([task.begin(state, time) for task in order.tasks]):
        state.move_to(state.qpos, arrest(state, order, time))


def _loads(load, time: float, out: ForcedMotion, on: np.ndarray, n_joints: int) -> list[Level]:
    """Return the rows that bound the vertical force of each foot."""
    if load is None:
        return []
    sides = np.array(out.side)[on]
    rows, bound = [], []
    for side in SIDES:
        most = load(side, time)
        mine = sides == side
        if mine.any() and most < GREATEST:
            rows.append(np.concatenate([np.zeros(n_joints), np.repeat(mine, EDGES)]))
            bound.append(most / UNIT)
    if not rows:
        return []
    return [Level(np.array(rows), np.full(len(rows), -np.inf), np.array(bound), "load")]


def _preference(dynamics: ReducedDynamics, wanted, before) -> tuple[np.ndarray, np.ndarray]:
    """Return what the last level prefers, and its metric."""
    metric = dynamics.matrix.T @ dynamics.matrix
    right = dynamics.matrix.T @ (wanted - dynamics.offset)
    forces = np.arange(dynamics.n_joints, len(metric))
    metric[forces, forces] += SMALL + STEADY
    right[forces] += STEADY * before
    return np.linalg.solve(metric, right), metric


def _empty(human: Human, order: TaskOrder, k: int, start, stop, step) -> ForcedMotion:
    n = max(1, round((stop - start) / step)) + 1
    nq, nv = human.model.nq, human.model.nv
    names = order.names
    return ForcedMotion(
        time=start + step * np.arange(n),
        qpos=np.empty((n, nq)),
        qvel=np.empty((n, nv)),
        qacc=np.zeros((n, nv)),
        names=names,
        active=np.zeros((n, len(names)), dtype=bool),
        residual=np.zeros((n, len(names))),
        solver_time=np.zeros(n),
        state_time=np.zeros(n),
        exact=np.ones(n, dtype=bool),
        tau=np.zeros((n, nv)),
        contact_force=np.zeros((n, k, 3)),
        contact_point=np.full((n, k, 3), np.nan),
        side=tuple(side for _, side, _ in human.contact_points),
        segment=tuple(segment for _, _, segment in human.contact_points),
        root_residual=np.zeros((n, 6)),
    )

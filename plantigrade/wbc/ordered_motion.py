r"""A motion from an order of tasks: at every instant, the hierarchy's acceleration, integrated.

One noun and one verb: a :class:`TaskOrder` (levels of tasks, most important first, and what is
preferred where they leave freedom) and :func:`move`. At every tick the tasks' rows become a
hierarchical quadratic program in the generalised acceleration (Eqs. 2-9 of [Boukheddimi]_),
its answer is integrated over the step, and so on. Where a contact begins, velocities jump first:
the contacts stop their points, and the rest of the body changes its velocity as little as its
inertia allows,

.. math:: \min_{v^+} (v^+ - v^-)^T M (v^+ - v^-),

which is an inelastic impact.

Least squares in the coordinates would use every joint alike. The unknowns are scaled, so that an
order can spare some (:data:`RELUCTANCE`) where others can do what a task asks: in walking, arms and
neck.
"""

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TypeVar

import mujoco
import numpy as np

from plantigrade.arrays import Array, Bool, Float
from plantigrade.errors import SolverError
from plantigrade.kinematics.state import State
from plantigrade.models import Human
from plantigrade.wbc.hierarchy import Level, solve_hierarchy
from plantigrade.wbc.joint_limits import JointLimits
from plantigrade.wbc.tasks import PostureTask, Task

STEP = 0.005  # [s]
# A direction in which a task moves less than this per unit of joint acceleration is singular: a
# straight knee lengthens the leg by nothing, and asking it to would ask for infinite speed. It also
# lets short toes give way a little where a foot rigid as a machine's would pull at the whole body:
# of contacts, turns of a segment that move its points by less per radian are not held.
SINGULAR = 0.02
# Nobody walking waves the arms to lift the centre of mass by a millimetre, though the arms could
# where the legs are nearly straight: to the tasks, what is spared counts this little.
RELUCTANCE = 0.1
UPPER_BODY = (
    "arm_",
    "elbow_",
    "pro_sup",
    "wrist_",
    "fingers_",
    "clavicle_",
    "neck_",
    "lower_neck_",
    "upper_neck_",
)
SETTLING = 10  # steps at most from a recorded posture to one that is not in the ground
LARGEST_STEP = 0.1  # of any coordinate in one of them [rad, m]
# How readily joints move in them: the foot before the leg, the leg before the rest of the body.
LIFTING = {
    ("mtp", "cuboid_", "heel_"): 1.0,
    ("ankle_", "subtalar_"): 0.7,
    ("knee_", "hip_"): 0.5,
}
STAYS = 0.02
REST = 5.0  # damping of what no task determines, where there is no posture [1/s]


@dataclass(frozen=True)
class TaskOrder:
    """Tasks in strict order.

    Attributes:
        levels: The tasks of each level, most important first.
        posture: What is preferred where the levels leave freedom; rest if absent. It is the
            lowest level of all.
        spared: First letters of coordinates that the tasks use least (:data:`RELUCTANCE`) where
            others can do it.
    """

    levels: Sequence[Sequence[Task]]
    posture: PostureTask | None = None
    spared: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the tasks, in order."""
        names = [task.name for level in self.levels for task in level]
        return (*names, *([self.posture.name] if self.posture else []))

    @property
    def tasks(self) -> tuple[Task, ...]:
        """All tasks above the posture, in order."""
        return tuple(task for level in self.levels for task in level)


@dataclass(frozen=True)
class OrderedMotion:
    """What came out.

    Attributes:
        time: Time of each tick [s].
        qpos: Configurations.
        qvel: Velocities; after the impact where there is one.
        qacc: Accelerations, from each tick to the next.
        names: Names of the tasks, in order.
        active: Whether each task asked for anything.
        residual: By how much each task's acceleration was missed [its unit per s²].
        solver_time: Time in the hierarchical program at each tick [s].
        state_time: Time in kinematics, Jacobians and rows at each tick [s].
        exact: Whether no inequality was in the way.
        stopped: Why it ended early; empty where it did not.
    """

    time: Float[Array, " n"]
    qpos: Float[Array, "n nq"]
    qvel: Float[Array, "n nv"]
    qacc: Float[Array, "n nv"]
    names: tuple[str, ...]
    active: Bool[Array, "n n_tasks"]
    residual: Float[Array, "n n_tasks"]
    solver_time: Float[Array, " n"] = field(repr=False)
    state_time: Float[Array, " n"] = field(repr=False)
    exact: Bool[Array, " n"] = field(repr=False)
    stopped: str = ""


Motion = TypeVar("Motion", bound=OrderedMotion)


def move(
    human: Human,
    order: TaskOrder,
    qpos: Float[Array, " nq"],
    qvel: Float[Array, " nv"] | None = None,
    *,
    start: float = 0.0,
    stop: float,
    step: float = STEP,
    limits: JointLimits | None = None,
    progress: Callable[[float], None] | None = None,
) -> OrderedMotion:
    """Move a person by an order of tasks.

    Args:
        human: Who moves.
        order: The tasks.
        qpos: Configuration to start from.
        qvel: Velocity to start with; rest if absent.
        start: Time of the start [s].
        stop: Time of the end [s].
        step: Time step [s].
        limits: Joint limits; the person's if absent.
        progress: Called with the share that is done, now and then.

    Example:
        >>> import numpy as np
        >>> from plantigrade.wbc.tasks import ComTask
        >>> from plantigrade.kinematics.trajectory import Trajectory
        >>> from plantigrade.models import Human
        >>> human = Human.create()
        >>> here = State(human, human.standing()).com
        >>> down = ComTask(Trajectory.fixed(here - np.array([0.0, 0.0, 0.1])))
        >>> motion = move(human, TaskOrder([[down]]), human.standing(), stop=1.0)
        >>> round(float(State(human, motion.qpos[-1]).com[2] - here[2]), 3)
        -0.1
    """
    state = State(human, qpos, qvel)
    limits = limits or JointLimits(human, step)
    n = max(1, round((stop - start) / step)) + 1
    names = order.names
    nq, nv = human.model.nq, human.model.nv
    out = OrderedMotion(
        start + step * np.arange(n),
        np.empty((n, nq)),
        np.empty((n, nv)),
        np.zeros((n, nv)),
        names,
        np.zeros((n, len(names)), dtype=bool),
        np.zeros((n, len(names))),
        np.zeros(n),
        np.zeros(n),
        np.ones(n, dtype=bool),
    )
    ease = _ease(human, order.spared)
    for k, now in enumerate(out.time):
        began = clock.perf_counter()
        if k:
            state.integrate(out.qacc[k - 1], step)
        if not k:
            for task in order.tasks:  # an order may have moved somebody before
                task.reset()
            settle(state, order, float(now))
        touched = [task.begin(state, float(now)) for task in order.tasks]
        if any(touched):
            state.move_to(state.qpos, arrest(state, order, float(now)))
        out.qpos[k], out.qvel[k] = state.qpos, state.qvel
        rows = [[task.level(state, float(now)) for task in level] for level in order.levels]
        low, high = limits.bounds(state)
        preferred = _preferred(state, order, float(now))
        built = clock.perf_counter()
        try:
            solution = solve_hierarchy(
                [_eased(stack(level), ease) for level in rows],
                lower=low / ease,
                upper=high / ease,
                preferred=preferred / ease,
                singular=SINGULAR,
            )
        except SolverError as error:
            return ended(out, k, error)
        solved = clock.perf_counter()
        x = ease * solution.x
        out.qacc[k], out.exact[k] = x, solution.exact
        out.solver_time[k], out.state_time[k] = solved - built, built - began
        column = 0
        for level in rows:
            for row in level:
                out.active[k, column] = len(row.lower) > 0
                out.residual[k, column] = np.linalg.norm(row.residual(x))
                column += 1
        if order.posture is not None:
            out.active[k, column] = True
            out.residual[k, column] = np.linalg.norm(x - preferred)
        if progress is not None and k % 50 == 0:
            progress(k / n)
    return out


def ended(motion: Motion, ticks: int, error: SolverError) -> Motion:
    """Return the first ticks of a motion that could not go on, with the reason.

    Raises:
        SolverError: The error itself, where it could not even begin.
    """
    if ticks < 2:
        raise error
    n = len(motion.time)
    kept = {
        f.name: getattr(motion, f.name)[:ticks]
        for f in fields(motion)
        if isinstance(getattr(motion, f.name), np.ndarray) and len(getattr(motion, f.name)) == n
    }
    return replace(motion, **kept, stopped=str(error))


def arrest(state: State, order: TaskOrder, time: float) -> Float[Array, " nv"]:
    """Return the velocity right after contacts have begun."""
    wide = np.full(len(state.qvel), 1e4)
    return solve_hierarchy(
        [task.velocity_level(state, time) for task in order.tasks if task.arrests],
        lower=-wide,
        upper=wide,
        preferred=state.qvel,
        metric=state.mass_matrix,
        singular=SINGULAR,
    ).x


def settle(state: State, order: TaskOrder, time: float) -> None:
    """Lift a first posture out of the ground.

    A recorded posture has its feet some millimetres in the ground; a motion must not begin with a
    jump. Gauss-Newton steps, by the legs. (Feet above the ground come down by themselves.)
    """
    human, low, high = state.human, *state.human.limits
    share = np.full(len(state.qvel), STAYS)
    for i, name in enumerate(human.coordinates):
        share[6 + i] = next((s for words, s in LIFTING.items() if name.startswith(words)), STAYS)
    tasks = [task for task in order.tasks if task.settles]
    for _ in range(SETTLING):
        for task in tasks:
            task.begin(state, time)
        rows = [task.position_level(state, time) for task in tasks]
        lower, upper = np.full(len(share), -LARGEST_STEP), np.full(len(share), LARGEST_STEP)
        lower[6:] = np.clip(low - state.qpos[7:], -LARGEST_STEP, 0.0)
        upper[6:] = np.clip(high - state.qpos[7:], 0.0, LARGEST_STEP)
        step = (
            share
            * solve_hierarchy(
                [_eased(row, share) for row in rows],
                lower=lower / share,
                upper=upper / share,
                singular=SINGULAR,
            ).x
        )
        if np.abs(step).max() < 1e-6:
            break
        qpos = state.qpos.copy()
        mujoco.mj_integratePos(state.model, qpos, step, 1.0)
        state.move_to(qpos, state.qvel)
    for task in order.tasks:
        task.reset()


def stack(rows: Sequence[Level]) -> Level:
    """Return the rows of several tasks as one level."""
    asked = [row for row in rows if len(row.lower)] or rows[:1]
    if len(asked) == 1:
        return asked[0]
    lower = np.concatenate([r.lower for r in asked])
    equal = all(r.lower is r.upper for r in asked)
    return Level(
        np.concatenate([r.matrix for r in asked]),
        lower,
        lower if equal else np.concatenate([r.upper for r in asked]),
        " and ".join(r.name for r in asked),
    )


def _ease(human: Human, spared: tuple[str, ...]) -> Float[Array, " nv"]:
    """Return how readily each coordinate is used by tasks that could do without it."""
    ease = np.ones(human.model.nv)
    for i, name in enumerate(human.coordinates):
        if name.startswith(spared):
            ease[6 + i] = RELUCTANCE
    return ease


def _eased(level: Level, ease: Float[Array, " nv"]) -> Level:
    return replace(level, matrix=level.matrix * ease)


def _preferred(state: State, order: TaskOrder, time: float) -> Float[Array, " nv"]:
    if order.posture is None:
        return -REST * state.qvel
    return order.posture.acceleration(state, time)

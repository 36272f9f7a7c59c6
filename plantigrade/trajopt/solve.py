"""Solve a task: mesh refinement, warm starts and fallbacks.

A task is solved on its own mesh from its own guess, or from the motion of a similar task on the
corresponding mesh. If the solver stalls near by, it goes on from there with a larger barrier. If
that fails, easier problems lead the way: half the nodes; then a cost of smoothness alone, from
which the true problem is then solved. Once solved, the mesh is refined wherever the motion between
nodes requires a wrench that contact cannot provide, or more torque, speed or range than a joint
has, takes limbs into each other, or a swinging foot too low.
Every step is a :class:`~plantigrade.trajopt.solution.Stage` that the user sees.
"""

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.threads import on_one_thread
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.solution import Solution, Stage
from plantigrade.trajopt.solvers.interior_point import NEARLY_MET, InteriorPoint
from plantigrade.trajopt.solvers.result import Iterate, Multipliers, Options
from plantigrade.trajopt.tasks.task import MotionTask, coefficients, sample_times
from plantigrade.trajopt.terms.effort import Acceleration, Work
from plantigrade.trajopt.transcription.mesh import nodes_like, split
from plantigrade.trajopt.warm_start import WarmStart

Solver = Literal["interior-point", "ipopt"]
Start = tuple[Array, Array, Multipliers | None]
Progress = Callable[[str, Iterate], bool | None]

MAX_RESIDUAL_WRENCH = 1.2e-3
"""Residual wrench between nodes above which the mesh is refined [body weights, body weights · m];
2e-3 moves a centre of pressure out of the base of support by 2 mm, of 3 mm allowed."""
MIN_LIMB_DISTANCE = -0.001
"""Distance of limbs below which the mesh is refined [m]; the rows are accurate to a millimetre."""
# [1] relative torque or speed of a joint between nodes above which the mesh is refined
MAX_LOAD = 1.0
MAX_RANGE_EXCESS = 0.004  # [rad] excess of a joint range above which the mesh is refined
MAX_FOOT_DEPTH = 0.003  # [m] depth of a swing foot above which the mesh is refined
MAX_FEASIBLE_WRENCH = 0.5
"""Residual wrench between nodes above which a motion is infeasible [body weights, body weights ·
m]; no finer mesh has made such a motion feasible."""
MUCH_TOO_COARSE = 2.0
"""Ratio of that wrench to the allowed one from which a mesh is refined before its problem is solved
to the end [1]: well above what may still change. Chosen."""
MAX_REFINEMENTS = 8  # [1] maximum number of mesh refinements
LASTING_ERRORS = 2  # [1] rounds of refinement after which neighbours are halved again. Chosen.
MAX_STALLED_VIOLATION = 0.3  # [1] violation of a stalled solver beyond the help of smoothness
LOOSER = 10.0
"""Tolerance with which a stalled solver goes on, relative to that of the task [1]; the last barrier
parameter is larger by as much. Chosen: with 30 kg in one hand, the barrier of a walk gets small
while its cost still falls; with ten times as much it is solved."""
COARSE_MESH_NODES = 250
"""Minimum number of nodes for a preceding coarse mesh [1]. Walks of 8 to 10 steps and stairs, 165
to 225 nodes, take two thirds of the time without one."""
COARSE_NODES = 75  # [1] nodes of the coarse mesh


@dataclass(frozen=True, eq=False)
class _Ending:
    """Where a stage ended."""

    problem: Problem
    c: Array
    u: Array
    status: str
    success: bool
    multipliers: Multipliers | None = None

    @property
    def over(self) -> bool:
        """Whether it succeeded, waits for a finer mesh, or the user stopped it."""
        return self.success or self.paused or self.status == "stopped"

    @property
    def paused(self) -> bool:
        """Whether it waits for a finer mesh."""
        return self.status == "paused"

    def on(self, problem: Problem) -> Start:
        """Return it as the start of another problem."""
        return transferred(self.problem, self.c, self.u, self.multipliers, problem)


@on_one_thread
def synthesize(
    body: ContactBody,
    task: MotionTask,
    *,
    solver: Solver = "interior-point",
    warm: Solution | WarmStart | None = None,
    options: Options | None = None,
    progress: Progress | None = None,
    c0: Float[Array, "n_coefficients nv"] | None = None,
    refinements: int = MAX_REFINEMENTS,
    rescue: bool = True,
) -> Solution:
    """Return the motion of a person who does a task.

    Args:
        body: The person and the places that can carry force.
        solver: ``"interior-point"``, or ``"ipopt"`` as the reference.
        options: Settings of the interior point; by default with the tolerance of the task.
        progress: Called with the stage and every iteration; returning True stops with the best so
            far.
        c0: Initial coefficients in place of the task's guess.
        refinements: How often the mesh may be refined.
        rescue: Whether to try easier problems where the solver fails.

    Returns:
        The motion, also if no solver succeeded: see ``success`` and ``stages``.

    Raises:
        ParameterError: If the solver is unknown, or the warm start has other joints.
    """
    if solver not in ("interior-point", "ipopt"):
        raise ParameterError(f"solver is {solver!r}; allowed are 'interior-point' and 'ipopt'")
    if warm is not None and warm.problem.names != body.symbolic.names:
        raise ParameterError(
            f"cannot warm-start: the run has {len(warm.problem.names)} coordinates, this person "
            f"{len(body.symbolic.names)}"
        )
    options = options or Options(tolerance=task.tolerance)
    run = _Stages(body, task, options, progress)
    nodes = None if warm is None else nodes_like(task.plan, warm.switches, warm.nodes)
    problem = task.problem(body, nodes)
    if warm is not None:
        switches = warm.switches, task.plan.switches
        solved = warm.coefficients, warm.forces, warm.multipliers
        start = transferred(warm.problem, *solved, problem, switches)
    else:
        c, u = task.start(body, problem)
        start = c if c0 is None else c0, u, None
    if solver == "ipopt":
        at = run.ipopt("IPOPT", problem, start)
    else:
        guessed = warm is None and c0 is None
        name = "first try" if warm is None else "warm start"
        at = _first(run, problem, start, name, guessed, pausing=refinements > 0)
        if warm is not None and not at.over and rescue:
            problem = task.problem(body)
            at = run.interior_point("first try", problem, (*task.start(body, problem), None))
        if not at.over and rescue:
            at = _rescued(run, problem, at)
    solve = run.ipopt if solver == "ipopt" else run.interior_point
    found = _refined(run, solve, at, refinements)
    if at.paused and not found.over and rescue:
        found = _refined(run, solve, _rescued(run, problem, found), refinements)
    return run.solution(found)


def _refined(
    run: "_Stages", solve: Callable[[str, Problem, Start], _Ending], at: _Ending, refinements: int
) -> _Ending:
    """Return a solution with more nodes wherever it is wrong between them."""
    for number in range(refinements if at.success or at.paused else 0):
        made = run.solution(at)
        # one round does for a periodic motion
        neighbours = number == 0 and made.problem.closure is None
        times, excess = _wrong(made)
        finer = split(made.nodes, times, excess, neighbours=neighbours)
        if len(finer) == len(made.nodes):
            break
        if number >= LASTING_ERRORS:  # they move on to the neighbours of what was divided
            finer = split(made.nodes, times, excess, neighbours=True)
        if excess.max() > MAX_FEASIBLE_WRENCH / MAX_RESIDUAL_WRENCH:
            break
        problem = run.task.problem(run.body, finer)
        after = solve("more nodes", problem, at.on(problem))
        if not after.success:
            if at.paused and after.over:
                return after  # the user stopped it
            break
        at = after
    return solve("same mesh", at.problem, at.on(at.problem)) if at.paused else at


def _wrong(solution: Solution) -> tuple[Array, Array]:
    """Return when the motion between nodes is not what it has to be, and how much too far off."""
    times, missing = solution.unexplained()
    use, low = solution.overloaded()[1], solution.too_low()[1]
    entered = solution.overlapping()[1]
    excess = np.where(missing > MAX_RESIDUAL_WRENCH, missing / MAX_RESIDUAL_WRENCH, 0.0)
    beyond = solution.beyond()[1]
    others = (
        (use > MAX_LOAD)
        | (entered > MIN_LIMB_DISTANCE)
        | (low > MAX_FOOT_DEPTH)
        | (beyond > MAX_RANGE_EXCESS)
    )
    excess = np.maximum(excess, others)
    return times[excess > 0], excess[excess > 0]


def _first(
    run: "_Stages", problem: Problem, start: Start, name: str, guessed: bool, *, pausing: bool
) -> _Ending:
    """Solve the problem; where it is large and starts from a guess, on a coarse mesh before.

    With ``pausing`` it is not solved to the end on a mesh that is much too coarse.
    """
    n = len(problem.nodes)
    rate = run.task.nodes_per_second * COARSE_NODES / n
    if guessed and n > COARSE_MESH_NODES and rate >= run.task.least_nodes_per_second:
        at = run.easier("coarse mesh", replace(run.task, nodes_per_second=rate))
        if at.success:
            name, start = "fine mesh", at.on(problem)
    return run.interior_point(name, problem, start, pausing=pausing)


def _rescued(run: "_Stages", problem: Problem, at: _Ending) -> _Ending:
    """Return what a larger barrier, or the first easier problem that can be solved, leads to.

    Where both the task and its coarse mesh stalled far from being met, nothing smoother is tried.
    """
    task = run.task
    if run.near_by:
        here = at.c, at.u, None
        loose = run.interior_point("larger barrier", problem, here, looser=LOOSER)
        if loose.success:
            after = run.interior_point("the task itself", problem, loose.on(problem))
            if after.over:
                return after
        elif loose.over:
            return loose
    coarse = replace(task, nodes_per_second=task.nodes_per_second / 2)
    smooth = (*(t for t in task.terms if not isinstance(t, Work)), Acceleration(1e-4))
    for name, easier in (("coarse mesh", coarse), ("smooth first", replace(task, terms=smooth))):
        if easier.nodes_per_second < task.least_nodes_per_second:
            continue
        if easier is not coarse and run.far_off:
            break
        middle = run.easier(name, easier)
        if middle.success:
            c, u, _ = middle.on(problem)
            after = run.interior_point("the task itself", problem, (c, u, None))
            if after.over:
                return after
        elif middle.over:
            return at
    return at


class _Stages:
    """Runs solvers and keeps a record of the stages."""

    def __init__(
        self, body: ContactBody, task: MotionTask, options: Options, progress: Progress | None
    ):
        self.body, self.task, self._options, self._progress = body, task, options, progress
        self._stages: list[Stage] = []

    @property
    def far_off(self) -> bool:
        """Whether every stage stalled far from feasibility."""
        return all(
            s.status == "stalled" and min(it.violation for it in s.history) > MAX_STALLED_VIOLATION
            for s in self._stages
        )

    @property
    def near_by(self) -> bool:
        """Whether the last stage stalled, and had been near by."""
        last = self._stages[-1]
        least = min((it.violation for it in last.history), default=np.inf)
        return last.status == "stalled" and least < NEARLY_MET

    def interior_point(
        self,
        name: str,
        problem: Problem,
        start: Start,
        *,
        pausing: bool = False,
        looser: float = 1.0,
    ) -> _Ending:
        """Run the interior point; with ``pausing`` until the mesh proves much too coarse.

        The tolerance is ``looser`` times that of the task.
        """
        started = clock.perf_counter()
        coarse = (lambda c, u: self._coarse(problem, c, u)) if pausing else None
        options = replace(self._options, tolerance=looser * self._options.tolerance)
        engine = InteriorPoint(problem, options)
        r = engine.solve(*start, lambda it: self._tell(name, it), coarse)
        self._note(name, "interior-point", problem, r.status, started, r.history)
        return _Ending(problem, r.c, r.u, r.status, r.success, r.multipliers)

    def easier(self, name: str, task: MotionTask) -> _Ending:
        """Run the interior point on another task, from its own guess."""
        problem = task.problem(self.body)
        return self.interior_point(name, problem, (*task.start(self.body, problem), None))

    def _coarse(self, problem: Problem, c: Array, u: Array) -> bool:
        """Return whether a motion misses much between nodes that a finer mesh can provide."""
        made = self.solution(_Ending(problem, c, u, "paused", False))
        times, missing = made.unexplained()
        much = (missing > MUCH_TOO_COARSE * MAX_RESIDUAL_WRENCH) & np.isfinite(missing)
        if not much.any() or missing.max() > MAX_FEASIBLE_WRENCH:
            return False
        return len(split(made.nodes, times[much])) > len(made.nodes)

    def ipopt(self, name: str, problem: Problem, start: Start) -> _Ending:
        """Run IPOPT, which takes no multipliers."""
        from plantigrade.trajopt.solvers import ipopt

        started, history = clock.perf_counter(), []

        def report(iterate: Iterate) -> bool | None:
            history.append(iterate)
            return self._tell(name, iterate)

        r = ipopt.solve(problem, *start[:2], callback=report)
        self._note(name, "ipopt", problem, r.status, started, tuple(history))
        return _Ending(problem, r.c, r.u, r.status, r.success)

    def solution(self, at: _Ending) -> Solution:
        """Return the motion where a stage ended."""
        found = at.problem, at.c, at.u, at.status, at.success
        return Solution(self.body, self.task, *found, tuple(self._stages), at.multipliers)

    def _tell(self, name: str, iterate: Iterate) -> bool | None:
        return self._progress(name, iterate) if self._progress is not None else None

    def _note(
        self,
        name: str,
        solver: Solver,
        problem: Problem,
        status: str,
        started: float,
        history: tuple[Iterate, ...],
    ) -> None:
        seconds = clock.perf_counter() - started
        self._stages.append(Stage(name, solver, len(problem.nodes), status, seconds, history))


def transferred(
    old: Problem,
    c: Array,
    u: Array,
    multipliers: Multipliers | None,
    new: Problem,
    switches: tuple[Array, Array] | None = None,
) -> Start:
    """Return the solution of an old problem as the start of a new one.

    With changes of contact of both (``switches``), what lies between two of them stays between
    them. Without, or where their numbers differ, times are scaled with the duration.
    """
    ends = np.array([0.0, new.basis.span]), np.array([0.0, old.basis.span])
    if switches is not None and len(switches[0]) == len(switches[1]):
        ends = switches[1], switches[0]

    def before(times: Array) -> Array:
        return np.interp(times, *ends)

    times = sample_times(new)
    then = np.clip(before(times), 0.0, old.basis.stop)
    q = old.states(c, then)[0] - old.drift(then) + new.drift(times)
    nodes, values = old.nodes, u
    if old.closure is not None:
        nodes = np.append(nodes, old.basis.span)
        values = np.vstack([values, values[:1, old.closure.u_source] * old.closure.u_sign])
    forces = np.zeros((len(new.nodes), new.n_unknowns))
    by_name = dict(zip(old.u_names, values.T, strict=False))  # not every task has a seat
    for i, name in enumerate(new.u_names):
        if name in by_name:
            forces[:, i] = np.interp(before(new.nodes), nodes, by_name[name])
    moved = None
    if multipliers is not None:
        moved = multipliers.moved(old.nodes, before(new.nodes))
    return coefficients(new, times, q), np.clip(forces, new.u_lower, new.u_upper), moved

"""From a task and a person to a motion: mesh, solver, and what is done where one fails.

A task is solved on its own mesh from its own guess, or from a motion of a task much like it, on the
nodes of that one. Where that fails, it is made easier: on half the nodes; with a cost that is all
smoothness, from which the true cost is taken up; by IPOPT. Once it is solved, nodes are added
wherever the motion asks between nodes for what no contact can give.
Every step is a :class:`~plantigrade.synthesize.solution.Stage` that the user sees.
"""

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.errors import ParameterError
from plantigrade.synthesize.problem.contact_body import ContactBody
from plantigrade.synthesize.problem.nlp import Problem
from plantigrade.synthesize.solution import Solution, Stage
from plantigrade.synthesize.solvers.interior_point import (
    InteriorPoint,
    Iterate,
    Multipliers,
    Options,
)
from plantigrade.synthesize.tasks.task import MotionTask, coefficients, sample_times
from plantigrade.synthesize.terms.effort import Acceleration, Work
from plantigrade.synthesize.transcription.mesh import nodes_like, split
from plantigrade.synthesize.warm_start import WarmStart

Solver = Literal["interior-point", "ipopt"]
Progress = Callable[[str, Iterate], bool | None]

UNEXPLAINED = 8e-4  # wrench between nodes that asks for more nodes [body weights]
REFINEMENTS = 4  # of adding nodes
MANY, FEW = 150, 75  # nodes from which a coarse mesh comes first, and its nodes
IPOPT_SECONDS = 60.0  # most time of IPOPT as the last resort


@dataclass
class _Point:
    """Where a stage ended."""

    problem: Problem
    c: Array
    u: Array
    status: str
    success: bool
    multipliers: Multipliers | None = None

    @property
    def stopped(self) -> bool:
        return self.status == "stopped"


def synthesize(
    body: ContactBody,
    task: MotionTask,
    *,
    solver: Solver = "interior-point",
    warm: Solution | WarmStart | None = None,
    options: Options | None = None,
    progress: Progress | None = None,
    c0: Float[Array, "n_coefficients nv"] | None = None,
    refinements: int = REFINEMENTS,
    rescue: bool = True,
) -> Solution:
    """Return the motion of a person who does a task.

    Args:
        body: The person with the places that can carry force.
        task: What is to be done.
        solver: ``"interior-point"``, or ``"ipopt"`` as the reference.
        warm: A motion of a task much like this one, to start from.
        options: Of the banded solver.
        progress: Told every iteration; returning True stops with the best so far.
        c0: Coefficients to start from instead of the task's guess.
        refinements: How often nodes are added where the motion asks between nodes for what no
            contact can give.
        rescue: Whether an easier problem is tried where the solver fails.

    Returns:
        The motion, also where no solver succeeded: ``success`` and ``stages`` say.

    Raises:
        ParameterError: If the solver is unknown, or the motion to start from is of other joints.
    """
    if solver not in ("interior-point", "ipopt"):
        raise ParameterError(f"solver is {solver!r}; allowed are 'interior-point' and 'ipopt'")
    if warm is not None and warm.problem.names != body.symbolic.names:
        raise ParameterError(
            f"cannot warm-start: the run has {len(warm.problem.names)} coordinates, this person "
            f"{len(body.symbolic.names)}"
        )
    run = _Runner(body, options, progress)
    nodes = None
    if warm is not None:
        nodes = nodes_like(task.plan, warm.switches, warm.nodes)
    problem = task.problem(body, nodes)
    c, u = task.start(body, problem)
    multipliers = None
    if c0 is not None:
        c = c0
    if warm is not None:
        old = warm.switches, task.plan.switches
        before = _Point(warm.problem, warm.coefficients, warm.forces, "", True, warm.multipliers)
        c, u, multipliers = _carried(before, problem, old)
    first = "warm start" if warm is not None else "first try"
    if solver == "ipopt":
        at = run.ipopt("IPOPT", problem, c, u)
    else:
        if warm is None and c0 is None and len(problem.nodes) > MANY:
            coarse = replace(
                task, nodes_per_second=task.nodes_per_second * FEW / len(problem.nodes)
            )
            p = coarse.problem(body)
            at = run.band("coarse mesh", p, *coarse.start(body, p))
            if at.success:
                first, (c, u, multipliers) = "fine mesh", _carried(at, problem)
        at = run.band(first, problem, c, u, multipliers)
        if warm is not None and not at.success and not at.stopped and rescue:
            problem = task.problem(body)
            at = run.band("first try", problem, *task.start(body, problem))
        if not at.success and not at.stopped and rescue:
            at = _rescued(run, body, task, problem, at)
    for _ in range(refinements if at.success else 0):
        made = _made(body, task, at, run)
        times, missing = made.unexplained()
        finer = split(made.nodes, times[missing > UNEXPLAINED])
        if len(finer) == len(made.nodes):
            break
        problem = task.problem(body, finer)
        again = _carried(at, problem)
        name = "more nodes"
        after = (
            run.ipopt(name, problem, *again[:2])
            if solver == "ipopt"
            else run.band(name, problem, *again)
        )
        if not after.success:
            break
        at = after
    return _made(body, task, at, run)


def _rescued(
    run: "_Runner", body: ContactBody, task: MotionTask, problem: Problem, at: _Point
) -> _Point:
    """Return what easier problems lead to, the first that succeeds."""
    coarse = replace(task, nodes_per_second=task.nodes_per_second / 2)
    easy = replace(
        task,
        terms=(*(t for t in task.terms if not isinstance(t, Work)), Acceleration(1e-4)),
    )
    for name, easier in (("coarse mesh", coarse), ("smooth first", easy)):
        p = easier.problem(body)
        middle = run.band(name, p, *easier.start(body, p))
        if middle.stopped:
            return at
        if middle.success:
            c, u, _ = _carried(middle, problem)
            after = run.band("the task itself", problem, c, u)
            if after.success or after.stopped:
                return after
    c, u = task.start(body, problem)
    after = run.ipopt("IPOPT", problem, c, u)
    return after if after.success else at


class _Runner:
    """Runs solvers and keeps account of it."""

    def __init__(self, body: ContactBody, options: Options | None, progress: Progress | None):
        self.body, self.options, self.progress = body, options, progress
        self.stages: list[Stage] = []

    def band(
        self, name: str, problem: Problem, c: Array, u: Array, m: Multipliers | None = None
    ) -> _Point:
        """Run the banded interior point."""
        started = clock.perf_counter()
        progress = self.progress
        told = None if progress is None else lambda it: progress(name, it)
        r = InteriorPoint(problem, self.options).solve(c, u, m, told)
        self._note(name, "interior-point", problem, r.status, started, r.history)
        return _Point(problem, r.c, r.u, r.status, r.success, r.multipliers)

    def ipopt(self, name: str, problem: Problem, c: Array, u: Array) -> _Point:
        """Run IPOPT."""
        from plantigrade.synthesize.solvers import ipopt

        started = clock.perf_counter()
        history: list[Iterate] = []

        def told(p: ipopt.Progress) -> bool | None:
            seconds = clock.perf_counter() - started
            history.append(
                Iterate(
                    p.number,
                    p.objective,
                    p.violation,
                    "",
                    np.nan,
                    np.nan,
                    0.0,
                    1.0,
                    seconds,
                )
            )
            return self.progress(name, history[-1]) if self.progress is not None else None

        r = ipopt.solve(problem, c, u, callback=told, max_seconds=IPOPT_SECONDS)
        self._note(name, "ipopt", problem, r.status, started, tuple(history))
        return _Point(problem, r.c, r.u, r.status, r.success)

    def _note(self, name, solver, problem, status, started, history) -> None:
        seconds = clock.perf_counter() - started
        self.stages.append(Stage(name, solver, len(problem.nodes), status, seconds, tuple(history)))


def _made(body: ContactBody, task: MotionTask, at: _Point, run: _Runner) -> Solution:
    return Solution(
        body, task, at.problem, at.c, at.u, at.status, at.success, tuple(run.stages), at.multipliers
    )


def _carried(
    at: _Point, new: Problem, switches: tuple[Array, Array] | None = None
) -> tuple[Array, Array, Multipliers | None]:
    """Return a point of one problem as a start of another.

    Args:
        at: The point.
        new: The other problem.
        switches: Changes of contact of the one and of the other; what is between two of them stays
            between them. Where they do not correspond, parts of the duration do.
    """
    old = at.problem
    ends = np.array([0.0, new.basis.span]), np.array([0.0, old.basis.span])
    if switches is not None and len(switches[0]) == len(switches[1]):
        ends = switches[1], switches[0]

    def then(times: Array) -> Array:
        return np.interp(times, *ends)

    times = sample_times(new)
    before = np.clip(then(times), 0.0, old.basis.stop)
    q = old.states(at.c, before)[0] - old.drift(before) + new.drift(times)
    nodes, values = old.nodes, at.u
    if old.closure is not None:
        nodes = np.append(nodes, old.basis.span)
        values = np.vstack([values, values[:1, old.closure.u_source] * old.closure.u_sign])
    u = np.zeros((len(new.nodes), new.n_unknowns))
    forces = dict(zip(old.u_names, values.T, strict=False))  # by name: a seat is not in every task
    for i, name in enumerate(new.u_names):
        if name in forces:
            u[:, i] = np.interp(then(new.nodes), nodes, forces[name])
    moved = None
    if at.multipliers is not None:
        moved = at.multipliers.moved(old.nodes, then(new.nodes))
    return coefficients(new, times, q), np.clip(u, new.u_lower, new.u_upper), moved

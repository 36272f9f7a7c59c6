r"""Times of a task as unknowns: when contacts begin and end, and how long the motion lasts.

Inside one problem these times are fixed, because nodes and knots lie on them. Around it, a bounded
quasi-Newton search [Byrd1995]_ moves them. What it needs is the least cost :math:`J^*(T)` and its
gradient. A solution is a stationary point of the Lagrangian :math:`L`, so that to first order the
motion need not be solved again where a time changes (the envelope theorem):

.. math:: \frac{\mathrm{d} J^*}{\mathrm{d} T} = \frac{\partial L}{\partial T}(x, \lambda, T).

The partial derivative is a central difference of the Lagrangian on two meshes whose times are
shifted a little, with coefficients, forces and multipliers as they are: two evaluations for each
time, no solve. Each step of the search is then one solve from the last motion.

Costs of different durations are compared by what a motion is for. One that travels counts per metre
of way, as the energy of walking does; a hop on the spot counts per hop, and a motion from rest to
rest as a whole: the task is to get there. Time itself costs nothing: a body that only stands has
nearly no cost, and where a motion gets cheaper the longer it lasts, its upper bound is the result.
:attr:`FoundTimes.at_bounds` names those.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.bounds import shown
from plantigrade.constants import SIDES
from plantigrade.errors import ParameterError
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.solution import Solution, Stage
from plantigrade.trajopt.solve import Progress, synthesize
from plantigrade.trajopt.solvers.result import Iterate, Multipliers
from plantigrade.trajopt.tasks.free_time import FreeTime
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.transcription.evaluation import Evaluation
from plantigrade.trajopt.transcription.mesh import nodes_like

MIN_WAY = 0.01
"""Distance of the feet from start to end above which a motion counts as travel [m]. Chosen."""
TaskAt = Callable[[Mapping[str, float]], MotionTask]
"""Makes the task of values of the free times, by name."""


@dataclass(frozen=True)
class SearchSettings:
    """Settings of the search."""

    solves: int = 10  #: Most motions to solve [1]; eight suffice for three times
    optimality: float = 1e-4  #: Largest error of the optimality conditions of a motion [1], at most
    #: Shift of a time for its derivative, of half the distance of its bounds [1]; small against
    #: phases, large against rounding
    shift: float = 1e-3
    #: First step, of half the distance of the bounds [1]; chosen
    first_step: float = 0.4
    #: Relative change of the cost at which the search ends [1]; below what motions solved to that
    #: optimality differ by
    tolerance: float = 5e-5
    #: Distance from a bound, relative to that of both, at which a time counts as on it [1]
    at_bound: float = 1e-3


@dataclass(frozen=True, eq=False)
class FoundTimes:
    """A motion on times of its own."""

    solution: Solution  #: The motion that costs least; its stages are those of every trial
    times: Mapping[str, float]  #: The times that were found, by name
    #: Cost of every trial, in order, for the cost of a metre or of the whole; inf where no motion
    #: was found
    costs: tuple[float, ...]
    at_bounds: tuple[str, ...]  #: Names of the times on one of their bounds
    stopped: bool = False  #: Whether the user stopped the search


def unit_of_cost(task: MotionTask) -> float:
    """Return what the cost of a task is divided by: its way [m] if it travels, otherwise 1."""
    plan = task.plan
    if plan.periodic:
        way = float(np.hypot(plan.advance, plan.aside))
    else:
        ends = [[plan.footprint(s, t) for s in SIDES] for t in (0.0, plan.duration)]
        feet = [[f.position[:2] for f in end if f is not None] for end in ends]
        way = (
            float(np.linalg.norm(np.subtract(*(np.mean(x, axis=0) for x in feet))))
            if all(feet)
            else 0.0
        )
    return way if way > MIN_WAY else 1.0


def lagrangian(
    problem: Problem,
    c: Float[Array, "n_coefficients nv"],
    u: Float[Array, "n_nodes n_unknowns"],
    multipliers: Multipliers,
) -> float:
    """Return cost plus multipliers times what rows lack to their limits.

    At a solution that is the cost: equations hold, and where an inequality has a multiplier it is
    at its limit.
    """
    e = Evaluation(problem)
    x = e.t.join(c, u)
    values = e.values(x)
    found = e.objective(x, values)
    for b, r in zip(e.blocks, values, strict=True):
        y, low, high = multipliers.rows[b.rows.name][:, b.at]
        found += float(np.sum(y[b.equations] * (r - b.lower)[b.equations]))
        for z, limits, sign in ((low, b.lower, -1.0), (high, b.upper, 1.0)):
            limited = b.inequalities & np.isfinite(limits)
            found += sign * float(np.sum(z[limited] * (r - limits)[limited]))
    return found


def cost_gradient(
    solution: Solution,
    task_of: Callable[[Float[Array, " n"]], MotionTask],
    at: Float[Array, " n"],
    shifts: Float[Array, " n"],
) -> Float[Array, " n"]:
    """Return the derivative of the least cost by each time, from the multipliers.

    The cost is in its unit (:func:`unit_of_cost`). Where a change of contact would vanish or
    another one appear, or a task cannot be, the difference is one-sided.

    Args:
        task_of: Makes the task of times.
        at: The times of the solution.
        shifts: How far each is shifted, in its own unit.

    Raises:
        ParameterError: If a shift either way changes the number of changes of contact.
    """
    assert solution.multipliers is not None
    c, u, nodes = solution.coefficients, solution.forces, solution.nodes
    here = lagrangian(solution.problem, c, u, solution.multipliers) / unit_of_cost(solution.task)

    def shifted(x: Array) -> float | None:
        try:
            task = task_of(x)
            mapped = nodes_like(task.plan, solution.switches, nodes)
            if mapped is None:
                return None
            problem = task.problem(placed(solution.body, task), mapped)
        except ParameterError:
            return None
        if problem.nodes.shape != solution.problem.nodes.shape:
            return None
        value = lagrangian(problem, c, u, solution.multipliers)  # type: ignore[arg-type]
        return value / unit_of_cost(task)

    found = np.zeros(len(at))
    for i, h in enumerate(shifts):
        step = h * (np.arange(len(at)) == i)
        sides = [(s, v) for s in (-1.0, 1.0) if (v := shifted(at + s * step)) is not None]
        if not sides:
            raise ParameterError(
                f"time {i + 1} cannot be shifted without another order of contacts"
            )
        ends = sides if len(sides) == 2 else sorted([(0.0, here), *sides])
        found[i] = (ends[1][1] - ends[0][1]) / (h * (ends[1][0] - ends[0][0]))
    return found


def placed(body: ContactBody, task: MotionTask) -> ContactBody:
    """Return the body with what acts on it at the times of a task; functions are shared."""
    return body.wearing(task.devices, task.wrenches, task.plan)


def find_times(
    body: ContactBody,
    task_of: TaskAt,
    times: Sequence[FreeTime],
    *,
    progress: Progress | None = None,
    settings: SearchSettings | None = None,
) -> FoundTimes:
    """Return the motion whose times cost least, and these times.

    The first motion is solved as any other, mesh refinement included; the others start from the
    best one, on the corresponding mesh. The last one is refined again where needed.

    Args:
        task_of: Makes the task of values by name.
        times: What is free.
        progress: Called with every iteration; returning True stops with the best so far.

    Raises:
        ParameterError: If the task cannot be at the guess or at one of the bounds, or two free
            times coincide at the guess.
    """
    from scipy.optimize import minimize

    settings = settings or SearchSettings()
    if not times or len({t.name for t in times}) < len(times):
        raise ParameterError("name at least one free time, each once")
    for bound in times:
        for value in (bound.least, bound.most):
            try:
                task_of({t.name: value if t is bound else t.guess for t in times}).nodes()
            except ParameterError as error:
                raise ParameterError(
                    f"free time {bound.name} cannot be {shown(value)}: {error}"
                ) from error
    search = _Search(body, task_of, tuple(times), settings, progress)
    try:
        first = search.slope(search.start)
        reach = _free_part(search.start, first)
        if reach > 0.0:
            search.scale = settings.first_step / reach
            minimize(
                search.trial,
                search.start,
                jac=True,
                method="L-BFGS-B",
                bounds=[(-1.0, 1.0)] * len(times),
                options={"ftol": 0.0, "gtol": 0.0},  # the trials decide
            )
    except _Over:
        pass
    return search.result()


class _Over(Exception):
    """The search has ended: stopped, out of solves, or without a first motion."""


def _free_part(x: Array, gradient: Array) -> float:
    """Return the largest slope along which the bounds let the times move."""
    blocked = ((x <= -1.0) & (gradient > 0.0)) | ((x >= 1.0) & (gradient < 0.0))
    return float(np.abs(np.where(blocked, 0.0, gradient)).max(initial=0.0))


@dataclass(frozen=True, eq=False)
class _Trial:
    """A motion of the search: where, its cost, and that by each time."""

    x: Array
    cost: float
    slope: Array
    solution: Solution


class _Search:
    """Motions by times, which go from -1 to 1 within their bounds."""

    def __init__(
        self,
        body: ContactBody,
        task_of: TaskAt,
        times: tuple[FreeTime, ...],
        settings: SearchSettings,
        progress: Progress | None,
    ):
        self._body, self._task_of, self._times, self._settings = body, task_of, times, settings
        self._progress, self._stopped, self._over = progress, False, False
        self._middle = np.array([(t.least + t.most) / 2 for t in times])
        self._half = np.array([(t.most - t.least) / 2 for t in times])
        self.start = (np.array([t.guess for t in times]) - self._middle) / self._half
        self.scale = 1.0
        self._best: _Trial | None = None
        self._failed: Solution | None = None
        self._costs: list[float] = []
        self._stages: list[Stage] = []

    def values(self, x: Array) -> dict[str, float]:
        """Return times by name."""
        numbers = self._middle + self._half * np.clip(x, -1.0, 1.0)
        return {t.name: float(v) for t, v in zip(self._times, numbers, strict=True)}

    def task(self, x: Array) -> MotionTask:
        """Return the task at times, solved exactly enough to compare costs."""
        task = self._task_of(self.values(x))
        return replace(task, tolerance=min(task.tolerance, self._settings.optimality))

    def slope(self, x: Array) -> Array:
        """Return the gradient at the first times."""
        self.trial(x)
        if self._best is None:
            raise _Over
        return self._best.slope

    def trial(self, x: Array) -> tuple[float, Array]:
        """Return the scaled cost of times and its gradient.

        Where no motion is found, both lead back to the best one.
        """
        best = self._best
        if best is not None and np.array_equal(best.x, x):
            return self.scale * best.cost, self.scale * best.slope
        if self._over or self._stopped or len(self._costs) >= self._settings.solves:
            raise _Over
        made = self._solved(x)
        if made is not None:
            if best is None or made.cost < best.cost:
                self._best = made
            if best is not None:
                change = abs(made.cost - best.cost)
                self._over = change < self._settings.tolerance * abs(best.cost)
            return self.scale * made.cost, self.scale * made.slope
        if best is None or self._stopped:
            raise _Over
        away, far = x - best.x, self.scale * abs(best.cost)
        return self.scale * best.cost + far * float(away @ away), 2.0 * far * away

    def _solved(self, x: Array) -> _Trial | None:
        best = None if self._best is None else self._best.solution
        self._costs.append(np.inf)
        try:
            task = self.task(x)
            options = {} if best is None else {"refinements": 0, "rescue": False}
            made = self._synthesized(task, best, f"times {len(self._costs)}", **options)
            if not made.success:
                self._failed = made
                return None
            shifts = self._settings.shift * np.ones(len(x))
            slope = cost_gradient(made, self.task, x, shifts)
        except ParameterError:
            if best is None:
                raise
            return None
        cost = made.objective / unit_of_cost(task)
        self._costs[-1] = cost
        return _Trial(x.copy(), cost, slope, made)

    def _synthesized(
        self, task: MotionTask, warm: Solution | None, name: str, **options: Any
    ) -> Solution:
        """Return the solution of a task, reported under a name."""

        def report(stage: str, iterate: Iterate) -> bool:
            if self._progress is not None and self._progress(f"{name}: {stage}", iterate):
                self._stopped = True
            return self._stopped

        body = placed(self._body, task)
        made = synthesize(body, task, warm=warm, progress=report, **options)
        self._stages.extend(made.stages)
        return made

    def result(self) -> FoundTimes:
        """Return the best motion, refined, and its times."""
        best = self._best
        if best is None:
            assert self._failed is not None
            at, costs = self.values(self.start), tuple(self._costs)
            return FoundTimes(self._failed, at, costs, (), self._stopped)
        made = best.solution
        if len(self._costs) > 1 and not self._stopped:
            task = self.task(best.x)
            last = self._synthesized(task, made, "found")
            made = last if last.success else made
        on = np.abs(best.x) >= 1.0 - 2.0 * self._settings.at_bound
        names = tuple(t.name for t, there in zip(self._times, on, strict=True) if there)
        chosen = replace(made, stages=tuple(self._stages))
        return FoundTimes(chosen, self.values(best.x), tuple(self._costs), names, self._stopped)

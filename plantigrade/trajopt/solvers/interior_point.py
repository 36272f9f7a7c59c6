r"""A primal-dual interior-point method whose every matrix is a band.

With slacks :math:`s` for inequalities, the problem of :mod:`~plantigrade.trajopt.problem.nlp` is

.. math:: \min f(x) - \mu \sum \log(s - l) - \mu \sum \log(h - s)
    \quad \text{with} \quad c_E(x) = 0, \; c_I(x) - s = 0.

Every iteration lowers the barrier parameter :math:`\mu` if its problem is solved well enough, takes
a Newton step (:mod:`~plantigrade.trajopt.solvers.kkt`) and searches along it
(:mod:`~plantigrade.trajopt.solvers.line_search`); where no step is accepted, Gauss-Newton steps
towards feasibility alone restore progress. The method is that of [Waechter2006]_.
"""

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.solvers.kkt import KKTSystem, factorised, lagrangian, solved
from plantigrade.trajopt.solvers.line_search import Filter, LineSearch, TrialPoint, recentred
from plantigrade.trajopt.solvers.result import Iterate, Multipliers, Options, SolverResult, Status
from plantigrade.trajopt.solvers.slacks import Slacks
from plantigrade.trajopt.transcription.constraint_block import limits_of_unknowns
from plantigrade.trajopt.transcription.evaluation import Evaluation

FINAL_BARRIER = 0.05
"""Last barrier parameter relative to the tolerance [1]; with known multipliers also the first one:
a solved problem is then solved at once and a similar one in a few iterations."""
WARM_MARGIN = 0.1
"""Room of slacks inside their limits at a warm start, relative to the tolerance [1]."""
HALVING_ITERATIONS = 20
"""Number of iterations within which the violation must halve for the solver to continue [1]."""
FIRST_ORDER_ITERATIONS = 4
"""First iterations from a guess in which second derivatives of rows are left out: without good
multipliers they say little of the problem, and shifts that make up for them shorten the steps. A
periodic motion has no ends to be held at, and is solved sooner with them."""
GUESS_BARRIER = 2e-4
"""First barrier parameter where a guess violates rows by 1 (a body weight) or less, in proportion
where by more: a guess far off, as of a jump, needs room around its limits, and one near by has the
shorter way with less."""
NEAR = 100.0
"""Error of a warm start that is good enough should it not get any nearer, relative to the tolerance
[1]."""
MAX_WARM_ITERATIONS = 3
"""Maximum number of iterations of a warm start after a good point [1]; it ends sooner where the
error rises. Further iterations converge to another motion."""
NEARLY_FEASIBLE = 1e-3
"""Violation of rows below which a motion shows where its mesh is too coarse [1]: below the residual
wrench between nodes that is allowed. Chosen."""
NEARLY_MET = 1e-2  #: Violation of rows below which a point is near by [1]. Chosen.
PATIENCE = 5
"""Number of iterations after which a point near by no longer waits for a smaller barrier [1]."""
FALLING_COST = 0.01
"""Relative fall of the cost within :data:`PATIENCE` iterations from which a point near by waits
longer [1], where the last barrier parameter is small (:data:`SMALL_BARRIER`). Chosen: with 30 kg in
one hand a walk came to it while its cost still fell, and stalled."""
SMALL_BARRIER = 1e-5
"""Barrier parameter that is small: that of tolerances of 1e-4, not of 1e-3. Chosen."""
MAX_STALLED_ITERATIONS = 12  #: Maximum number of iterations without an accepted step [1]
EQUATION_WEIGHT = 1e6  #: Weight of linear equations relative to the distance from a guess [1]


@dataclass
class _State:
    """Where a run stands."""

    x: Array
    mu: float
    best: tuple[float, Array]  # least violation seen, and its variables
    at_mu: int = 0  # iterations with this barrier parameter
    alpha: float = 0.0  # fraction of the last step that was taken
    stalls: int = 0  # iterations in which no step was accepted
    near: "tuple[int, float, Array, Multipliers] | None" = None  # of a warm start, if good enough


@dataclass(frozen=True, eq=False)
class _Errors:
    """How far a point is from being a solution."""

    gaps: list[Array]  # residuals of the constraints, by block
    dual: float  # scaled gradient of the Lagrangian
    complementarity: float  # scaled, without a barrier
    scale: float  # by what both are scaled


class InteriorPoint:
    """The solver of one problem; arrays are made once and used again."""

    def __init__(self, problem: Problem, options: Options | None = None):
        self.options = options or Options()
        limits = limits_of_unknowns(problem)
        families = (*problem.rows, *([limits] if limits is not None else []))
        self._e = Evaluation(problem, families)
        self._slacks = [Slacks(block) for block in self._e.blocks]
        self._guessed = FIRST_ORDER_ITERATIONS if problem.closure is None else 0
        self._kkt = KKTSystem(self._e, self._slacks, self.options.constraint_regularisation)

    def solve(
        self,
        c0: Float[Array, "n_coefficients nv"],
        u0: Float[Array, "n_nodes nu"] | None = None,
        multipliers: Multipliers | None = None,
        progress: Callable[[Iterate], bool | None] | None = None,
        pause: Callable[[Array, Array], bool] | None = None,
    ) -> SolverResult:
        """Solve from a guess.

        Args:
            u0: Initial node unknowns; zero if absent.
            multipliers: From a similar problem.
            progress: Called with every iteration; returning True stops with the best so far.
            pause: Asked once, with coefficients and node unknowns, where every row is nearly
                satisfied; True ends the solve there.

        Returns:
            Where the solver ended; it never raises because it failed.

        Raises:
            ParameterError: If the guess has another shape than the problem, or is not finite.
        """
        o, e, started = self.options, self._e, clock.perf_counter()
        at = self._start(e.t.variables.start(c0, u0), multipliers)
        history: list[Iterate] = []
        status: Status = "too many iterations"
        filter_: Filter | None = None
        for number in range(o.iterations + 1):
            values = [b.r for b in e.blocks]
            objective, worst, errors = e.objective(at.x, values), e.worst(values), self._errors(at)
            error = max(errors.dual, errors.complementarity)
            seconds = clock.perf_counter() - started
            now = Iterate(
                number, objective, worst.amount, worst.place, error, at.mu, self._kkt.shift,
                at.alpha, seconds,
            )  # fmt: skip
            history.append(now)
            feasible = now.violation <= o.feasibility
            if now.violation < at.best[0] or (feasible and errors.dual < 1e9):
                at.best = now.violation, at.x
            if error <= o.tolerance and feasible:
                status = "solved"
                break
            near = error <= NEAR * o.tolerance and self._acceptable(now)
            if multipliers is not None and at.near is None and near:
                at.near = number, error, at.x, self._multipliers()
            wandering = at.near is not None and (
                error > at.near[1] or number >= at.near[0] + MAX_WARM_ITERATIONS
            )
            if wandering or _hopeless(history):
                status = "stalled"
                break
            if _stopped(progress, now) or seconds > o.seconds:
                status, at.x = "stopped", at.best[1]
                break
            if pause is not None and now.violation <= NEARLY_FEASIBLE:
                if pause(*e.t.split(at.x)):
                    status = "paused"
                    break
                pause = None
            filter_ = filter_ or Filter(1e-4 * max(1.0, now.violation))
            if self._lower_barrier(at, errors, history):
                filter_.clear()
            curved = multipliers is not None or number >= self._guessed
            solvable = self._kkt.factorise(at.x, curved=curved)
            if not (solvable and self._move(at, errors, objective, filter_)):
                status = "stalled"
                break
        return self._result(at, status, history)

    def _move(self, at: _State, errors: _Errors, objective: float, filter_: Filter) -> bool:
        """Take a step of the factorised equations; return whether the search goes on."""
        e, kkt = self._e, self._kkt
        step = kkt.step(at.x, errors.gaps, at.mu)
        step = recentred(kkt, self._slacks, step, at.mu)
        search = LineSearch(e, self._slacks, at.x, step, at.mu, objective)
        trial = search.run(filter_, kkt)
        if trial is None:
            at.stalls += 1
            if at.stalls > MAX_STALLED_ITERATIONS:
                return False
            filter_.clear()
            trial = self._forced(at, search)
        at.x, at.alpha = trial.x, trial.alpha
        for s, new, dy, dz in zip(self._slacks, trial.s, step.y, step.z, strict=True):
            s.move(new, trial.alpha * dy, search.alpha_dual * dz, at.mu)
        e.linearise(at.x)
        return True

    def _start(self, x: Array, multipliers: Multipliers | None) -> _State:
        """Return the first point, with slacks and multipliers set."""
        e, warm, tolerance = self._e, multipliers is not None, self.options.tolerance
        mu = min(self.options.initial_barrier, FINAL_BARRIER * tolerance if warm else np.inf)
        self._kkt.forget()
        e.linearise(x)
        x = onto_linear_equations(e, x, self.options.feasibility)
        e.linearise(x)
        if not warm:
            mu = min(mu, GUESS_BARRIER * max(1.0, e.worst([b.r for b in e.blocks]).amount))
        for s in self._slacks:
            given = multipliers.rows.get(s.block.rows.name) if multipliers is not None else None
            s.start(mu, WARM_MARGIN * tolerance if warm else 1e-2, given)
        return _State(x, mu, (np.inf, x))

    def _errors(self, at: _State) -> _Errors:
        """Return the errors of the present point."""
        e, slacks = self._e, self._slacks
        gradient = e.pull_back(lagrangian(slacks)) + e.t.smoothness(at.x)[1]
        scale = _scale(slacks)
        dual = max(float(np.abs(gradient).max()), *(s.stationarity() for s in slacks))
        gaps = [s.gap(s.block.r, s.s) for s in slacks]
        return _Errors(gaps, dual / scale, self._complementarity(0.0) / scale, scale)

    def _complementarity(self, mu: float) -> float:
        return max(s.complementarity(mu) for s in self._slacks)

    def _lower_barrier(self, at: _State, errors: _Errors, history: Sequence[Iterate]) -> bool:
        """Lower the barrier parameter where its problem is solved well enough; say whether."""
        least, lowered = FINAL_BARRIER * self.options.tolerance, False
        near = history[-1].violation < NEARLY_MET
        residual = max(float(np.abs(gap).max()) for gap in errors.gaps)
        at.at_mu += 1
        while at.mu > least:
            error = self._complementarity(at.mu) / errors.scale
            close = max(errors.dual, residual, error) <= 10 * at.mu
            waits = at.at_mu <= PATIENCE or (least < SMALL_BARRIER and _falling(history))
            if not close and (waits or not near):
                break
            at.mu = max(least, min(0.2 * at.mu, at.mu**1.5))
            at.at_mu, lowered = 0, True
        return lowered

    def _forced(self, at: _State, search: LineSearch) -> TrialPoint:
        """Return a point though no step was accepted: part of the step, or a restored point."""
        trial = search.trial(search.alpha_max * min(1.0, 0.1 * at.stalls + 0.1))
        if search.here.residual > 1e-6 and at.stalls % 2 == 0:
            x = restored(self._e, at.x)
            if x is not None:
                r = self._e.values(x)
                s = [s.push_interior(each, 1e-4) for s, each in zip(self._slacks, r, strict=True)]
                return TrialPoint(x, s, r, trial.alpha)
        return trial

    def _result(self, at: _State, status: Status, history: Sequence[Iterate]) -> SolverResult:
        """Return the last point, or the best one where that is much better."""
        last, multipliers = history[-1], self._multipliers()
        if status in ("stalled", "too many iterations"):
            if self._acceptable(last):
                status = "acceptable"
            elif at.near is not None:
                status, (*_, at.x, multipliers) = "acceptable", at.near
            elif last.violation > 10 * at.best[0]:
                at.x = at.best[1]
        c, u = self._e.t.split(at.x)
        return SolverResult(c, u, status, tuple(history), multipliers)

    def _acceptable(self, now: Iterate) -> bool:
        """Return whether a point is good enough where nothing better is found."""
        o = self.options
        return now.violation <= 10 * o.feasibility and now.optimality <= o.acceptable

    def _multipliers(self) -> Multipliers:
        """Return the multipliers of the present point."""
        return Multipliers({s.block.rows.name: s.at_all_nodes() for s in self._slacks})


def _stopped(progress: Callable[[Iterate], bool | None] | None, now: Iterate) -> bool:
    """Return whether the user wants to stop, by the callback or by Ctrl-C within it."""
    try:
        return bool(progress(now)) if progress is not None else False
    except KeyboardInterrupt:
        return True


def _scale(slacks: Sequence[Slacks]) -> float:
    """Return by how much large multipliers excuse a large gradient [Waechter2006]_."""
    total, count = 0.0, 1
    for s in slacks:
        total += float(np.abs(s.y).sum() + s.z.sum())
        count += int(s.block.bound.sum() + s.limited.sum())
    return max(1.0, total / count / 100.0)


def _falling(history: Sequence[Iterate]) -> bool:
    """Return whether the cost has fallen much of late."""
    before, now = history[max(len(history) - 1 - PATIENCE, 0)], history[-1]
    return before.objective - now.objective > FALLING_COST * abs(now.objective)


def _hopeless(history: Sequence[Iterate]) -> bool:
    """Return whether the violation, still large, has not halved for long."""
    if len(history) <= 2 * HALVING_ITERATIONS:
        return False
    recent = min(it.violation for it in history[-HALVING_ITERATIONS:])
    return recent > 1e-3 and recent > 0.5 * min(
        it.violation for it in history[:-HALVING_ITERATIONS]
    )


def restored(e: Evaluation, x: Array) -> Array | None:
    """Return a point with less violation, by damped Gauss-Newton steps; None if none is found."""
    damping, here = 1e-2, x
    first = size = e.squared_violation(e.values(x))
    for _ in range(15):
        e.linearise(here)
        off = [np.sign(b.r - b.lower) * b.violation(b.r) for b in e.blocks]
        violated = [np.where(each != 0.0, 1.0, 0.0) for each in off]
        band = e.t.assemble(e.hessians(here, violated, None))
        gradient = e.pull_back(off)
        for _ in range(8):
            factor = factorised(band, damping)
            if factor is None:
                return None
            trial = here - solved(factor, gradient)
            after = e.squared_violation(e.values(trial))
            if after < size:
                here, size, damping = trial, after, max(damping / 4, 1e-8)
                break
            damping *= 6
        else:
            break
        if size < 1e-4 * first:
            break
    return here if size < 0.5 * first else None


def onto_linear_equations(e: Evaluation, x: Array, feasibility: float) -> Array:
    """Return the point nearest to ``x``, linearised last, that satisfies linear equations.

    Where they are violated by no more than ``feasibility``, that is ``x`` itself.
    """
    weights = [np.where(b.equations & b.linear, EQUATION_WEIGHT, 0.0) for b in e.blocks]
    aims = [np.where(b.equations, b.lower, 0.0) for b in e.blocks]
    missing = [w * (b.r - aim) for b, w, aim in zip(e.blocks, weights, aims, strict=True)]
    if not any(np.abs(m).max(initial=0.0) > EQUATION_WEIGHT * feasibility for m in missing):
        return x
    factor = factorised(e.t.assemble(e.hessians(x, weights, None), smooth=0.0), 1.0)
    return x if factor is None else x - solved(factor, e.pull_back(missing))

"""The paper's solution procedure: constraints activated in stages, with fallback solvers.

The paper first looks for any motion within (17)–(21) with a zero objective, then adds the rest and
the objective, and from there solves again; where one algorithm fails it takes the next. Here

1. ``bounds``: zero objective, (17)–(21), as in the paper;
2. ``contact``: (22), (23), (26) and (27) are added, by least squares with Levenberg's damping from
   where stage 1 ended: conditions of geometry alone, for which that is faster than any solver of
   programs; what it does not satisfy is left to the next stage;
3. ``all``: all constraints and the objective.

Stages 1 and 3 try the interior-point method (IPOPT), then sequential quadratic programming, then
SLEQP, an active-set method with linear programs; every attempt is reported. If none succeeds, the
stage ends at the point with the least violation, and the next one starts there.
"""

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.trajopt.problem.constraint_family import ConstraintFamily
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.solvers.ipopt import IpoptResult, run, solve
from plantigrade.trajopt.solvers.sparse_program import SparseProgram
from plantigrade.trajopt.zhakatayev2023.conditions import EDGE
from plantigrade.trajopt.zhakatayev2023.formulation import PaperProblem

SOLVERS = ("ipopt", "sqpmethod", "sleqp")
BOUNDS = ("boundary", "coordinates", "rates", "forces", "pelvis", "floor")
CONTACT = ("places", "slip", "knee", "arms")
STEPS = 15  # of least squares; the next stage removes what is left
_SETTINGS = {
    "mu_strategy": "monotone",
    "mu_init": 1e-2,
    # few samples: the equations of a step are nearly dense, scaling and ordering only cost time
    "mumps_scaling": 0,
    "mumps_permuting_scaling": 0,
    "mumps_pivot_order": 0,
}


@dataclass(frozen=True)
class StageAttempt:
    """One attempt at one stage."""

    name: str
    solver: str
    status: str  # how it ended, in words
    success: bool  # whether its constraints are satisfied, and where it has an objective, optimal
    iterations: int
    seconds: float  # time, setting up included [s]
    cpu_seconds: float  # processor time of its thread [s]
    objective: float  # objective of the whole problem at its end
    violation: float  # largest violation of the constraints active in it, in units where 1 is large
    worst: str  # which row, when and by how much

    def line(self) -> str:
        """Return it in one line."""
        text = (
            f"{self.name:8s} {self.solver:13s} {self.status}: {self.iterations} iterations, "
            f"{self.seconds:.2f} s ({self.cpu_seconds:.2f} s of processor), "
            f"objective {self.objective:.4g}, violation {self.violation:.1e}"
        )
        return f"{text} ({self.worst})" if self.violation > 1e-5 else text


@dataclass(frozen=True, eq=False)
class StagedResult:
    """Result of all stages."""

    c: Float[Array, "n_coefficients nv"]  # coefficients
    stages: tuple[StageAttempt, ...]  # every attempt, in order
    success: bool  # whether the last stage succeeded
    objective: float
    violation: float  # largest violation over all constraints
    worst: str  # which row, when and by how much
    iterations: int  # iterations of all attempts
    seconds: float  # time of all attempts, setting up included [s]
    cpu_seconds: float  # processor time of the thread [s]
    history: Any  # objective and violation of every iteration of the last attempt


def solve_staged(
    paper: PaperProblem,
    *,
    tolerance: float = 1e-2,
    feasibility: float = 1e-5,
    max_seconds: float = 120.0,
    solvers: Sequence[str] = SOLVERS,
    say: Callable[[str], None] = lambda _: None,
    callback: Callable[[Any], bool | None] | None = None,
) -> StagedResult:
    """Return the solution of a motion of the paper, stage by stage.

    Args:
        tolerance: Largest error of the optimality conditions, scaled.
        feasibility: Largest violation.
        max_seconds: Most time of one attempt [s].
        say: Called with a line after every attempt.
        callback: Called after every iteration of a solver; True stops.
    """
    problem, c = paper.problem, paper.guess
    judge = SparseProgram(problem, c)
    log = _Log(judge, say)

    def attempt(name: str, used: Problem, c: Array) -> IpoptResult:
        best: IpoptResult | None = None
        for solver in solvers:
            log.begin()
            program = SparseProgram(used, c)
            r = _try(solver, program, c, tolerance, feasibility, max_seconds, callback)
            log.add(name, solver, r.c, r.status, r.success, r.iterations, r.violation, r.worst)
            if best is None or r.violation < best.violation or r.success:
                best = r
            if r.success or r.status == "stopped":
                break
        assert best is not None
        return best

    c = attempt("bounds", without_edges(problem).part(BOUNDS, costs=False), c).c
    log.begin()
    rows = (*(name for name in BOUNDS if name != "forces"), *CONTACT)
    program = SparseProgram(problem.part(rows, costs=False), c)
    c, steps, left = least_squares(program, c, iterations=STEPS)
    worst = program.worst(program.pack(c))
    close = left < 1e-6
    status = "solved" if close else "nearest point"
    log.add("contact", "least squares", c, status, close, steps, worst.amount, worst.sentence)
    last = attempt("all", problem, c)
    worst = judge.worst(judge.pack(last.c))
    return StagedResult(
        c=last.c,
        stages=tuple(log.done),
        success=last.success,
        objective=last.objective,
        violation=worst.amount,
        worst=worst.sentence,
        iterations=sum(s.iterations for s in log.done),
        seconds=sum(s.seconds for s in log.done),
        cpu_seconds=sum(s.cpu_seconds for s in log.done),
        history=last.history,
    )


class _Log:
    """The attempts made, with the time each took."""

    def __init__(self, judge: SparseProgram, say: Callable[[str], None]):
        self.done: list[StageAttempt] = []
        self._judge, self._say = judge, say

    def begin(self) -> None:
        """Start the clocks of an attempt."""
        self._began, self._busy = clock.perf_counter(), clock.thread_time()

    def add(self, name: str, solver: str, c: Array, *ended: Any) -> None:
        """Add the attempt that ended at coefficients ``c``, and say it."""
        status, success, iterations, violation, worst = ended
        spent = clock.perf_counter() - self._began, clock.thread_time() - self._busy
        cost = self._judge.objective(self._judge.pack(c))
        self.done.append(
            StageAttempt(name, solver, status, success, iterations, *spent, cost, violation, worst)
        )
        self._say(self.done[-1].line())


def without_edges(problem: Problem) -> Problem:
    """Return the problem without the zero-moment point's condition."""

    def relaxed(rows: ConstraintFamily) -> ConstraintFamily:
        edge = [name.startswith(EDGE) for name in rows.names]
        return replace(rows, upper=np.where(edge, np.inf, rows.upper))

    return replace(problem, rows=tuple(relaxed(rows) for rows in problem.rows))


MAX_VIOLATION = 1e-7  # Violation of the program below which its constraints are met [1]. Chosen.


def least_squares(
    program: SparseProgram, c: Float[Array, "n_coefficients nv"], *, iterations: int = 40
) -> tuple[Float[Array, "n_coefficients nv"], int, float]:
    """Return coefficients that satisfy constraints, steps taken, and the largest violation left.

    Damped least-squares steps lead there from ``c``, until violations are below
    :data:`MAX_VIOLATION`; the program's objective is ignored.
    """
    x = np.clip(program.pack(c), *program.bounds)
    free = program.bounds[0] < program.bounds[1]
    damping, steps = 1e-4, 0
    v = program.excess(program.constraints(x))
    for steps in range(1, iterations + 1):
        if np.abs(v).max(initial=0.0) <= MAX_VIOLATION:
            steps -= 1
            break
        active = np.flatnonzero(v)
        A = program.sparse_jacobian(x)[active][:, free].toarray()
        normal = A @ A.T
        while True:
            step = np.zeros_like(x)
            damped = normal + damping * np.eye(len(active))
            step[free] = -A.T @ np.linalg.solve(damped, v[active])
            after = program.excess(program.constraints(x + step))
            better = np.sum(after**2) < np.sum(v**2)
            if better or damping > 1e3:
                break
            damping *= 10.0
        if not better:
            break
        x, v, damping = x + step, after, max(damping / 10.0, 1e-9)
    c, _ = program.unpack(x)
    return c, steps, float(np.abs(v).max(initial=0.0))


def _try(
    solver: str,
    program: SparseProgram,
    c: Array,
    tolerance: float,
    feasibility: float,
    max_seconds: float,
    callback: Any,
) -> IpoptResult:
    began = clock.perf_counter()

    def watch(progress: Any) -> bool:
        late = clock.perf_counter() - began > max_seconds
        return late or bool(callback is not None and callback(progress))

    if solver == "ipopt":
        return solve(
            program,
            c,
            tolerance=tolerance,
            feasibility=feasibility,
            max_seconds=max_seconds,
            settings=_SETTINGS,
            callback=callback,
        )
    options: dict[str, Any] = {}
    if solver == "sqpmethod":
        options = {
            "qpsol": "osqp",
            "qpsol_options": {
                "osqp": {"verbose": False, "max_iter": 4000, "eps_abs": 1e-7, "eps_rel": 1e-7},
                "error_on_fail": False,
            },
            "max_iter": 60,
            "tol_du": tolerance,
            "tol_pr": feasibility,
            "convexify_strategy": "regularize",
            "print_header": False,
            "print_iteration": False,
            "print_status": False,
        }
    return run(solver, options, program, c, None, feasibility, watch)

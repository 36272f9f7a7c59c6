"""IPOPT on any trajectory problem: the reference solver, robust and slower than the banded one.

[Waechter2006]_, with the linear solver MUMPS, as they come with CasADi. First and second
derivatives are exact and vectorised, the same that the banded interior point uses
(:mod:`~plantigrade.trajopt.solvers.sparse_program`).
"""

import signal
import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.interrupts import on_signal
from plantigrade.trajopt.problem.nlp import Problem
from plantigrade.trajopt.solvers.result import Iterate
from plantigrade.trajopt.solvers.sparse_program import SparseProgram

if TYPE_CHECKING:
    from plantigrade.trajopt.solvers.callbacks import IterationWatch

_WORDS = {
    "Solve_Succeeded": "solved",
    "Solved_To_Acceptable_Level": "acceptable",
    "Infeasible_Problem_Detected": "no point near the last one satisfies the constraints",
    "Search_Direction_Becomes_Too_Small": "stalled",
    "Diverging_Iterates": "variables diverged",
    "User_Requested_Stop": "stopped",
    "Feasible_Point_Found": "solved",
    "Maximum_Iterations_Exceeded": "too many iterations",
    "Restoration_Failed": "no step reduces the violation",
    "Error_In_Step_Computation": "the linear equations of a step could not be solved",
    "Maximum_CpuTime_Exceeded": "out of time",
    "Maximum_WallTime_Exceeded": "out of time",
    "Not_Enough_Degrees_Of_Freedom": "more equations than variables",
    "Invalid_Number_Detected": "a row is not finite",
    "Insufficient_Memory": "out of memory",
}


@dataclass(frozen=True, eq=False)
class IpoptResult:
    """Result of a CasADi solver."""

    c: Float[Array, "n_coefficients n_coordinates"]
    u: Float[Array, "n_nodes n_unknowns"]
    success: bool  # whether optimality was reached, to full or acceptable tolerance
    status: str
    iterations: int
    objective: float  # cost at the result
    violation: float  # largest violation over all rows that count, redundant ones included
    worst: str  # which row that is, when, and by how much
    # every iteration; only objective and violation are known
    history: tuple[Iterate, ...] = field(repr=False)
    seconds: float  # time of the solver [s]
    program: SparseProgram


def solve(
    problem: Problem | SparseProgram,
    c0: Float[Array, "n_coefficients n_coordinates"],
    u0: Float[Array, "n_nodes n_unknowns"] | None = None,
    *,
    tolerance: float = 1e-4,
    feasibility: float = 1e-6,
    max_seconds: float = np.inf,
    callback: Callable[[Iterate], bool | None] | None = None,
    settings: Mapping[str, Any] | None = None,
) -> IpoptResult:
    """Return the solution near a guess, or the best point seen if the solver was stopped.

    It is stopped by a callback that returns True, and by Ctrl-C: then, and where it fails, the
    point returned is the one with the least violation, or the cheapest of those within tolerance.

    Args:
        problem: The problem, or a program made of it before.
        u0: Guess of the node unknowns; zeros if not given.
        tolerance: Largest error of the optimality conditions, scaled.
        feasibility: Largest violation of a row, in its own unit (where 1 is large).
        max_seconds: Most time [s].
        callback: Called after every iteration; True stops.
        settings: Further options of IPOPT by their own names (``{"mu_strategy": "monotone"}``).

    Raises:
        ParameterError: If the guess does not fit the problem.
    """
    options: dict[str, Any] = {
        "print_level": 0,
        "sb": "yes",
        "tol": tolerance,
        "constr_viol_tol": feasibility,
        "acceptable_tol": 1e2 * tolerance,
        "acceptable_constr_viol_tol": feasibility,
        "acceptable_iter": 8,
        "max_iter": 500,
        "mu_strategy": "adaptive",
        "linear_solver": "mumps",
        "mumps_pivot_order": 2,  # approximate minimum fill: a fifth faster than the default
        "fixed_variable_treatment": "make_parameter",
    }
    if np.isfinite(max_seconds):
        options["max_wall_time"] = max_seconds
    options |= dict(settings or {})
    program = problem if isinstance(problem, SparseProgram) else SparseProgram(problem, c0, u0)
    return run("ipopt", {"ipopt": options}, program, c0, u0, feasibility, callback)


def run(
    solver: str,
    options: Mapping[str, Any],
    program: SparseProgram,
    c0: Float[Array, "n_coefficients n_coordinates"],
    u0: Float[Array, "n_nodes n_unknowns"] | None = None,
    feasibility: float = 1e-6,
    callback: Callable[[Iterate], bool | None] | None = None,
) -> IpoptResult:
    """Return what any solver of CasADi makes of a program; see :func:`solve`.

    Args:
        solver: Name of the plugin (``"ipopt"``, ``"sqpmethod"``, ``"sleqp"``).
        options: Its options, as CasADi takes them.
        u0: Guess of the node unknowns; zeros if not given.
        feasibility: Violation below which the cheaper point is the better one.
        callback: Called after every iteration; True stops.
    """
    import casadi as ca

    from plantigrade.trajopt.solvers.callbacks import IterationWatch, functions_of

    x0 = np.clip(program.pack(c0, u0), *program.bounds)
    watch = IterationWatch(program, feasibility, callback)
    made = functions_of(program, symmetric=solver != "ipopt")  # which reads the upper triangle
    settings = {
        "print_time": False,
        "cache": made,
        "no_nlp_grad": True,
        "iteration_callback": watch,
        "error_on_fail": False,
        **options,
    }
    plugin = ca.nlpsol("solver", solver, made["nlp"], settings)
    watch.started = began = clock.perf_counter()
    (lbx, ubx), lbg, ubg = program.bounds, program.lower, program.upper
    with on_signal(signal.SIGINT, lambda *_: setattr(watch, "stop", True)):  # after the iteration
        try:
            found = plugin(x0=x0, lbx=lbx, ubx=ubx, lbg=lbg, ubg=ubg)
            x, stats = np.array(found["x"]).ravel(), plugin.stats()
        except (RuntimeError, KeyboardInterrupt):  # a solver that gives up by raising
            x, stats = x0, {"success": False, "return_status": "failed"}
    seconds = clock.perf_counter() - began
    if not stats.get("success", False) and watch.best is not None:
        x = _better(program, watch, x, feasibility)
    return _result(program, watch, x, stats, seconds)


def _result(
    program: SparseProgram,
    watch: "IterationWatch",
    x: Array,
    stats: Mapping[str, Any],
    seconds: float,
) -> IpoptResult:
    """Return a point with what the solver says of its way there."""
    word = str(stats.get("return_status", ""))
    worst = program.worst(x)
    c, u = program.unpack(x)
    reported = stats.get("iterations") or {}
    history = zip(
        reported.get("obj", watch.objective), reported.get("inf_pr", watch.violation), strict=True
    )
    return IpoptResult(
        c=c,
        u=u,
        success=bool(stats.get("success", False)),
        status=_WORDS.get(word, word.replace("_", " ").lower() or "failed"),
        iterations=int(stats.get("iter_count", len(watch.objective))),
        objective=program.objective(x),
        violation=worst.amount,
        worst=worst.sentence,
        history=tuple(Iterate(i, float(f), float(off)) for i, (f, off) in enumerate(history)),
        seconds=seconds,
        program=program,
    )


def _better(program: SparseProgram, watch: "IterationWatch", x: Array, feasibility: float) -> Array:
    """Return the last point or the best one seen."""
    assert watch.best is not None
    off = float(np.abs(program.excess(program.constraints(x))).max(initial=0.0))
    if not np.isfinite(x).all() or not np.isfinite(off):
        return watch.best[2]
    last = (max(off, feasibility), program.objective(x))
    return x if last <= watch.best[:2] else watch.best[2]

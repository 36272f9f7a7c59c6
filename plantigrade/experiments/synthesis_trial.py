"""One synthesised motion of an experiment: made, timed and judged."""

import time as clock
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from plantigrade.errors import PlantigradeError
from plantigrade.experiments.table import Row

if TYPE_CHECKING:
    from plantigrade.models import Human
    from plantigrade.record import Run
    from plantigrade.synthesize.solution import Solution, Stage
    from plantigrade.synthesize.tasks.task import MotionTask

LAST = 4  # iterations of each stage that are kept of a failure
SLOW, SAMPLED = 40, 8  # iterations from which some are kept in any case; how many


@dataclass(frozen=True, eq=False)
class Timed:
    """A motion, and what it took.

    Attributes:
        solution: What the solver found.
        wall: From the task to the motion, on the clock [s].
        cpu: The same in time of the processor [s].
    """

    solution: "Solution"
    wall: float
    cpu: float


def solve(
    human: "Human",
    task: "MotionTask",
    *,
    solver: str = "interior-point",
    warm: "Solution | None" = None,
    noise: float = 0.0,
    seed: int = 0,
) -> Timed:
    """Make a motion from a task and a person, and time it.

    Equations of the person, mesh and guess are made within the time; a warm start has the person.

    Args:
        human: The person.
        task: What is to be done.
        solver: ``"interior-point"`` or ``"ipopt"``.
        warm: A motion to start from.
        noise: On the first guess, root mean square [rad]; it is made outside the time.
        seed: Of the noise.
    """
    from plantigrade.synthesize.guess.walk import with_noise
    from plantigrade.synthesize.problem.contact_body import ContactBody
    from plantigrade.synthesize.solve import synthesize

    c0 = None
    if noise:
        body = ContactBody.for_plan(human, task.plan)
        problem = task.problem(body)
        start = task.start(body, problem)[0]
        c0 = with_noise(start, seed=seed, size=noise, closure=problem.closure)
    wall, cpu = clock.perf_counter(), clock.process_time()
    body = ContactBody.for_plan(human, task.plan) if warm is None else warm.body
    made = synthesize(body, task, solver=solver, warm=warm, c0=c0)  # type: ignore[arg-type]
    return Timed(made, clock.perf_counter() - wall, clock.process_time() - cpu)


def load(human: "Human", task: "MotionTask") -> dict[str, Any]:
    """Return how long derivatives take to be there: one iteration, less another one."""
    from plantigrade.synthesize.problem.contact_body import ContactBody
    from plantigrade.synthesize.solvers.interior_point import InteriorPoint, Options

    spent = []
    for _ in range(2):
        wall, cpu = clock.perf_counter(), clock.process_time()
        body = ContactBody.for_plan(human, task.plan)
        problem = task.problem(body)
        InteriorPoint(problem, Options(iterations=1)).solve(*task.start(body, problem))
        spent.append((clock.perf_counter() - wall, clock.process_time() - cpu))
    return {"wall": spent[0][0] - spent[1][0], "cpu": spent[0][1] - spent[1][1]}


def judge(timed: Timed, *, strides: int = 1) -> "Run":
    """Return the run, with the verdict of the checker."""
    from plantigrade.workflows.synthesize import run_of

    return run_of(timed.solution, {}, strides=strides)


def outcome(timed: Timed, run: "Run") -> dict[str, Any]:
    """Return what is kept of a motion: success, verdict, time, and the way the solver took."""
    s, findings = timed.solution, run.record.signals["check.findings"]
    last = s.stages[-1].history[-1] if s.stages and s.stages[-1].history else None
    return {
        "success": s.success,
        "ok": run.figures["check_ok"],
        "good": bool(s.success and run.ok),
        "status": s.status,
        "verdict": run.status if run.ok else [str(f) for f in findings[:4]] or [run.status],
        "wall": timed.wall,
        "cpu": timed.cpu,
        "nodes": len(s.problem.nodes),
        "duration": s.task.plan.duration,
        "iterations": s.iterations,
        "objective": last.objective if last else None,
        "violation": last.violation if last else None,
        "worst": last.worst if last else "",
        "stages": [
            {
                "name": stage.name,
                "solver": stage.solver,
                "nodes": stage.nodes,
                "status": stage.status,
                "seconds": stage.seconds,
                "iterations": max(len(stage.history) - 1, 0),
                "end": told(stage),
            }
            for stage in s.stages
        ],
    }


def motion_rows(key: str, result: dict[str, Any]) -> list[Row]:
    """Return what the solver found of one motion, and by which way; why not, where it did not."""
    if "error" in result:
        return [Row(key, "cost", None, note=result["error"])]
    return [
        Row(key, "cost", result["objective"]),
        Row(key, "iterations", result["iterations"]),
        Row(key, "nodes", result["nodes"]),
    ]


def told(stage: "Stage") -> list[str]:
    """Return the last iterations of a stage that failed, some of one that took long, in words."""
    kept = ()
    if stage.status not in ("solved", "acceptable"):
        kept = stage.history[-LAST:]
    elif len(stage.history) > SLOW:
        kept = stage.history[:: len(stage.history) // SAMPLED]
    return [
        f"{i.number}: cost {i.objective:.4g}, violation {i.violation:.1e} ({i.worst}), "
        f"optimality {i.optimality:.1e}, barrier {i.barrier:.0e}, "
        f"regularisation {i.regularisation:.0e}, step {i.step:.2g}"
        for i in kept
    ]


def tried(make: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """Return what is made, or why it could not be."""
    try:
        return make()
    except (PlantigradeError, ArithmeticError, ValueError) as error:
        return {"good": False, "success": False, "ok": False, "error": f"{error}"}


def why(result: dict[str, Any]) -> str:
    """Return in one line why a result is not good."""
    if "error" in result:
        return str(result["error"])
    if not result["success"]:
        stages = [f"{s['name']} ({s['nodes']} nodes) {s['status']}" for s in result["stages"]]
        return f"{', '.join(stages)}; {result['worst']} off by {result['violation']:.1e}"
    verdict = result["verdict"]
    return verdict if isinstance(verdict, str) else "; ".join(verdict)


def crude(task: "MotionTask") -> "MotionTask":
    """Return a walk that starts from a body gliding along a line, instead of a walk."""
    from plantigrade.synthesize.guess.walk import crude_guess

    return replace(task, guess=lambda body, plan, times: crude_guess(body.human, plan, times))

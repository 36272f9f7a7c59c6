"""One synthesised motion of an experiment: solved, timed and checked."""

import time as clock
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from experiments.cached_results import CachedResults, Result
from experiments.table import Row
from plantigrade.models import Human
from plantigrade.record import Run
from plantigrade.trajopt.guess.walk import crude_guess, with_noise
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.solution import Solution, Stage
from plantigrade.trajopt.solve import synthesize
from plantigrade.trajopt.solvers.interior_point import InteriorPoint, Options
from plantigrade.trajopt.tasks.registry import make_task
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.workflows.synthesize import run_of

N_LAST = 4
"""Number of last iterations of a failed stage that are kept."""
MAX_KEPT_ITERATIONS = 40
"""Number of iterations up to which all of them are kept."""
N_SAMPLED = 8
"""Number of iterations that are kept of more."""


@dataclass(frozen=True, eq=False)
class Timed:
    """A motion, and its wall-clock and processor time, both from its task on [s]."""

    solution: Solution
    wall: float
    cpu: float


def solve(
    human: Human,
    task: MotionTask,
    *,
    solver: str = "interior-point",
    warm: Solution | None = None,
    noise: float = 0.0,
    seed: int = 0,
) -> Timed:
    """Solve a motion from a task and a person, and time it.

    The time includes the equations of the person, mesh and guess; a warm start has the equations.
    It does not include noise on the first guess (root mean square [rad]).
    """
    c0 = None
    if noise:
        body = ContactBody.for_plan(human, task.plan)
        problem = task.problem(body)
        start = task.start(body, problem)[0]
        c0 = with_noise(start, seed=seed, size=noise, closure=problem.closure)
    wall, cpu = clock.perf_counter(), clock.process_time()
    body = ContactBody.for_plan(human, task.plan) if warm is None else warm.body
    solution = synthesize(body, task, solver=solver, warm=warm, c0=c0)  # type: ignore[arg-type]
    return Timed(solution, clock.perf_counter() - wall, clock.process_time() - cpu)


def load(human: Human, task: MotionTask) -> dict[str, Any]:
    """Return the loading time of derivatives: that of a first iteration less that of a second."""
    spent = []
    for _ in range(2):
        wall, cpu = clock.perf_counter(), clock.process_time()
        body = ContactBody.for_plan(human, task.plan)
        problem = task.problem(body)
        InteriorPoint(problem, Options(iterations=1)).solve(*task.start(body, problem))
        spent.append((clock.perf_counter() - wall, clock.process_time() - cpu))
    return {"wall": spent[0][0] - spent[1][0], "cpu": spent[0][1] - spent[1][1]}


def check_motion(timed: Timed, *, strides: int = 1) -> Run:
    """Return the run, with the verdict of the checker."""
    return run_of(timed.solution, {}, strides=strides)


def outcome(timed: Timed, run: Run) -> dict[str, Any]:
    """Return the result of a motion: success, verdict, time, and the stages of the solver."""
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
        "worst": s.violations[0].sentence() if s.violations else "",
        "stages": [
            {
                "name": stage.name,
                "solver": stage.solver,
                "nodes": stage.nodes,
                "status": stage.status,
                "seconds": stage.seconds,
                "iterations": max(len(stage.history) - 1, 0),
                "end": iterations_of(stage),
            }
            for stage in s.stages
        ],
    }


def motion_rows(key: str, result: Result) -> list[Row]:
    """Return cost, iterations and nodes of a motion; the error of one that has none."""
    if "error" in result:
        return [Row(key, "cost", None, note=result["error"])]
    named = (("cost", "objective"), ("iterations", "iterations"), ("nodes", "nodes"))
    return [
        *(Row(key, quantity, result[name]) for quantity, name in named),
        Row(key, "tries", len(result["stages"])),
        Row(key, "time", result["cpu"], "s"),
    ]


def iterations_of(stage: Stage) -> list[str]:
    """Return the last iterations of a failed stage, a sample of those of a long one."""
    kept = ()
    if stage.status not in ("solved", "acceptable"):
        kept = stage.history[-N_LAST:]
    elif len(stage.history) > MAX_KEPT_ITERATIONS:
        kept = stage.history[:: len(stage.history) // N_SAMPLED]
    return [
        f"{i.number}: cost {i.objective:.4g}, violation {i.violation:.1e} ({i.worst}), "
        f"optimality {i.optimality:.1e}, barrier {i.barrier:.0e}, "
        f"regularisation {i.regularisation:.0e}, step {i.step:.2g}"
        for i in kept
    ]


def why(result: Result) -> str:
    """Return one line about the failure of a motion."""
    if not result["success"]:
        stages = [f"{s['name']} ({s['nodes']} nodes) {s['status']}" for s in result["stages"]]
        return f"{', '.join(stages)}; {result['worst']}"
    verdict = result["verdict"]
    return verdict if isinstance(verdict, str) else "; ".join(verdict)


def summary(result: Result) -> str:
    """Return one line about a motion."""
    if not result.get("good", True):
        return why(result)
    text = f"{result['cpu']:.1f} s ({result['wall']:.1f} s on the clock)"
    if "iterations" in result:
        text += f", {result['status']} in {result['iterations']} iterations"
    if gait := result.get("gait"):
        text += f", {gait['rmse']:.1f} deg raw, {gait['rmse_offset_removed']:.1f} offset-removed"
    return text


def failure_remarks(cached: CachedResults) -> Iterator[str]:
    """Return why motions failed, and the last iterations of their solver."""
    for key, result in cached.select().items():
        if not result.get("good", True):
            yield f"{key}: {why(result)}"
            for stage in result["stages"]:
                if stage["end"]:
                    yield f"    {stage['name']}, {stage['nodes']} nodes: {stage['status']}"
                    yield from (f"        {line}" for line in stage["end"])


def task_of(
    name: str, human: Human, options: Mapping[str, Any], nodes_per_second: float | None = None
) -> MotionTask:
    """Return a task by name, with a number of nodes per second if one is given."""
    task = make_task(name, human, options)
    return task if nodes_per_second is None else replace(task, nodes_per_second=nodes_per_second)


def crude(task: MotionTask) -> MotionTask:
    """Return a walk that starts from a body gliding along a line, instead of a walk."""
    return replace(task, guess=lambda body, plan, times: crude_guess(body.human, plan, times))

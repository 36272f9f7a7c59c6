"""One synthesised motion of an experiment: made, timed and judged."""

import time as clock
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from experiments.kept_results import Result
from experiments.table import Row
from plantigrade.errors import ParameterError, PlantigradeError
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

LAST = 4  # iterations of each stage that are kept of a failure
SLOW, SAMPLED = 40, 8  # iterations from which some are kept in any case; how many


@dataclass(frozen=True, eq=False)
class Timed:
    """A motion, and what it took from its task on: on the clock, and of the processor [s]."""

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
    """Make a motion from a task and a person, and time it.

    Equations of the person, mesh and guess are made within the time; a warm start has the person.
    Noise on the first guess (root mean square [rad]) is made outside the time.
    """
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


def load(human: Human, task: MotionTask) -> dict[str, Any]:
    """Return how long derivatives take to be there: one iteration, less another one."""
    spent = []
    for _ in range(2):
        wall, cpu = clock.perf_counter(), clock.process_time()
        body = ContactBody.for_plan(human, task.plan)
        problem = task.problem(body)
        InteriorPoint(problem, Options(iterations=1)).solve(*task.start(body, problem))
        spent.append((clock.perf_counter() - wall, clock.process_time() - cpu))
    return {"wall": spent[0][0] - spent[1][0], "cpu": spent[0][1] - spent[1][1]}


def judge(timed: Timed, *, strides: int = 1) -> Run:
    """Return the run, with the verdict of the checker."""
    return run_of(timed.solution, {}, strides=strides)


def outcome(timed: Timed, run: Run) -> dict[str, Any]:
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
        "worst": s.violations[0].sentence() if s.violations else "",
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


def motion_rows(key: str, result: Result) -> list[Row]:
    """Return what the solver found of one motion, and by which way; why not, where it did not."""
    if "error" in result:
        return [Row(key, "cost", None, note=result["error"])]
    return [
        Row(key, {"objective": "cost"}.get(name, name), result[name])
        for name in ("objective", "iterations", "nodes")
    ]


def told(stage: Stage) -> list[str]:
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


def why(result: Result) -> str:
    """Return in one line why a result is not good."""
    if "error" in result:
        return str(result["error"])
    if not result["success"]:
        stages = [f"{s['name']} ({s['nodes']} nodes) {s['status']}" for s in result["stages"]]
        return f"{', '.join(stages)}; {result['worst']}"
    verdict = result["verdict"]
    return verdict if isinstance(verdict, str) else "; ".join(verdict)


def brief(result: Result) -> str:
    """Return in one line how a motion went."""
    if not result.get("good", True):
        return why(result)
    words = f"{result['cpu']:.1f} s ({result['wall']:.1f} s on the clock)"
    if "iterations" in result:
        words += f", {result['status']} in {result['iterations']} iterations"
    if gait := result.get("gait"):
        words += f", {gait['rmse']:.1f} deg raw, {gait['rmse_offset_removed']:.1f} offset-removed"
    return words


def failures(results: Mapping[str, Result]) -> dict[str, str]:
    """Return why motions are not good, by key."""
    return {key: why(r) for key, r in results.items() if not r.get("good", True)}


def chosen_parts(
    parts: Sequence[str], known: Collection[str], otherwise: Collection[str]
) -> Collection[str]:
    """Return the parts that are asked for; ``otherwise`` where none are.

    Raises:
        ParameterError: If there is no such part.
    """
    for part in parts:
        if part not in known:
            raise ParameterError(f"no part {part!r}; there are {', '.join(known)}")
    return parts or otherwise


def task_of(
    name: str, human: Human, told: Mapping[str, Any], nodes_per_second: float | None = None
) -> MotionTask:
    """Return a task by name, with a number of nodes a second if one is given."""
    task = make_task(name, human, told)
    return task if nodes_per_second is None else replace(task, nodes_per_second=nodes_per_second)


def crude(task: MotionTask) -> MotionTask:
    """Return a walk that starts from a body gliding along a line, instead of a walk."""
    return replace(task, guess=lambda body, plan, times: crude_guess(body.human, plan, times))

"""From a task to a Run: solve, record, check."""

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from plantigrade.analyze.at_limit import limit_figures, limit_notes
from plantigrade.analyze.check import check
from plantigrade.analyze.human_limits import motion_notes
from plantigrade.analyze.movement import movement_figures
from plantigrade.analyze.verdict import Verdict
from plantigrade.contact.plan import ContactPlan
from plantigrade.errors import ParameterError
from plantigrade.record import Provenance, Record, Run
from plantigrade.record.provenance import source_files
from plantigrade.trajopt.diagnose.violations import Violation, pressing
from plantigrade.trajopt.free_times import find_times
from plantigrade.trajopt.guess.walk import with_noise
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.solution import Solution
from plantigrade.trajopt.solve import Progress, synthesize
from plantigrade.trajopt.tasks.settings import TASKS
from plantigrade.trajopt.tasks.task import MotionTask
from plantigrade.trajopt.tasks.task_file import TaskFile
from plantigrade.trajopt.tasks.task_settings import TaskSettings
from plantigrade.trajopt.warm_start import WarmStart
from plantigrade.workflows.device import compared, without_devices
from plantigrade.workflows.free_times import (
    free_time_figures,
    free_time_notes,
    free_time_words,
    free_times,
    refuse_beside_free_times,
)
from plantigrade.workflows.settings import PaperSettings, SolveSettings
from plantigrade.workflows.task import person, the_task

NOISE = 0.05  # of the guesses of restarts, root mean square [rad]
MAX_STATUS_SENTENCES = 3  # violations of the status; the report has all of them
NOT_DONE = 1e-3  # a row further off than this, in its own unit, is not what was asked for
UNITS = {name: unit for kind in TASKS.values() for name, (_, _, unit) in kind.ranges.items()}
"""Name of each task parameter → its unit."""


@dataclass(frozen=True)
class Origin:
    """Origin of a run: title of its pages, command line, files read, and its name."""

    title: str = ""
    command: str = ""
    files: tuple[Path, ...] = ()
    name: str = ""


def synthesize_task(
    parameters: TaskSettings,
    how: SolveSettings | None = None,
    *,
    file: TaskFile | None = None,
    warm: WarmStart | Solution | None = None,
    progress: Progress | None = None,
    origin: Origin | None = None,
) -> Run:
    """Generate a motion and check it.

    Args:
        parameters: The task and its parameters.
        how: Person and options of the solver.
        file: A task file; ``parameters`` replaces its parameters.
        warm: A similar motion to start from, in place of the run folder of ``how``.
        progress: Called with every iteration; returning True stops with the best so far.

    Raises:
        ParameterError: If a value is out of range for this person, or the run to start from has
            other joints.
        FileError: If the run to start from cannot be read.
    """
    how, origin, began = how or SolveSettings(), origin or Origin(), clock.perf_counter()
    if how.free_time or getattr(parameters, "optimise_timing", False) or (file and file.free_times):
        refuse_beside_free_times(how)
    if warm is None and how.warm is not None:
        warm = WarmStart.of_record(Run.load(how.warm).record)
    human = person(how)
    task = the_task(human, parameters, how, file)
    if how.replay:
        _require_replayable(task.plan)
    times, task_at = free_times(human, parameters, how, file)
    strides, without = getattr(parameters, "strides", 1), None
    if task.devices:
        known = str(human.to_dict()), str(parameters), str(replace(how, device=())), str(file)
        without = without_devices(human, task, strides, known)
        warm = warm or without.bare
    body = task.body_of(human) if without is None else without.worn.wearing(task.devices)
    found = find_times(body, task_at, times, progress=progress) if times else None
    if found is not None:
        solution, figures = found.solution, free_time_figures(found)
    else:
        solution, trials = _best(body, task, how, warm, progress)
        figures = {"restarts": trials}
    prepared = clock.perf_counter() - began - solution.seconds
    name = next(n for n, kind in TASKS.items() if kind is type(parameters))
    text = "" if file is None else file.toml()
    settings = {"task": name, "parameters": asdict(parameters), "file": text, **how.plain()}
    free = {t.name for t in times} | (file.free_parameters if file else set())
    given = {name: x for name, x in parameters.changed.items() if name not in free}
    changed = [in_words(name, value) for name, value in given.items()]
    changed += [] if found is None else free_time_words(found)
    words = ", ".join(filter(None, [*changed, *how.words]))
    run = run_of(solution, settings, origin, strides=strides, words=words, figures=figures)
    run = replace(run, seconds={**run.seconds, "prepare": prepared})
    if found is not None:
        record = replace(run.record, notes=(*run.record.notes, *free_time_notes(found)))
        run = replace(run, record=record)
    if without is not None:
        run = compared(run, without.record)
    return proven(run) if how.replay else run


def _require_replayable(plan: ContactPlan) -> None:
    """Raise for a plan with ground or supports that move, or that rests on more than the feet."""
    if plan.moves:
        raise ParameterError("replay has no ground or supports that move: leave out one of both")
    if others := {s.site.name: None for s in plan.supports if plan.on_ground(s)}:
        raise ParameterError(
            f"this motion rests on {', '.join(others)} on the floor, and replay knows only of "
            "feet, seats and supports: leave out one of both"
        )


def proven(run: Run) -> Run:
    """Return a run with the result of simulating its motion: figures and a note."""
    from plantigrade.control.replay.trials import certificate, certified  # the controllers

    began = clock.perf_counter()
    figures = certificate(run.record)
    record = replace(run.record, notes=(*run.record.notes, certified(figures)))
    seconds = {**run.seconds, "replay": clock.perf_counter() - began}
    return replace(run, record=record, figures={**run.figures, **figures}, seconds=seconds)


def _best(
    body: ContactBody,
    task: MotionTask,
    how: SolveSettings,
    warm: WarmStart | Solution | None,
    progress: Progress | None,
) -> tuple[Solution, int]:
    """Return the cheapest motion of all restarts, and how many there were."""
    found: list[Solution] = []
    halted = False

    def parameters(stage: str, iterate: Any) -> bool | None:
        nonlocal halted
        if progress is None:
            return None
        name = stage if how.restarts == 1 else f"start {len(found) + 1}: {stage}"
        halted = bool(progress(name, iterate)) or halted
        return halted

    for k in range(how.restarts):
        c0 = None
        if k:
            problem, warm = task.problem(body), None  # a warm start's mesh may be another
            start = task.start(body, problem)[0]
            c0 = with_noise(start, seed=how.seed + k, size=NOISE, closure=problem.closure)
        found.append(
            synthesize(body, task, solver=how.solver, warm=warm, progress=parameters, c0=c0)
        )
        if halted:
            break
    return min(found, key=_rank), len(found)


def _rank(made: Solution) -> tuple[float, float]:
    """Return a key that sorts better motions first: success, then cost or violation."""
    if made.success:
        return 0.0, made.objective
    return 1.0, made.stages[-1].history[-1].violation


def synthesize_paper(
    how: PaperSettings, *, progress: Progress | None = None, origin: Origin | None = None
) -> Run:
    """Solve a motion of the paper and check it.

    Raises:
        ParameterError: If the person has other feet than the paper's.
    """
    from plantigrade.trajopt.zhakatayev2023 import paper_motion

    origin = origin or Origin()

    def parameters(p: Any) -> bool | None:
        return None if progress is None else progress("as in the paper", p)

    solution = paper_motion(person(how), how.motion, how.basis, callback=parameters)
    result, record = solution.result, solution.record()
    figures = {
        "task": f"zhakatayev2023 {how.motion}",
        "solver_status": result.stages[-1].status,
        "solver_success": result.success,
        "solver_stages": len(result.stages),
        "iterations": result.iterations,
        "objective": result.objective,
        "violation_max": result.violation,
        "nodes": len(solution.paper.problem.nodes),
    }
    settings = {"task": "zhakatayev2023", **how.plain()}
    what, made = f"{how.motion}, as in the paper", "solved by the stages of the paper"
    seconds = {"solve": result.seconds}
    return checked(record, what, made, settings, origin, figures, seconds=seconds)


def run_of(
    solution: Solution,
    settings: Mapping[str, Any],
    origin: Origin | None = None,
    *,
    strides: int = 2,
    words: str = "",
    figures: Mapping[str, Any] | None = None,
) -> Run:
    """Return the run of a solved task: recorded, checked, with every figure."""
    record, name = solution.record(strides=strides), solution.task.name
    made = "generated from the task alone"
    what = f"{name} ({words})" if words else name
    every = solver_figures(solution) | dict(figures or {})
    origin, seconds, broken = origin or Origin(), {"solve": solution.seconds}, solution.violations
    return checked(record, what, made, settings, origin, every, broken, seconds=seconds)


def checked(
    record: Record,
    what: str,
    made: str,
    settings: Mapping[str, Any],
    origin: Origin,
    figures: Mapping[str, Any],
    violations: Sequence[Violation] = (),
    *,
    kind: str = "synthesize",
    seconds: Mapping[str, float] | None = None,
) -> Run:
    """Return a record as a run, with the verdict of the checker.

    ``what`` was done, and how it was ``made``, are words for the sentence of the run; ``seconds``
    are computing times.
    """
    verdict, human = check(record), record.human
    record = replace(
        record,
        signals={**record.signals, **verdict.signals()},
        notes=(*record.notes, *motion_notes(record), *limit_notes(record)),
    )
    state = status(verdict, violations)
    passed = "the check passed" if state == "ok" else "the check failed"
    sentence = (
        f"{what[0].upper()}{what[1:]}, {record.motion.duration:.2f} s, of a person of "
        f"{human.height:.2f} m and {human.mass:.1f} kg with {human.model.nv} degrees of freedom "
        f"and {human.feet} feet, {made}; {passed} in {record.motion.n_frames} frames."
    )
    size = {"duration_s": record.motion.duration, "frames": record.motion.n_frames}
    age = settings.get("age") or figures.get("age_years")
    person = {} if age is None else {"age_years": age}
    every = {**size, **figures, **verdict.figures(), **person, **movement_figures(record, person)}
    every |= limit_figures(record)
    settings = {**settings, "friction": record.ground.friction}
    files = source_files(origin.files)
    return Run(
        record,
        kind,
        origin.title or what,
        sentence,
        state,
        every,
        Provenance(origin.command, settings, files, settings.get("seed")),
        seconds=dict(seconds or {}),
        name=origin.name,
    )


def status(verdict: Verdict, violations: Sequence[Violation]) -> str:
    """Return ``"ok"``, or what is wrong, where and when.

    The checker decides whether the motion is physical and does what the task demands. One that
    passes may still violate constraints of the problem: those further off than :data:`NOT_DONE`.
    If it fails, the largest violation names the obstacle.
    """
    words = [v.sentence() for v in violations if v.relative > NOT_DONE][:MAX_STATUS_SENTENCES]
    if not verdict.ok:
        blocked = [f"no motion found that does all of it: {w}" for w in words[:1]]
        return "; ".join([*blocked, verdict.status])
    return "; ".join(f"not what was asked for: {w}" for w in words) or "ok"


def solver_figures(solution: Solution) -> dict[str, Any]:
    """Return figures of the solver's convergence."""
    problem, last = solution.problem, solution.stages[-1].history[-1]
    found: dict[str, Any] = {
        "task": solution.task.name,
        "solver_status": solution.status,
        "solver_success": solution.success,
        "solver_stages": len(solution.stages),
        "iterations": solution.iterations,
        "objective": solution.objective,
        "violation_max": last.violation,
        "optimality": last.optimality,
        "nodes": len(problem.nodes),
        "unknowns": int(solution.coefficients.size + problem.u_active.sum()),
        "equations": int(sum(r.equations.sum() for r in problem.rows)),
        "inequalities": int(sum(r.inequalities.sum() for r in problem.rows)),
    }
    if solution.success:
        found["binding_limits"] = list(pressing(problem, solution.multipliers))
    if solution.violations:
        found["violations"] = [v.sentence() for v in solution.violations]
    return found


def in_words(name: str, value: Any) -> str:
    """Return the parameters of a task in words.

    Example:
        >>> in_words("step_length", 0.6), in_words("turn", np.pi / 2), in_words("periodic", True)
        ('step length 0.6 m', 'turn 90°', 'periodic')
    """
    words = name.replace("_", " ")
    if value is None or value is False:
        return ""
    if value is True:
        return words
    if isinstance(value, int | float):
        unit = UNITS.get(name, "")
        if unit == "degrees":
            return f"{words} {np.rad2deg(value):.4g}°"
        return f"{words} {value:g} {unit}".rstrip()
    return f"{words} {value}"

"""From a task and a person to a motion: mesh, solver, and what is done where one fails."""

import time as clock
from collections.abc import Callable
from dataclasses import replace
from typing import Literal

import numpy as np

from plantigrade.arrays import Array, Float
from plantigrade.synthesize.formulation import Body
from plantigrade.synthesize.interior_point import InteriorPoint, Iterate, Multipliers, Options
from plantigrade.synthesize.problem import Problem
from plantigrade.synthesize.synthesis import Stage, Synthesis
from plantigrade.synthesize.task import Task, coefficients, sample_times

Solver = Literal["band", "ipopt"]
Progress = Callable[[str, Iterate], bool | None]


def synthesize(
    body: Body,
    task: Task,
    *,
    solver: Solver = "band",
    warm: Synthesis | None = None,
    options: Options | None = None,
    progress: Progress | None = None,
    c0: Float[Array, "n_coefficients nv"] | None = None,
) -> Synthesis:
    """Return the motion of a person who does a task.

    Args:
        body: The person with the places that can carry force.
        task: What is to be done.
        solver: ``"band"``, or ``"ipopt"`` as the reference.
        warm: A motion of a task much like this one, to start from.
        options: Of the banded solver.
        progress: Told every iteration; returning True stops with the best so far.
        c0: Coefficients to start from instead of the task's guess.

    Returns:
        The motion, also where no solver succeeded: ``success`` and ``stages`` say.
    """
    stages: list[Stage] = []
    problem = task.problem(body)
    c, u = task.start(body, problem)
    multipliers: Multipliers | None = None
    if c0 is not None:
        c = c0
    if warm is not None:
        c, u, multipliers = _from(warm, problem)

    def run(name: str, p: Problem, c, u, multipliers=None):
        started = clock.perf_counter()
        told = (lambda it: progress(name, it)) if progress is not None else None
        result = InteriorPoint(p, options).solve(c, u, multipliers, told)
        stages.append(
            Stage(
                name,
                "band",
                len(p.nodes),
                result.status,
                clock.perf_counter() - started,
                result.history,
            )
        )
        return result

    result = run("warm start" if warm is not None else "first try", problem, c, u, multipliers)
    if not result.success and result.status != "stopped":
        coarse = replace(task, density=task.density / 2)
        p2 = coarse.problem(body)
        c2, u2 = coarse.start(body, p2)
        middle = run("coarse mesh", p2, c2, u2)
        if middle.success:
            times = sample_times(problem)
            c = coefficients(problem, times, p2.states(middle.c, times)[0])
            u = _forces(p2, middle.u, problem)
            result = run("refined", problem, c, u)
    return Synthesis(
        body,
        task,
        problem,
        result.c,
        result.u,
        result.status,
        result.success,
        tuple(stages),
        result.multipliers,
    )


def _from(warm: Synthesis, problem: Problem) -> tuple[Array, Array, Multipliers | None]:
    """Return a start from another motion, stretched to this one's duration."""
    old = warm.problem
    times = sample_times(problem)
    scale = old.basis.span / problem.basis.span
    c = coefficients(
        problem, times, old.states(warm.c, np.clip(times * scale, 0, old.basis.stop))[0]
    )
    same = len(old.nodes) == len(problem.nodes) and [r.name for r in old.rows] == [
        r.name for r in problem.rows
    ]
    return (c, warm.u, warm.multipliers) if same else (c, _forces(old, warm.u, problem), None)


def _forces(old: Problem, u: Array, new: Problem) -> Array:
    """Return node unknowns of another mesh, by linear interpolation over relative time."""
    before, after = old.nodes / old.basis.span, new.nodes / new.basis.span
    out = np.stack([np.interp(after, before, x) for x in u.T], axis=1)
    return np.clip(out, new.u_lower, new.u_upper)

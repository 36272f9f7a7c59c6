"""Times of contact as unknowns: the walk whose steps, stances and heel rises cost least.

Inside one problem the times of contact are fixed, because nodes and knots lie on them. Here an
outer search [Powell1994]_ varies them within bounds around what people prefer, each trial
warm-started from the best; some twenty motions suffice. It compares the cost per metre.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from plantigrade.arrays import Array
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.solution import Solution, Stage
from plantigrade.trajopt.solve import Progress, synthesize
from plantigrade.trajopt.tasks.gait_parameters import FOOT_FLAT_SHARE, GaitParameters, ball_off
from plantigrade.trajopt.tasks.task import MotionTask

BOUNDS = {"step_length": 0.15, "stance": 0.03, "heel_off": 0.06}
"""Maximum changes: share of the step length; shares of the stride [1]."""


@dataclass(frozen=True)
class OptimisedTiming:
    """A walk on times of its own."""

    solution: Solution  #: The motion that costs least; its stages are those of every trial
    parameters: GaitParameters  #: Its lengths and times
    costs: tuple[float, ...]  #: Cost of a metre of every trial, in order; inf where none was found


def optimise_timing(
    body: ContactBody,
    task_of: Callable[[GaitParameters], MotionTask],
    start: GaitParameters,
    *,
    trials: int = 25,
    progress: Progress | None = None,
) -> OptimisedTiming:
    """Return the walk whose step length, stance and heel rise cost least at one speed.

    Args:
        task_of: Makes the task of lengths and times.
        start: Centre of the bounds, and the result if nothing is better.
        trials: Motions to try at most.
        progress: Called with every iteration; returning True stops with the best so far.
    """
    from scipy.optimize import minimize

    best: list[tuple[float, Solution, GaitParameters]] = []
    costs: list[float] = []
    stages: list[Stage] = []
    halted = False

    def on_iteration(stage, iterate) -> bool:
        nonlocal halted
        halted = halted or bool(progress is not None and progress(stage, iterate))
        return halted

    def cost(x: Array) -> float:
        if halted:
            return np.inf
        p = _varied(start, np.clip(x, -1.0, 1.0))
        warm, task = best[0][1] if best else None, task_of(p)
        made = synthesize(
            body, task, warm=warm, progress=on_iteration, refinements=0, rescue=not best
        )
        value = made.objective / (p.speed * task.plan.duration) if made.success else np.inf
        costs.append(value)
        stages.extend(made.stages)
        if made.success and (not best or value < best[0][0]) or not best:
            best[:] = [(value, made, p)]
        worst = max((c for c in costs if np.isfinite(c)), default=1.0)
        return value if np.isfinite(value) else 2.0 * worst

    minimize(
        cost,
        np.zeros(len(BOUNDS)),
        method="COBYLA",
        bounds=[(-1.0, 1.0)] * len(BOUNDS),
        options={"maxiter": trials, "rhobeg": 0.4, "tol": 0.02},
    )
    _, made, p = best[0]
    last = synthesize(body, task_of(p), warm=made, progress=progress)
    chosen = replace(last if last.success else made, stages=(*stages, *last.stages))
    return OptimisedTiming(chosen, p, tuple(costs))


def _varied(p: GaitParameters, x: Array) -> GaitParameters:
    """Return lengths and times moved by parts of the bounds."""
    step = p.step_length * (1.0 + BOUNDS["step_length"] * x[0])
    stance = p.stance_fraction + BOUNDS["stance"] * x[1]
    flat = FOOT_FLAT_SHARE * (stance - 0.5)
    return replace(
        p,
        step_length=step,
        step_time=step / p.speed,
        stance_fraction=stance,
        foot_flat=flat,
        heel_off=p.heel_off + BOUNDS["heel_off"] * x[2],
        forefoot_off=ball_off(stance, flat),
    )

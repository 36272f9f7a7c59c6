"""One iteration of the banded interior point: evaluation, assembly, factorisation, the rest.

A walk from standing to standing of a person with 43 coordinates, contact forces at every site of
both feet, on meshes from coarse to fine. All that grows with the nodes grows in proportion, because
every matrix is a band of the same width.
"""

import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from unittest import mock

import numpy as np

from experiments.table import Row, at_most
from plantigrade.models import Human
from plantigrade.trajopt import (
    ContactBody,
    InteriorPoint,
    MotionTask,
    Options,
    Problem,
    make_task,
)
from plantigrade.trajopt.solvers import kkt
from plantigrade.trajopt.transcription.constraint_block import ConstraintBlock
from plantigrade.trajopt.transcription.derivatives import NodeDerivatives
from plantigrade.trajopt.transcription.linear_map import Transcription

NODES = (61, 121, 301)
ITERATIONS = 5  # that are timed, after as many that are not
N_REPEATS = 3  # of which the fastest counts
MAX_ITERATION_TIME = {
    61: 0.16,
    121: 0.24,
    301: 0.48,
}  # 25 of them: a walk in 4 s; on 301 nodes in 12 s: s
PARTS = ("evaluation", "assembly", "factorisation")


def rows() -> Iterator[Row]:
    """Yield seconds per iteration on every mesh, and what they are spent on."""
    human = Human.create(joints="43", feet="two-segment")
    task = make_task("walk", human, {"steps": 3, "speed": 1.3})
    body = ContactBody.for_plan(human, task.plan)
    for n in NODES:
        yield from rows_of(body, task, n)


def rows_of(body: ContactBody, task: MotionTask, n: int) -> Iterator[Row]:
    """Yield the figures of one mesh with about n nodes."""
    problem = meshed(body, task, n)
    start = task.start(body, problem)
    order = Transcription(problem)
    subject = f"walk, 43 coordinates, {len(problem.nodes)} nodes"
    note = f"{order.size} unknowns, half band {order.half_band}"
    best: dict[str, float] = {}
    for _ in range(N_REPEATS):
        each = timed(problem, *start)
        if not best or each["iteration"] < best["iteration"]:
            best = each
    yield replace(
        at_most(subject, "iteration", best["iteration"], MAX_ITERATION_TIME[n], "s"), note=note
    )
    for part in PARTS:
        yield Row(subject, f"of it {part}", 1e3 * best[part], "ms")
    rest = best["iteration"] - sum(best[part] for part in PARTS)
    yield Row(subject, "of it the rest", 1e3 * rest, "ms", note="line search, steps, sums")
    yield Row(subject, "matrices made ready", best["ready"], "s", note="once for every mesh")


def meshed(body: ContactBody, task: MotionTask, n: int) -> Problem:
    """Return the problem on the mesh whose number of nodes is nearest to n."""
    nodes_per_second = n / task.plan.duration
    for _ in range(20):
        problem = replace(task, nodes_per_second=nodes_per_second).problem(body)
        if abs(len(problem.nodes) - n) <= 1:
            break
        nodes_per_second *= 1 + 0.7 * (n / len(problem.nodes) - 1)
    return problem


def timed(problem: Problem, c: np.ndarray, u: np.ndarray) -> dict[str, float]:
    """Return seconds an iteration, those of its parts, and of what is done once."""
    spent: dict[str, float] = defaultdict(float)
    within = [0.0]  # what parts inside of the present one have taken

    def clocked(part: str, call: Callable) -> Callable:
        def inner(*arguments, **named):
            within.append(0.0)
            begin = time.perf_counter()
            answer = call(*arguments, **named)
            took = time.perf_counter() - begin
            spent[part] += took - within.pop()
            within[-1] += took
            return answer

        return inner

    begin = time.perf_counter()
    engine = InteriorPoint(problem, Options(tolerance=1e-9))  # far off
    spent["ready"] = time.perf_counter() - begin
    ends: list[float] = []

    def progress(iterate) -> bool:
        if iterate.number == ITERATIONS:
            spent.update(dict.fromkeys(PARTS, 0.0))
        ends.append(time.perf_counter())
        return iterate.number == 2 * ITERATIONS

    with ExitStack() as patched:
        for name in ("values", "jacobian", "hessian"):
            call = clocked("evaluation", getattr(NodeDerivatives, name))
            patched.enter_context(mock.patch.object(NodeDerivatives, name, call))
        for name in ("assemble", "gradient", "local", "local_step"):
            call = clocked("assembly", getattr(Transcription, name))
            patched.enter_context(mock.patch.object(Transcription, name, call))
        call = clocked("assembly", ConstraintBlock.add_squares)
        patched.enter_context(mock.patch.object(ConstraintBlock, "add_squares", call))
        call = clocked("factorisation", kkt.cholesky_banded)
        patched.enter_context(mock.patch.object(kkt, "cholesky_banded", call))
        engine.solve(c, u, progress=progress)
    spent["iteration"] = ends[2 * ITERATIONS] - ends[ITERATIONS]
    return {part: t if part == "ready" else t / ITERATIONS for part, t in spent.items()}

"""Derivatives of a body's dynamics at all nodes of a motion: vectors compared with the interpreter.

What an iteration of a trajectory optimisation evaluates: the rows of the dynamics of a body with
contact forces at both feet, their Jacobian, and the Hessian of their product with multipliers.
"""

import os
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace

import numpy as np

from experiments.table import Row, at_least, at_most
from plantigrade.batched import BatchedFunction
from plantigrade.contact.site import foot_sites
from plantigrade.models import Human
from plantigrade.trajopt.problem.contact_body import ContactBody
from plantigrade.trajopt.problem.dynamics import dynamics
from plantigrade.trajopt.transcription.derivatives import NodeDerivatives

NODES = 61
REPEATS = 15  # evaluations of which the fastest counts
MAX_COMPILE_TIME = 8.0  # [s] goal
MAX_LOAD_TIME = 0.5  # [s] goal
MIN_SPEEDUP = 10.0  # [1] goal
DERIVATIVES = ("values", "jacobian", "hessian")


def rows() -> Iterator[Row]:
    """Yield seconds to make and to find them, and microseconds a node both ways."""
    subject = f"dynamics, 43 coordinates, {NODES} nodes"
    if BatchedFunction.unavailable():
        yield Row(subject, "vectors", None, note=BatchedFunction.unavailable())
        return
    with empty_cache():
        person = function(Human.create(1.74, 70.0, joints="43", feet="two-segment"))
        seconds, ours = made(person, "vectors")
        yield at_most(subject, "made, once for all people", seconds, MAX_COMPILE_TIME, "s")
        del ours  # so that the next one comes from disk
        seconds, ours = made(
            function(Human.create(1.61, 55.0, joints="43", feet="two-segment")), None
        )
        yield at_most(subject, "found for another person", seconds, MAX_LOAD_TIME, "s")
        seconds, theirs = made(ours.function, "interpreter")
        yield Row(subject, "made for the interpreter", seconds, "s")
        yield from side_by_side(subject, ours, theirs)


def function(human: Human):
    """Return the rows of a person's dynamics with forces at both feet."""
    return dynamics(ContactBody(human, foot_sites(human)), NODES).function


def made(function, backend: str | None) -> tuple[float, NodeDerivatives]:
    """Return derivatives, all of them ready to be evaluated, and how long that took [s]."""
    start = time.perf_counter()
    derivatives = NodeDerivatives(function, backend=backend)
    evaluate(derivatives, 1)
    return time.perf_counter() - start, derivatives


def evaluate(derivatives: NodeDerivatives, n: int) -> dict[str, Callable[[], object]]:
    """Evaluate everything once at n nodes; return what does it again."""
    rng = np.random.default_rng(0)
    state = [rng.normal(size=(n, derivatives.function.size1_in(i))) for i in range(5)]
    lam = rng.normal(size=(n, derivatives.n_rows))
    calls: dict[str, Callable[[], object]] = {
        "values": lambda: derivatives.values(*state),
        "jacobian": lambda: derivatives.jacobian(*state)[1],
        "hessian": lambda: derivatives.hessian(lam, *state),
    }
    for call in calls.values():
        call()
    return calls


def side_by_side(subject: str, ours: NodeDerivatives, theirs: NodeDerivatives) -> Iterator[Row]:
    """Yield microseconds a node, how many times faster, and the largest difference."""
    calls, others = evaluate(ours, NODES), evaluate(theirs, NODES)
    for what in DERIVATIVES:
        one, two = calls[what], others[what]
        speed, slow = (best(each, k) for each, k in ((one, REPEATS), (two, 3)))
        yield Row(subject, f"{what}, vectors", 1e6 * speed / NODES, "us a node")
        yield Row(subject, f"{what}, interpreter", 1e6 * slow / NODES, "us a node")
        yield at_least(subject, f"{what}, times faster", slow / speed, MIN_SPEEDUP)
        a, b = np.asarray(one()), np.asarray(two())
        difference = float(np.abs(a - b).max() / np.abs(b).max())
        row = at_most(subject, f"{what}, difference by largest", difference, 1e-12)
        yield replace(row, note="of two roundings")


def best(call: Callable[[], object], repeats: int) -> float:
    """Return the seconds of the fastest call."""
    times = []
    for _ in range(repeats):
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return min(times)


@contextmanager
def empty_cache() -> Iterator[None]:
    """Keep files in a folder that is empty at first and gone afterwards."""
    name = "PLANTIGRADE_CACHE"
    before = os.environ.get(name)
    with tempfile.TemporaryDirectory() as folder:
        os.environ[name] = folder
        try:
            yield
        finally:
            os.environ.pop(name)
            if before is not None:
                os.environ[name] = before

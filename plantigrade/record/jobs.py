"""Independent runs in parallel: files, subjects, seeds, pushes.

loky does the work here, Ray or Dask on a cluster. Whatever goes wrong with one item is a row of the
result and never the end of the others, also where it kills the process that computes it.
"""

import os
import time
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from plantigrade.errors import ParameterError, PlantigradeError
from plantigrade.record.engines import ENGINES, Engine, WorkerDied

Item = TypeVar("Item")
Result = TypeVar("Result")

BACKENDS = tuple(ENGINES)
RETRIES = 2
"""Number of times an item is tried again after its worker died: once may be chance or another
item's fault, three times in a row is its own."""


@dataclass(frozen=True)
class Done(Generic[Item, Result]):
    """The result of one item.

    Attributes:
        item: The item.
        result: What the work returned; None where it failed.
        problem: Why it failed, in words; empty where it did not.
        seconds: How long it took [s].
    """

    item: Item
    result: Result | None
    problem: str = ""
    seconds: float = 0.0

    @property
    def ok(self) -> bool:
        """Whether there is a result."""
        return not self.problem


def run_jobs(
    work: Callable[[Item], Result],
    items: Iterable[Item],
    *,
    jobs: int = 1,
    backend: str = "loky",
    address: str | None = None,
) -> Iterator[Done[Item, Result]]:
    """Do the same work for every item and yield the results in order.

    An item whose worker dies is tried again, twice; what has finished is kept.

    Args:
        work: What is done; with more than one job it must be importable or picklable.
        items: What it is done for.
        jobs: How many at once; -1 for one per core.
        backend: ``loky`` (processes of this machine), ``ray`` or ``dask``.
        address: Of a running cluster (ray, dask); one on this machine is started if None.

    Raises:
        ParameterError: If the backend is unknown, ``jobs`` is zero, an address is given to a
            backend without one, or no cluster answers there.
        MissingExtra: If the library of the backend is not installed.

    Example:
        >>> [done.result for done in run_jobs(abs, [-1, 2])]
        [1, 2]
    """
    items = list(items)
    if backend not in BACKENDS:
        raise ParameterError(f"no backend {backend!r}; there are {', '.join(BACKENDS)}")
    if jobs == 0:
        raise ParameterError("jobs must be 1, 2, … or -1 for one per core, not 0")
    if address is not None and backend not in ("ray", "dask"):
        raise ParameterError(
            f"an address needs backend ray or dask; {backend} runs on this machine"
        )
    if jobs == 1 and backend == "loky":  # no other process is needed
        return (_attempt(work, item) for item in items)
    return _on(ENGINES[backend](jobs, address), work, items)


def _on(engine: Engine, work: Callable, items: list) -> Iterator[Done]:
    """Compute all items on an engine and yield what came of them in order.

    No more items are handed over than are computed at once, so that the items that were being
    computed when a worker died are known. Where that death ended several, each is tried again
    alone: the one that kills its worker then harms no other.
    """
    fresh, again = deque(range(len(items))), deque[int]()
    deaths: Counter[int] = Counter()
    running: dict[Any, int] = {}
    done: dict[int, Done] = {}
    following = 0
    try:
        while following < len(items):
            alone = bool(again) and engine.shares_fate
            while (again or fresh) and len(running) < (1 if alone else engine.workers):
                index = (again or fresh).popleft()
                try:
                    future = engine.submit(_attempt, work, items[index], os.getcwd())
                except Exception as error:  # a cluster that is gone takes no more items
                    done[index] = Done(items[index], None, f"{type(error).__name__}: {error}")
                else:
                    running[future] = index
            for future in engine.ended(running) if running else ():
                index = running.pop(future)
                try:
                    done[index] = engine.result(future)
                except WorkerDied as error:
                    deaths[index] += 1
                    if deaths[index] <= RETRIES:
                        again.append(index)
                        continue
                    problem = f"its worker process died {deaths[index]} times ({error})"
                    done[index] = Done(items[index], None, problem)
                except (
                    Exception
                ) as error:  # what cannot be sent to a worker, a cluster that is gone
                    done[index] = Done(items[index], None, f"{type(error).__name__}: {error}")
            while following in done:
                yield done.pop(following)
                following += 1
    finally:
        engine.close(finished=not running)


def _attempt(
    work: Callable[[Item], Result], item: Item, folder: str | None = None
) -> Done[Item, Result]:
    """Try one item, in the folder where it was asked for: processes that wait keep their own."""
    began = time.perf_counter()
    try:
        if folder is not None and os.path.isdir(folder):  # a cluster need not have it
            os.chdir(folder)
        return Done(item, work(item), "", time.perf_counter() - began)
    except (PlantigradeError, OSError) as error:
        problem = str(error) or type(error).__name__
    except Exception as error:  # a fault of a library in one item must not end the others
        problem = f"{type(error).__name__}: {error} (a fault of the program: please report it)"
    return Done(item, None, problem, time.perf_counter() - began)

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
IN_PROCESS = (1, "loky")  #: Number of jobs and backend that need no other process
RETRIES = 2
"""Number of times an item is tried again after its worker died: once may be chance or another
item's fault, three times in a row is its own."""


@dataclass(frozen=True)
class Done(Generic[Item, Result]):
    """The result of one item."""

    item: Item  #: The item
    result: Result | None  #: What the work returned; None where it failed
    problem: str = ""  #: Why it failed, in words; empty where it did not
    seconds: float = 0.0  #: How long it took [s]
    error: str = ""  #: Class of the error; empty where there is none

    @property
    def ok(self) -> bool:
        """Whether there is a result."""
        return not self.problem


class Workers:
    """Workers that stay for several calls, until the block ends.

    Args:
        jobs: How many items are computed at once; -1 for one per core.
        backend: ``loky`` (processes of this machine), ``ray`` or ``dask``.
        address: Of a running cluster (ray, dask); one on this machine is started if None.

    Raises:
        ParameterError: If the backend is unknown, ``jobs`` is zero, an address is given to a
            backend without one, or (where work begins) no cluster answers there.
        MissingExtra: If the library of the backend is not installed.

    Example:
        >>> with Workers() as workers:
        ...     [done.result for done in workers.run(abs, [-1, 2])]
        [1, 2]
    """

    def __init__(self, jobs: int = 1, backend: str = "loky", address: str | None = None):
        if backend not in BACKENDS:
            raise ParameterError(f"no backend {backend!r}; there are {', '.join(BACKENDS)}")
        if jobs == 0:
            raise ParameterError("jobs must be 1, 2, … or -1 for one per core, not 0")
        if address is not None and backend not in ("ray", "dask"):
            raise ParameterError(
                f"an address needs backend ray or dask; {backend} runs on this machine"
            )
        alone = (jobs, backend) == IN_PROCESS
        self._make = None if alone else (lambda: ENGINES[backend](jobs, address))
        self._engine: Engine | None = None

    def __enter__(self) -> "Workers":
        """Start with the first items."""
        return self

    def __exit__(self, *_: object) -> None:
        """Release the workers."""
        self._close(finished=True)

    @property
    def count(self) -> int:
        """Number of items that are computed at once."""
        engine = self._opened()
        return 1 if engine is None else engine.workers

    def run(
        self, work: Callable[[Item], Result], items: Iterable[Item], *, ordered: bool = True
    ) -> Iterator[Done[Item, Result]]:
        """Do the same work for every item and yield what came of each.

        An item whose worker dies is tried again, twice; what has finished is kept.

        Args:
            work: What is done; with more than one job it must be importable or picklable.
            items: What it is done for, taken as workers become free.
            ordered: Whether results come in the order of the items, or as they arrive.
        """
        engine = self._opened()
        if engine is None:  # no other process is needed
            return (_attempt(work, item) for item in items)
        return self._on(engine, work, iter(items), ordered)

    def _opened(self) -> Engine | None:
        if self._engine is None and self._make is not None:
            self._engine = self._make()
        return self._engine

    def _close(self, *, finished: bool) -> None:
        engine, self._engine = self._engine, None
        if engine is not None:
            engine.close(finished=finished)

    def _on(self, engine: Engine, work: Callable, items: Iterator, ordered: bool) -> Iterator[Done]:
        """Compute all items on an engine and yield what came of them.

        No more items are handed over than are computed at once, so that the items that were being
        computed when a worker died are known. Where that death ended several, each is tried again
        alone: the one that kills its worker then harms no other.
        """
        fresh, again = enumerate(items), deque[tuple[int, Any]]()
        deaths: Counter[int] = Counter()
        running: dict[Any, tuple[int, Any]] = {}
        done: dict[int, Done] = {}
        following, more = 0, True
        try:
            while more or again or running or done:
                alone = bool(again) and engine.shares_fate
                while (again or more) and len(running) < (1 if alone else engine.workers):
                    index, item = again.popleft() if again else next(fresh, (None, None))
                    if index is None:
                        more = False
                        break
                    try:
                        future = engine.submit(_attempt, work, item, os.getcwd())
                    except Exception as error:  # a cluster that is gone takes no more items
                        done[index] = Done(item, None, f"{type(error).__name__}: {error}")
                    else:
                        running[future] = index, item
                for future in engine.ended(running) if running else ():
                    index, item = running.pop(future)
                    try:
                        done[index] = engine.result(future)
                    except WorkerDied as error:
                        deaths[index] += 1
                        if deaths[index] <= RETRIES:
                            again.append((index, item))
                            continue
                        problem = f"its worker process died {deaths[index]} times ({error})"
                        done[index] = Done(item, None, problem)
                    except Exception as error:  # what cannot be sent to a worker
                        done[index] = Done(item, None, f"{type(error).__name__}: {error}")
                while done and (following in done or not ordered):
                    yield done.pop(following if ordered else next(iter(done)))
                    following += 1
        finally:
            if running:
                self._close(finished=False)


def run_jobs(
    work: Callable[[Item], Result],
    items: Iterable[Item],
    *,
    jobs: int = 1,
    backend: str = "loky",
    address: str | None = None,
) -> Iterator[Done[Item, Result]]:
    """Do the same work for every item and yield the results in order.

    The arguments are those of :class:`Workers` and :meth:`Workers.run`.

    Raises:
        ParameterError: If the backend is unknown, ``jobs`` is zero, an address is given to a
            backend without one, or no cluster answers there.
        MissingExtra: If the library of the backend is not installed.

    Example:
        >>> [done.result for done in run_jobs(abs, [-1, 2])]
        [1, 2]
    """
    workers = Workers(
        jobs, backend, address
    )  # invalid options are refused here, not at the first item

    def results() -> Iterator[Done[Item, Result]]:
        with workers:
            yield from workers.run(work, items)

    return results()


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
        problem, kind = str(error) or type(error).__name__, type(error).__name__
    except Exception as error:  # a fault of a library in one item must not end the others
        kind = type(error).__name__
        problem = f"{kind}: {error} (a fault of the program: please report it)"
    return Done(item, None, problem, time.perf_counter() - began, kind)

"""Independent runs in parallel: files, subjects, seeds, pushes.

joblib does the work, here or on a cluster (ray, dask). Whatever goes wrong with one item is a row
of the result and never the end of the others.
"""

import os
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from joblib import Parallel, delayed, parallel_config

from plantigrade.errors import ParameterError, PlantigradeError
from plantigrade.extras import require

Item = TypeVar("Item")
Result = TypeVar("Result")

BACKENDS = ("loky", "threading", "multiprocessing", "ray", "dask")
_PROCESSES = ("loky", "multiprocessing")  # on this machine, with folders of their own
_GENERATING = ("loky", "threading")  # hand over each result as soon as it is ready


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

    Args:
        work: What is done; with a backend of processes it must be importable or picklable.
        items: What it is done for.
        jobs: How many at once; -1 for one per core.
        backend: joblib's backend.
        address: Of a running cluster (ray, dask); one on this machine is started if None.

    Raises:
        ParameterError: If the backend is unknown, ``jobs`` is zero, or an address is given to a
            backend without one.
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
    _start(backend, address)
    return _parallel(work, items, jobs, backend)


def _parallel(work: Callable, items: list, jobs: int, backend: str) -> Iterator[Done]:
    with parallel_config(backend, n_jobs=jobs):
        how = "generator" if backend in _GENERATING else "list"
        folder = os.getcwd() if backend in _PROCESSES else None
        done: Any = Parallel(return_as=how)(delayed(_attempt)(work, item, folder) for item in items)
        yield from done


def _attempt(
    work: Callable[[Item], Result], item: Item, folder: str | None = None
) -> Done[Item, Result]:
    """Try one item, in the folder where it was asked for: processes that wait keep their own."""
    began = time.perf_counter()
    try:
        if folder is not None:
            os.chdir(folder)
        return Done(item, work(item), "", time.perf_counter() - began)
    except (PlantigradeError, OSError) as error:
        problem = str(error) or type(error).__name__
    except Exception as error:  # a fault of a library in one item must not end the others
        problem = f"{type(error).__name__}: {error} (a fault of the program: please report it)"
    return Done(item, None, problem, time.perf_counter() - began)


def _start(backend: str, address: str | None) -> None:
    """Make joblib know a backend that is not its own."""
    if backend == "ray":
        ray = require("ray", "ray")
        if not ray.is_initialized():
            ray.init(address=address, log_to_driver=False)
        require("ray.util.joblib", "ray").register_ray()
    elif backend == "dask":
        distributed = require("distributed", "dask")
        distributed.Client(address) if address else distributed.Client(processes=True)

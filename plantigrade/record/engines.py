"""Engines that compute independent items: processes of this machine (loky), or Ray, or Dask.

All three have one interface, so that what happens to an item whose worker died is decided in one
place, :mod:`plantigrade.record.jobs`.
"""

import os
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection
from concurrent.futures import FIRST_COMPLETED, wait
from typing import Any

from loky import cpu_count, get_reusable_executor
from loky.process_executor import BrokenProcessPool

from plantigrade.errors import ParameterError
from plantigrade.extras import require

ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
"""Environment of a worker: items run side by side, so each computes on one thread."""
IDLE_SECONDS = 60
"""Time after which an idle process ends [s]: long enough to be used by the next call."""
PARENT_CHECK_SECONDS = 1.0  # [s] interval at which a worker checks that its parent is alive
CONNECT_SECONDS = 10.0  # [s] time within which a Dask scheduler has to answer
TERMINATED = 143  # Exit code of a worker that outlived its parent: that of SIGTERM


class WorkerDied(Exception):
    """The worker that computed an item ended without a result."""


class Engine(ABC):
    """Computes items on several workers."""

    workers: int  #: Number of items that are computed at once
    shares_fate: bool  #: Whether the death of one worker ends the items of the other workers too

    @abstractmethod
    def submit(self, call: Callable[..., Any], *arguments: Any) -> Any:
        """Start a call on a worker and return its future."""

    @abstractmethod
    def ended(self, futures: Collection[Any]) -> Collection[Any]:
        """Wait until at least one of the futures has ended and return all that have."""

    @abstractmethod
    def result(self, future: Any) -> Any:
        """Return what the call of a future that has ended returned.

        Raises:
            WorkerDied: If its worker ended first.
        """

    @abstractmethod
    def close(self, *, finished: bool) -> None:
        """Release the workers; those that still compute are killed unless all has finished."""


class Processes(Engine):
    """Processes of this machine. They wait a while for the next call, since they start slowly.

    Args:
        jobs: Number of processes; -1 for one per core.
    """

    shares_fate = True

    def __init__(self, jobs: int):
        self.workers = jobs if jobs > 0 else cpu_count()

    def submit(self, call, *arguments):
        """Start a call; a pool that broke is replaced."""
        return self._pool().submit(call, *arguments)

    def ended(self, futures):
        """Wait for the first futures to end."""
        return wait(futures, return_when=FIRST_COMPLETED).done

    def result(self, future):
        """Return the result of a future that has ended."""
        try:
            return future.result()
        except BrokenProcessPool as error:
            raise WorkerDied("killed, or out of memory") from error

    def close(self, *, finished):
        """Keep idle processes for the next call; kill busy ones."""
        if not finished:
            self._pool().shutdown(wait=True, kill_workers=True)

    def _pool(self) -> Any:
        return get_reusable_executor(
            max_workers=self.workers,
            timeout=IDLE_SECONDS,
            initializer=end_with_parent,
            initargs=(os.getpid(),),
            env=ONE_THREAD,
        )


def end_with_parent(parent: int) -> None:
    """Make this process end soon after its parent has: its results are not needed."""

    def watch() -> None:
        while os.getppid() == parent:
            time.sleep(PARENT_CHECK_SECONDS)
        os._exit(TERMINATED)

    if os.name == "posix":  # elsewhere a process keeps the number of a parent that is gone
        threading.Thread(target=watch, daemon=True).start()


class Ray(Engine):
    """Tasks of Ray, on a running cluster or on one that is started on this machine.

    Args:
        jobs: Number of tasks at once; -1 for one per core of the cluster.
        address: Address of a running cluster; one is started on this machine if None.

    Raises:
        MissingExtra: If Ray is not installed.
        ParameterError: If no cluster answers at the address.
    """

    shares_fate = False

    def __init__(self, jobs: int, address: str | None):
        self._ray = require("ray", "ray")
        self._own = not self._ray.is_initialized()
        if self._own:
            cores = None if address else max(jobs, 1) if jobs > 0 else os.cpu_count()
            try:
                self._ray.init(
                    address=address or "local",
                    num_cpus=cores,
                    include_dashboard=None if address else False,
                    log_to_driver=False,
                    logging_level="ERROR",
                    runtime_env={"env_vars": ONE_THREAD},
                )
            except (ConnectionError, ValueError, RuntimeError) as error:
                raise ParameterError(_unanswered("Ray cluster", address, error)) from error
        self._tasks: dict[Callable[..., Any], Any] = {}
        everywhere = int(self._ray.cluster_resources().get("CPU", 1))
        self.workers = jobs if jobs > 0 else everywhere

    def submit(self, call, *arguments):
        """Start a task, which Ray itself does not repeat."""
        if call not in self._tasks:
            self._tasks[call] = self._ray.remote(max_retries=0, num_cpus=1)(call)
        return self._tasks[call].remote(*arguments)

    def ended(self, futures):
        """Wait for the first tasks to end."""
        return self._ray.wait(list(futures), num_returns=1)[0]

    def result(self, future):
        """Return the result of a task that has ended."""
        errors = self._ray.exceptions
        lost = (errors.WorkerCrashedError, errors.NodeDiedError, errors.OutOfMemoryError)
        try:
            return self._ray.get(future)
        except (*lost, errors.ObjectLostError) as error:
            raise WorkerDied(type(error).__name__) from error

    def close(self, *, finished):
        """Disconnect, which ends a cluster that was started here."""
        if self._own:
            self._ray.shutdown()


class Dask(Engine):
    """Tasks of Dask, on a running scheduler or on one that is started on this machine.

    Args:
        jobs: Number of tasks at once; -1 for one per thread of the cluster.
        address: Address of a running scheduler; one is started on this machine if None.

    Raises:
        MissingExtra: If Dask's distributed is not installed.
        ParameterError: If no scheduler answers at the address.
    """

    shares_fate = False

    def __init__(self, jobs: int, address: str | None):
        self._dask = require("distributed", "dask")
        require("dask", "dask").config.set({"distributed.scheduler.allowed-failures": 0})
        self._cluster = None
        if address is None:
            n_workers = jobs if jobs > 0 else os.cpu_count()
            self._cluster = self._dask.LocalCluster(
                n_workers=n_workers,
                threads_per_worker=1,
                dashboard_address="127.0.0.1:0",  # a free port
                silence_logs=50,  # only what is critical: a worker that dies is reported by us
                env=ONE_THREAD,
            )
        try:
            self._client = self._dask.Client(self._cluster or address, timeout=CONNECT_SECONDS)
        except (OSError, ValueError) as error:
            raise ParameterError(_unanswered("Dask scheduler", address, error)) from error
        everywhere = sum(self._client.nthreads().values()) or 1
        self.workers = jobs if jobs > 0 else everywhere

    def submit(self, call, *arguments):
        """Start a task."""
        return self._client.submit(call, *arguments, pure=False)

    def ended(self, futures):
        """Wait for the first tasks to end."""
        return self._dask.wait(list(futures), return_when="FIRST_COMPLETED").done

    def result(self, future):
        """Return the result of a task that has ended."""
        try:
            return future.result()
        except self._dask.scheduler.KilledWorker as error:
            raise WorkerDied("killed, or out of memory") from error

    def close(self, *, finished):
        """Disconnect, and end a cluster that was started here."""
        self._client.close()
        if self._cluster is not None:
            self._cluster.close()


def _unanswered(what: str, address: str | None, error: Exception) -> str:
    where = f"at {address}" if address else "on this machine"
    return f"no {what} {where} ({str(error).splitlines()[0]}); check --address, or leave it out"


ENGINES: dict[str, Callable[[int, str | None], Engine]] = {
    "loky": lambda jobs, address: Processes(jobs),
    "ray": Ray,
    "dask": Dask,
}
"""Every engine by name, made with the number of jobs and the address."""

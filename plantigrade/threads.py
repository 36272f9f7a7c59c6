"""One thread per solve.

The matrices of a human body are small: the worker threads of BLAS and OpenMP slow them down, and
sums taken in another order end in other last digits. The command line says so before NumPy is
loaded; here it is said to the libraries of a process that belongs to somebody else.
"""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

P = ParamSpec("P")
T = TypeVar("T")


def on_one_thread(work: Callable[P, T]) -> Callable[P, T]:
    """Return a function that does ``work`` on one thread, and leaves the libraries as they were."""

    @wraps(work)
    def limited(*args: P.args, **options: P.kwargs) -> T:
        with threadpool_limits(1):
            return work(*args, **options)

    return limited

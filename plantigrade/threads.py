"""Limit of numerical libraries to one thread.

The matrices of a human body are small: the worker threads of BLAS and OpenMP slow them down, and
sums in another order differ in the last digits. The command line limits them before NumPy is
loaded; this module limits them in processes that import the package.
"""

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

P = ParamSpec("P")
T = TypeVar("T")


def on_one_thread(work: Callable[P, T]) -> Callable[P, T]:
    """Return a function that runs ``work`` on one thread and restores the limits afterwards."""

    @wraps(work)
    def limited(*args: P.args, **options: P.kwargs) -> T:
        with threadpool_limits(1):
            return work(*args, **options)

    return limited

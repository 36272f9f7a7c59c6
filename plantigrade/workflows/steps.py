"""The interface through which a job reports its steps and their progress."""

import contextlib
from collections.abc import Callable

Step = Callable[[str], contextlib.AbstractContextManager[Callable[[float], None]]]
"""Opened around each step of a job, with its name; yields a function that is called with the share
of the step that is done."""


def silent(_: str) -> contextlib.AbstractContextManager[Callable[[float], None]]:
    """Show nothing of a step."""
    return contextlib.nullcontext(lambda share: None)

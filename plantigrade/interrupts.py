"""What a program does on Ctrl-C, or when the system asks it to end."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def on_signal(number: signal.Signals, act: Callable[..., None]) -> Iterator[None]:
    """Meanwhile call ``act`` on a signal; only the main thread can, others change nothing."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(number, act)
    try:
        yield
    finally:
        signal.signal(number, before)

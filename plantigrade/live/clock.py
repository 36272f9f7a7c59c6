"""Synchronisation of a simulation with real time."""

import time
from collections import deque
from collections.abc import Callable

MAX_LAG = 0.05  # [s] of simulated time; more is skipped, so that a slow machine stays responsive
WINDOW = 1.0  # [s] over which the speed is measured


class Clock:
    """Computes how much time is due to be simulated, and how well a simulation keeps up.

    Args:
        now: Function that returns real time [s].

    Attributes:
        time_lost: Simulated time skipped since the start [s].
    """

    def __init__(self, now: Callable[[], float] = time.monotonic):
        self._now, self._last, self._due, self.time_lost = now, now(), 0.0, 0.0
        self._window: deque[tuple[float, float, float]] = deque()

    def time_due(self, speed: float) -> float:
        """Return the time that is due to be simulated now [s].

        Args:
            speed: Simulated per real time; zero while paused.
        """
        now = self._now()
        passed, self._last = now - self._last, now
        if speed == 0.0:
            self._due = 0.0
            self._window.clear()
            return 0.0
        self._due += speed * passed
        given_up = max(self._due - MAX_LAG, 0.0)
        self.time_lost += given_up
        self._due -= given_up
        self._window.append((now, speed * passed, given_up))
        while now - self._window[0][0] > WINDOW:
            self._window.popleft()
        return self._due

    def mark_simulated(self, simulated: float) -> None:
        """Subtract time that was simulated [s]."""
        self._due -= simulated

    def begin(self) -> None:
        """Start now, with no time due."""
        self._last, self._due = self._now(), 0.0

    @property
    def real_time_factor(self) -> float:
        """Simulated time per due time in the last second; 1 while paused."""
        window = tuple(self._window)  # the simulation thread may change it
        due = sum(due for _, due, _ in window)
        return 1.0 - sum(lost for *_, lost in window) / due if due > 0.0 else 1.0


class LoopPace:
    """Keeps a loop at a rate; short delays are caught up, missed cycles are skipped.

    Args:
        rate: Cycles per second [1/s].
        now: Function that returns real time [s].
    """

    def __init__(self, rate: float, now: Callable[[], float] = time.monotonic):
        self._period, self._now, self._next = 1.0 / rate, now, now()

    def time_to_wait(self) -> float:
        """Return the time to wait until the next cycle [s]."""
        now = self._now()
        self._next += self._period
        if self._next < now - self._period:
            self._next = now
        return max(0.0, self._next - now)
